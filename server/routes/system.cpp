#include <algorithm>

#include "protocol/openapi.h"
#include "protocol/param_json.h"
#include "renderer/error/metric.h"
#include "renderer/film/layer_preview.h"
#include "renderer/methods/registry.h"
#include "server/routes/dashboard.h"
#include "server/routes/query.h"
#include "server/routes/routes.h"

namespace photond::http {
namespace {

using nlohmann::json;

json strings(const auto& views) {
    json list = json::array();
    for (const std::string_view view : views) list.push_back(view);
    return list;
}

json method_json(const MethodInfo& method) {
    json deterministic = json::object();
    for (const std::string_view kind : method.devices)
        deterministic[std::string(kind)] = kind == "cpu" ? method.deterministic_cpu : method.deterministic_gpu;
    json artefacts = json::array();
    for (const ArtefactInfo& artefact : method.artefacts)
        artefacts.push_back({{"name", artefact.name},
                             {"media_type", artefact.media_type},
                             {"parameter", artefact.parameter},
                             {"description", artefact.text}});
    return {{"name", method.name},
            {"title", method.title},
            {"family", method.family},
            {"devices", strings(method.devices)},
            {"sources", strings(method.sources)},
            {"mergeable", method.mergeable},
            {"deterministic", deterministic},
            {"layers", method.layers_on_request()},
            {"artefacts", artefacts},
            {"parameters", params_schema(*method.make_params())}};
}

// By name; a handful, never more than one page of them.
Reply list_methods(Call& call) {
    Query query(call.query);
    const uint32_t limit = query.integer("limit", 100);
    const std::string cursor = query.text("cursor");
    query.finish();
    if (limit < 1 || limit > 1000)
        throw Error(ErrorCode::OutOfRange, "/limit", "limit = " + std::to_string(limit) + " is outside [1, 1000]");
    std::vector<const MethodInfo*> methods;
    for (const MethodInfo& method : all_methods())
        if (method.name > cursor) methods.push_back(&method);
    std::sort(methods.begin(), methods.end(),
              [](const MethodInfo* a, const MethodInfo* b) { return a->name < b->name; });
    json items = json::array();
    for (size_t i = 0; i < std::min<size_t>(limit, methods.size()); ++i) items.push_back(method_json(*methods[i]));
    const bool more = methods.size() > limit;
    return json_reply(200, {{"items", items}, {"next_cursor", more ? json(methods[limit - 1]->name) : json(nullptr)}});
}

Reply get_method(Call& call) {
    Query(call.query).finish();
    const std::string& name = call.path_parameters[0];
    if (const MethodInfo* method = find_method(name)) return json_reply(200, method_json(*method));
    std::vector<std::string> known;
    for (const MethodInfo& method : all_methods()) known.emplace_back(method.name);
    throw Error(ErrorCode::NotFound, "there is no method " + value_text(name) + did_you_mean(name, known));
}

Reply text_reply(int status, std::string text, const char* media_type) {
    Reply reply;
    reply.status = status;
    reply.body = std::move(text);
    reply.media_type = media_type;
    reply.headers["Cache-Control"] = "no-store";
    return reply;
}

std::string openapi_text(const Service& service) {
    ApiVocabulary vocabulary;
    vocabulary.version = PHOTOND_VERSION;
    for (const MethodInfo& method : all_methods())
        vocabulary.methods.push_back(
            {std::string(method.name), params_schema(*method.make_params()), method.layers_on_request()});
    for (const ArtefactInfo& artefact : all_artefacts())
        vocabulary.artefacts.push_back(
            {std::string(artefact.name), std::string(artefact.media_type), std::string(artefact.text)});
    vocabulary.layers = service.vocabulary().layer_names;
    vocabulary.metrics = service.vocabulary().metric_names;
    for (const MetricInfo& metric : kMetrics)
        if (metric.needs_reference) vocabulary.image_metrics.emplace_back(metric.name);
    vocabulary.radiance_layers = service.vocabulary().radiance_layers;
    for (const LayerInfo& info : kLayers)
        if (preview_of(info) != LayerPreview::None) vocabulary.preview_layers.emplace_back(info.name);
    vocabulary.pages.assign(std::begin(kDashboardPages), std::end(kDashboardPages));
    vocabulary.max_width = service.vocabulary().max_width;
    vocabulary.max_height = service.vocabulary().max_height;
    return openapi_document(vocabulary).dump(2) + "\n";
}

}  // namespace

void add_system_routes(std::vector<Route>& routes, Service& service) {
    const auto get = [&routes](const char* pattern, std::function<Reply(Call&)> handle) -> Route& {
        routes.push_back({.method = "GET", .pattern = pattern, .handle = std::move(handle)});
        return routes.back();
    };
    get("/v1/methods", list_methods);
    get("/v1/methods/{name}", get_method);
    get("/v1/devices", [&service](Call& call) {
        Query(call.query).finish();
        return json_reply(200, service.devices());
    });
    get("/v1/status", [&service](Call& call) {
        Query(call.query).finish();
        return json_reply(200, service.status());
    });
    get("/metrics", [&service](Call&) {
        return text_reply(200, service.metrics_text(), "text/plain; version=0.0.4; charset=utf-8");
    });
    get("/v1/openapi.json", [text = openapi_text(service)](Call&) {
        return text_reply(200, text, "application/json");
    }).open = true;
    // Liveness and readiness come from atomics, on the hub's own thread: whatever else waits, these do not.
    Route& alive = get("/healthz", [](Call&) { return json_reply(200, {{"status", "alive"}}); });
    alive.open = true;
    alive.lane = Lane::Instant;
    Route& ready = get("/readyz", [&service](Call&) {
        if (!service.ready())
            throw Refusal{Error(ErrorCode::Unavailable, "the daemon is starting or stopping"), {{"Retry-After", "1"}}};
        return json_reply(200, {{"status", "ready"}});
    });
    ready.open = true;
    ready.lane = Lane::Instant;
}

}  // namespace photond::http
