#include "protocol/comparison.h"

#include <charconv>

#include "server/routes/file_reply.h"
#include "server/routes/job_group_routes.h"

namespace photond::http {
namespace {

uint32_t row_index(const std::string& text) {
    uint32_t index = 0;
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), index);
    if (fault != std::errc() || end != text.data() + text.size())
        throw Error(ErrorCode::NotFound, "'" + text + "' is no row of a table: 0, 1, ...");
    return index;
}

}  // namespace

void add_comparison_routes(std::vector<Route>& all, Service& service) {
    const LongRoutes routes(all);
    add_job_group_routes<ComparisonRequest>(routes, service,
                                            {.path = "/v1/comparisons",
                                             .parse = parse_comparison_request,
                                             .estimate = &Service::estimate_comparison,
                                             .submit = &Service::submit_comparison,
                                             .list = &Service::list_comparisons,
                                             .get = &Service::get_comparison,
                                             .cancel = &Service::cancel_comparison,
                                             .purge = &Service::purge_comparison});
    routes.add("PATCH", "/v1/comparisons/{id}", BodyKind::Json, [&service](Call& call) {
        Query(call.query).finish();
        return json_reply(200, service.change_comparison(call.path_parameters[0], parse_strict_json(call.body)));
    });
    const auto add_map = [&](const char* pattern,
                             Artefact (Service::*map)(const std::string&, uint32_t, const std::string&)) {
        routes.add("GET", pattern, BodyKind::None, [&service, map](Call& call) {
            Query query(call.query);
            const std::string layer = query.text("layer", "beauty");
            query.finish();
            return file_reply(call, (service.*map)(call.path_parameters[0], row_index(call.path_parameters[1]), layer));
        });
    };
    add_map("/v1/comparisons/{id}/rows/{index}/bias.json", &Service::bias_map);
    add_map("/v1/comparisons/{id}/rows/{index}/bias.png", &Service::bias_picture);
    const auto add_report = [&](const char* pattern, Artefact (Service::*report)(const std::string&)) {
        routes.add("GET", pattern, BodyKind::None, [&service, report](Call& call) {
            Query(call.query).finish();
            return file_reply(call, (service.*report)(call.path_parameters[0]));
        });
    };
    add_report("/v1/comparisons/{id}/report.json", &Service::comparison_json);
    add_report("/v1/comparisons/{id}/report.csv", &Service::comparison_csv);
    add_report("/v1/comparisons/{id}/report.html", &Service::comparison_html);
}

}  // namespace photond::http
