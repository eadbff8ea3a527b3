#include "renderer/methods/registry.h"
#include "server/routes/file_reply.h"
#include "server/routes/job_wait.h"
#include "server/routes/query.h"
#include "server/routes/routes.h"
#include "server/try_later.h"

namespace photond::http {
namespace {

/// Of a request for what a job leaves. Where it says how long it waits, its answer is of a job that is over, or none.
class ArtefactQuery : public Query {
public:
    ArtefactQuery(Service& service, const Call& call)
        : Query(call.query), service_(service), call_(call), wait_(JobWait::read(*this)) {}

    /// And waits, once nothing is wrong with the request.
    void finish() {
        Query::finish();
        if (!wait_.seconds) return;
        const nlohmann::json job = wait_for_job(service_, call_, call_.path_parameters[0], wait_);
        if (!says_that_it_is_over(job))
            throw TryLater(job.at("id").get<std::string>() + " is " + job.at("state").get<std::string>() +
                               " still: the request's wait is over",
                           1);
    }

private:
    Service& service_;
    const Call& call_;
    const JobWait wait_;
};

}  // namespace

void add_artefact_routes(std::vector<Route>& routes, Service& service) {
    const auto add = [&routes, &service](const std::string& file, Lane lane,
                                         std::function<Artefact(Call&, ArtefactQuery&)> make) {
        routes.push_back({.method = "GET",
                          .pattern = "/v1/jobs/{id}/" + file,
                          .lane = lane,
                          .handle = [&service, make = std::move(make)](Call& call) {
                              ArtefactQuery query(service, call);
                              return file_reply(call, make(call, query));
                          }});
    };
    add("image.exr", Lane::Helper, [&service](Call& call, ArtefactQuery& query) {
        const std::string precision = query.text("precision", "float");
        query.finish();
        return service.image(call.path_parameters[0], precision);
    });
    add("preview.png", Lane::Helper, [&service](Call& call, ArtefactQuery& query) {
        Service::PreviewWanted wanted;
        wanted.layer = query.text("layer", wanted.layer);
        wanted.exposure_stops = query.number("exposure", wanted.exposure_stops);
        wanted.curve = query.text("curve", wanted.curve);
        wanted.max_size = query.integer("max_size");
        query.finish();
        return service.preview(call.path_parameters[0], wanted);
    });
    add("pixels", Lane::Helper, [&service](Call& call, ArtefactQuery& query) {
        const std::string layer = query.text("layer");
        const std::string precision = query.text("precision", "float");
        query.finish();
        return service.pixels(call.path_parameters[0], layer, precision);
    });
    add("statistics.json", Lane::Quick, [&service](Call& call, ArtefactQuery& query) {
        query.finish();
        return service.statistics(call.path_parameters[0]);
    });
    add("curve.csv", Lane::Quick, [&service](Call& call, ArtefactQuery& query) {
        query.finish();
        return service.curve(call.path_parameters[0]);
    });
    add("difference.exr", Lane::Helper, [&service](Call& call, ArtefactQuery& query) {
        query.finish();
        return service.difference(call.path_parameters[0]);
    });
    add("flip.png", Lane::Helper, [&service](Call& call, ArtefactQuery& query) {
        const std::string layer = query.text("layer", "beauty");
        const std::string range = query.text("range", "hdr");
        query.finish();
        return service.flip(call.path_parameters[0], layer, range);
    });
    add("error.png", Lane::Helper, [&service](Call& call, ArtefactQuery& query) {
        const std::string layer = query.text("layer", "beauty");
        query.finish();
        return service.error_map(call.path_parameters[0], layer);
    });
    add("film", Lane::Long, [&service](Call& call, ArtefactQuery& query) {
        query.finish();
        return service.film(call.path_parameters[0]);
    });
    add("log.txt", Lane::Quick, [&service](Call& call, ArtefactQuery& query) {
        query.finish();
        return service.log(call.path_parameters[0]);
    });
    for (const ArtefactInfo& artefact : all_artefacts())
        add(std::string(artefact.name), Lane::Long,
            [&service, name = std::string(artefact.name)](Call& call, ArtefactQuery& query) {
                query.finish();
                return service.method_artefact(call.path_parameters[0], name);
            });
}

}  // namespace photond::http
