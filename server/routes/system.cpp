#include <algorithm>

#include "protocol/openapi.h"
#include "protocol/param_json.h"
#include "renderer/error/metric.h"
#include "renderer/methods/registry.h"
#include "server/routes/dashboard.h"
#include "server/routes/query.h"
#include "server/routes/routes.h"

namespace photond::http {
namespace {

using nlohmann::json;

json settings_json(const std::vector<ParamSetting>& settings) {
    json parameters = json::object();
    for (const ParamSetting& setting : settings) parameters[std::string(setting.name)] = setting.word;
    return parameters;
}

json hard_cases_json(const MethodInfo& method) {
    json variants = json::array(), limits = json::array();
    for (const MethodVariant& variant : method.variants)
        variants.push_back({{"label", variant.label}, {"parameters", settings_json(variant.settings)}});
    for (const KnownLimit& limit : method.limits)
        limits.push_back({{"parameters", settings_json(limit.settings)}, {"row", limit.row}, {"text", limit.text}});
    return {{"variants", variants}, {"limits", limits}};
}

json method_json(const MethodInfo& method) {
    json devices = json::array(), deterministic = json::object(), sources = json::array();
    for (const Source& source : method.sources) sources.push_back(source.text());
    for (const std::string_view kind : method.devices()) {
        devices.push_back(kind);
        deterministic[std::string(kind)] = kind == "cpu" ? method.deterministic_cpu : method.deterministic_gpu;
    }
    json artefacts = json::array();
    for (const ArtefactInfo& artefact : method.artefacts)
        artefacts.push_back({{"name", artefact.name},
                             {"media_type", artefact.media_type},
                             {"parameter", artefact.parameter},
                             {"description", artefact.text}});
    return {{"name", method.name},
            {"title", method.title},
            {"line", method.line},
            {"family", method.family},
            {"devices", devices},
            {"sources", sources},
            {"mergeable", method.mergeable},
            {"deterministic", deterministic},
            {"layers", method.layers_on_request()},
            {"artefacts", artefacts},
            {"hard_cases", hard_cases_json(method)},
            {"parameters", params_schema(*method.make_params())}};
}

/// A page of a short list; the cursor is the name of the last item of the page before.
Reply page_of(Call& call, const json& all) {
    Query query(call.query);
    const uint32_t limit = query.integer("limit", 100);
    const std::string cursor = query.text("cursor");
    query.finish();
    if (limit < 1 || limit > 1000)
        throw Error(ErrorCode::OutOfRange, "/limit", "limit = " + std::to_string(limit) + " is outside [1, 1000]");
    auto first = all.begin();
    if (!cursor.empty()) {
        first = std::find_if(all.begin(), all.end(), [&](const json& item) { return item.at("name") == cursor; });
        if (first == all.end())
            throw Error(ErrorCode::OutOfRange, "/cursor", "'" + cursor + "' is no cursor of this list");
        ++first;
    }
    const auto end = first + std::min<std::ptrdiff_t>(limit, all.end() - first);
    return json_reply(
        200, {{"items", json(first, end)}, {"next_cursor", end == all.end() ? json(nullptr) : (end - 1)->at("name")}});
}

Reply list_methods(Call& call) {
    json items = json::array();
    for (const MethodInfo& method : all_methods()) items.push_back(method_json(method));
    return page_of(call, items);
}

Reply get_method(Call& call) {
    Query(call.query).finish();
    const std::string& name = call.path_parameters[0];
    if (const MethodInfo* method = find_method(name)) return json_reply(200, method_json(*method));
    std::vector<std::string> known;
    for (const MethodInfo& method : all_methods()) known.emplace_back(method.name);
    throw Error(ErrorCode::NotFound, "there is no method " + value_text(name) + did_you_mean(name, known));
}

std::string_view preview_name(LayerPreview preview) {
    switch (preview) {
        case LayerPreview::Light: return "light";
        case LayerPreview::HeatMap: return "heat_map";
        case LayerPreview::Directions: return "directions";
        case LayerPreview::Dots: return "dots";
        case LayerPreview::Scale: return "scale";
        case LayerPreview::Signed: return "signed";
        case LayerPreview::None: break;
    }
    return "";
}

Reply list_layers(Call& call) {
    const auto row = [](std::string_view name, std::string_view channels, bool always, bool measured,
                        LayerPreview preview, std::string_view unit, std::string_view text) {
        const std::string_view shown = preview_name(preview);
        return json{{"name", name},
                    {"channels", channels},
                    {"always", always},
                    {"measured", measured},
                    {"preview", shown.empty() ? json(nullptr) : json(shown)},
                    {"exposure", has_exposure(preview)},
                    {"unit", unit},
                    {"description", text}};
    };
    const LayerInfo& light = layer_info(Layer::Emitted);
    json items = json::array({row("beauty", light.channels, true, true, light.preview, light.unit,
                                  "all light: emitted, direct and indirect together")});
    for (const LayerInfo& info : kLayers)
        items.push_back(row(info.name, info.channels, LayerSet().has(info.layer), info.radiance(), info.preview,
                            info.unit, info.text));
    return page_of(call, items);
}

Reply list_metrics(Call& call) {
    json items = json::array();
    for (const MetricInfo& info : kMetrics)
        items.push_back({{"name", info.name},
                         {"title", info.title},
                         {"values", info.values},
                         {"needs_reference", info.needs_reference},
                         {"on_request", info.costly},
                         {"slope", info.slope == 0 ? json(nullptr) : json(info.slope)},
                         {"description", info.text},
                         {"line", info.line.empty() ? json(nullptr) : json(info.line)}});
    return page_of(call, items);
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
    vocabulary.always_layers = service.vocabulary().always_layers;
    vocabulary.layers = service.vocabulary().layer_names;
    vocabulary.metrics = service.vocabulary().metric_names;
    for (const MetricInfo& metric : kMetrics)
        if (metric.needs_reference) vocabulary.image_metrics.emplace_back(metric.name);
    vocabulary.radiance_layers = service.vocabulary().radiance_layers;
    for (const LayerInfo& info : kLayers)
        if (info.preview != LayerPreview::None) vocabulary.preview_layers.emplace_back(info.name);
    vocabulary.pages.assign(std::begin(kDashboardPages), std::end(kDashboardPages));
    vocabulary.max_width = service.vocabulary().max_width;
    vocabulary.max_height = service.vocabulary().max_height;
    vocabulary.max_pixels = service.options().limits.max_pixels;
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
    get("/v1/layers", list_layers);
    get("/v1/metrics", list_metrics);
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
        if (const Readiness readiness = service.readiness(); !readiness.ready())
            throw Refusal{Error(ErrorCode::Unavailable, readiness.why_not), {{"Retry-After", "1"}}};
        return json_reply(200, {{"status", "ready"}});
    });
    ready.open = true;
    ready.lane = Lane::Instant;
}

}  // namespace photond::http
