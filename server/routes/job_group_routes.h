#pragma once
// What can be done with a comparison and with a sequence alike: estimated, queued, listed, read, cancelled and removed.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "protocol/strict_json.h"
#include "server/routes/idempotency.h"
#include "server/routes/query.h"
#include "server/routes/routes.h"

namespace photond::http {

template <class Request>
struct JobGroupOperations {
    std::string path;  // of all of them
    Request (*parse)(const nlohmann::json& body, const JobVocabulary& vocabulary);
    nlohmann::json (Service::*estimate)(const Request& request);
    nlohmann::json (Service::*submit)(const Request& request, const std::optional<std::string>& key);
    Page (Service::*list)(uint32_t limit, const std::string& cursor);
    nlohmann::json (Service::*get)(const std::string& id);  // none: added apart
    Service::Cancelled (Service::*cancel)(const std::string& id);
    Service::Cancelled (Service::*purge)(const std::string& id);
};

/// Adds routes whose jobs, a thousand or more, are judged, written and read together: too long for the threads that
/// answer at once.
class LongRoutes {
public:
    explicit LongRoutes(std::vector<Route>& routes) : routes_(routes) {}

    void add(const char* method, const std::string& pattern, BodyKind body, std::function<Reply(Call&)> handle) const {
        routes_.push_back(
            {.method = method, .pattern = pattern, .body = body, .lane = Lane::Long, .handle = std::move(handle)});
    }

private:
    std::vector<Route>& routes_;
};

template <class Request>
void add_job_group_routes(const LongRoutes& routes, Service& service, const JobGroupOperations<Request>& of) {
    routes.add("POST", of.path, BodyKind::Json, [&service, of](Call& call) {
        Query query(call.query);
        const bool dry_run = query.flag("dry_run");
        query.finish();
        const Request request = of.parse(parse_strict_json(call.body), service.vocabulary());
        const std::optional<std::string> key = idempotency_key(call);
        if (dry_run) return json_reply(200, (service.*of.estimate)(request));
        const nlohmann::json group = (service.*of.submit)(request, key);
        Reply reply = json_reply(202, group);
        reply.headers["Location"] = of.path + "/" + group.at("id").get<std::string>();
        return reply;
    });
    routes.add("GET", of.path, BodyKind::None, [&service, of](Call& call) {
        Query query(call.query);
        const uint32_t limit = query.integer("limit", 100);
        const std::string cursor = query.text("cursor");
        query.finish();
        return json_reply(200, (service.*of.list)(limit, cursor));
    });
    if (of.get)
        routes.add("GET", of.path + "/{id}", BodyKind::None, [&service, of](Call& call) {
            Query(call.query).finish();
            return json_reply(200, (service.*of.get)(call.path_parameters[0]));
        });
    routes.add("DELETE", of.path + "/{id}", BodyKind::None, [&service, of](Call& call) {
        Query query(call.query);
        const bool purge = query.flag("purge");
        query.finish();
        const Service::Cancelled cancelled = (service.*(purge ? of.purge : of.cancel))(call.path_parameters[0]);
        return json_reply(cancelled.was_over ? 200 : 202, cancelled.object);
    });
}

}  // namespace photond::http
