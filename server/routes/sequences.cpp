#include "protocol/sequence.h"

#include "server/routes/file_reply.h"
#include "server/routes/job_group_routes.h"

namespace photond::http {

void add_sequence_routes(std::vector<Route>& all, Service& service) {
    const LongRoutes routes(all);
    add_job_group_routes<SequenceRequest>(routes, service,
                                          {.path = "/v1/sequences",
                                           .parse = parse_sequence_request,
                                           .estimate = &Service::estimate_sequence,
                                           .submit = &Service::submit_sequence,
                                           .list = &Service::list_sequences,
                                           .get = nullptr,
                                           .cancel = &Service::cancel_sequence,
                                           .purge = &Service::purge_sequence});
    routes.add("GET", "/v1/sequences/{id}", BodyKind::None, [&service](Call& call) {
        Query query(call.query);
        const bool with_frames = query.flag("frames", true);
        query.finish();
        return json_reply(200, service.get_sequence(call.path_parameters[0], with_frames));
    });
    routes.add("GET", "/v1/sequences/{id}/frames.zip", BodyKind::None, [&service](Call& call) {
        Query query(call.query);
        const std::string images = query.text("images", "exr");
        query.finish();
        return file_reply(call, service.sequence_zip(call.path_parameters[0], images));
    });
    routes.add("GET", "/v1/sequences/{id}/video", BodyKind::None, [&service](Call& call) {
        Query query(call.query);
        Service::VideoWanted wanted;
        wanted.format = query.text("format", wanted.format);
        wanted.fps = query.number("fps");
        wanted.exposure_stops = query.number("exposure", wanted.exposure_stops);
        wanted.curve = query.text("curve", wanted.curve);
        query.finish();
        return file_reply(call, service.sequence_video(call.path_parameters[0], wanted));
    });
    routes.add("GET", "/v1/sequences/{id}/report.html", BodyKind::None, [&service](Call& call) {
        Query query(call.query);
        Service::SequenceReportWanted wanted;
        wanted.first = query.text("first"), wanted.second = query.text("second");
        wanted.layer = query.text("layer", wanted.layer);
        wanted.beside = query.list("beside");
        query.finish();
        return file_reply(call, service.sequence_html(call.path_parameters[0], wanted));
    });
    routes.add("GET", "/v1/sequences/{id}/errors", BodyKind::None, [&service](Call& call) {
        Query query(call.query);
        const std::string first = query.text("first"), second = query.text("second");
        const std::string layer = query.text("layer", "beauty");
        query.finish();
        return json_reply(200, service.sequence_errors(call.path_parameters[0], first, second, layer));
    });
}

}  // namespace photond::http
