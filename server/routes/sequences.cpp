#include "protocol/sequence.h"

#include "protocol/strict_json.h"
#include "server/routes/file_reply.h"
#include "server/routes/idempotency.h"
#include "server/routes/query.h"
#include "server/routes/routes.h"

namespace photond::http {
namespace {

Reply submit_sequence(Service& service, Call& call) {
    Query query(call.query);
    const bool dry_run = query.flag("dry_run");
    query.finish();
    const SequenceRequest request = parse_sequence_request(parse_strict_json(call.body), service.vocabulary());
    const std::optional<std::string> key = idempotency_key(call);
    if (dry_run) return json_reply(200, service.estimate_sequence(request));
    const nlohmann::json sequence = service.submit_sequence(request, key);
    Reply reply = json_reply(202, sequence);
    reply.headers["Location"] = "/v1/sequences/" + sequence.at("id").get<std::string>();
    return reply;
}

Reply list_sequences(Service& service, Call& call) {
    Query query(call.query);
    const uint32_t limit = query.integer("limit", 100);
    const std::string cursor = query.text("cursor");
    query.finish();
    return json_reply(200, service.list_sequences(limit, cursor));
}

Reply remove_sequence(Service& service, Call& call) {
    Query query(call.query);
    const bool purge = query.flag("purge");
    query.finish();
    const Service::Cancelled cancelled =
        purge ? service.purge_sequence(call.path_parameters[0]) : service.cancel_sequence(call.path_parameters[0]);
    return json_reply(cancelled.was_over ? 200 : 202, cancelled.object);
}

}  // namespace

void add_sequence_routes(std::vector<Route>& routes, Service& service) {
    // Thousands of frames are judged, written and read together: too long for the threads that answer at once.
    const auto add = [&](const char* method, const char* pattern, BodyKind body, Reply (*handle)(Service&, Call&)) {
        routes.push_back({.method = method,
                          .pattern = pattern,
                          .body = body,
                          .lane = Lane::Long,
                          .handle = [&service, handle](Call& call) { return handle(service, call); }});
    };
    add("POST", "/v1/sequences", BodyKind::Json, submit_sequence);
    add("GET", "/v1/sequences", BodyKind::None, list_sequences);
    add("GET", "/v1/sequences/{id}", BodyKind::None, [](Service& of, Call& call) {
        Query(call.query).finish();
        return json_reply(200, of.get_sequence(call.path_parameters[0]));
    });
    add("GET", "/v1/sequences/{id}/frames.zip", BodyKind::None, [](Service& of, Call& call) {
        Query query(call.query);
        const std::string images = query.text("images", "exr");
        query.finish();
        return file_reply(call, of.sequence_zip(call.path_parameters[0], images));
    });
    add("GET", "/v1/sequences/{id}/errors", BodyKind::None, [](Service& of, Call& call) {
        Query query(call.query);
        const std::string first = query.text("first"), second = query.text("second");
        const std::string layer = query.text("layer", "beauty");
        query.finish();
        return json_reply(200, of.sequence_errors(call.path_parameters[0], first, second, layer));
    });
    add("DELETE", "/v1/sequences/{id}", BodyKind::None, remove_sequence);
}

}  // namespace photond::http
