#include "protocol/comparison.h"

#include <charconv>

#include "protocol/strict_json.h"
#include "server/routes/file_reply.h"
#include "server/routes/idempotency.h"
#include "server/routes/query.h"
#include "server/routes/routes.h"

namespace photond::http {
namespace {

Reply submit_comparison(Service& service, Call& call) {
    Query query(call.query);
    const bool dry_run = query.flag("dry_run");
    query.finish();
    const ComparisonRequest request = parse_comparison_request(parse_strict_json(call.body), service.vocabulary());
    const std::optional<std::string> key = idempotency_key(call);
    if (dry_run) return json_reply(200, service.estimate_comparison(request));
    const nlohmann::json comparison = service.submit_comparison(request, key);
    Reply reply = json_reply(202, comparison);
    reply.headers["Location"] = "/v1/comparisons/" + comparison.at("id").get<std::string>();
    return reply;
}

Reply list_comparisons(Service& service, Call& call) {
    Query query(call.query);
    const uint32_t limit = query.integer("limit", 100);
    const std::string cursor = query.text("cursor");
    query.finish();
    return json_reply(200, service.list_comparisons(limit, cursor));
}

Reply remove_comparison(Service& service, Call& call) {
    Query query(call.query);
    const bool purge = query.flag("purge");
    query.finish();
    const Service::Cancelled cancelled =
        purge ? service.purge_comparison(call.path_parameters[0]) : service.cancel_comparison(call.path_parameters[0]);
    return json_reply(cancelled.was_over ? 200 : 202, cancelled.object);
}

uint32_t row_index(const std::string& text) {
    uint32_t index = 0;
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), index);
    if (fault != std::errc() || end != text.data() + text.size())
        throw Error(ErrorCode::NotFound, "'" + text + "' is no row of a table: 0, 1, ...");
    return index;
}

}  // namespace

void add_comparison_routes(std::vector<Route>& routes, Service& service) {
    // A thousand jobs are judged, written and read together: too long for the threads that answer at once.
    const auto add = [&routes](const char* method, const char* pattern, BodyKind body,
                               std::function<Reply(Call&)> handle) {
        routes.push_back(
            {.method = method, .pattern = pattern, .body = body, .lane = Lane::Long, .handle = std::move(handle)});
    };
    add("POST", "/v1/comparisons", BodyKind::Json, [&service](Call& call) { return submit_comparison(service, call); });
    add("GET", "/v1/comparisons", BodyKind::None, [&service](Call& call) { return list_comparisons(service, call); });
    add("GET", "/v1/comparisons/{id}", BodyKind::None, [&service](Call& call) {
        Query(call.query).finish();
        return json_reply(200, service.get_comparison(call.path_parameters[0]));
    });
    add("DELETE", "/v1/comparisons/{id}", BodyKind::None,
        [&service](Call& call) { return remove_comparison(service, call); });
    const auto add_map = [&](const char* pattern,
                             Artefact (Service::*map)(const std::string&, uint32_t, const std::string&)) {
        add("GET", pattern, BodyKind::None, [&service, map](Call& call) {
            Query query(call.query);
            const std::string layer = query.text("layer", "beauty");
            query.finish();
            return file_reply(call, (service.*map)(call.path_parameters[0], row_index(call.path_parameters[1]), layer));
        });
    };
    add_map("/v1/comparisons/{id}/rows/{index}/bias.json", &Service::bias_map);
    add_map("/v1/comparisons/{id}/rows/{index}/bias.png", &Service::bias_picture);
    const auto add_report = [&](const char* pattern, Artefact (Service::*report)(const std::string&)) {
        add("GET", pattern, BodyKind::None, [&service, report](Call& call) {
            Query(call.query).finish();
            return file_reply(call, (service.*report)(call.path_parameters[0]));
        });
    };
    add_report("/v1/comparisons/{id}/report.json", &Service::comparison_json);
    add_report("/v1/comparisons/{id}/report.csv", &Service::comparison_csv);
    add_report("/v1/comparisons/{id}/report.html", &Service::comparison_html);
}

}  // namespace photond::http
