#include "server/left_out_json.h"

#include <vector>

#include "renderer/methods/registry.h"
#include "server/method_params.h"

namespace photond {

using nlohmann::json;

namespace {

std::optional<PathsLeftOut> left_out_read(const json& list) {
    if (!list.is_array()) return std::nullopt;
    std::vector<PathKind> kinds;
    uint32_t most_bounces = PathsLeftOut::kAllBounces;
    for (const json& item : list) {
        const std::string name = item.value("kind", "");
        for (const PathKindInfo& info : kPathKinds)
            if (info.name == name) kinds.push_back(info.kind);
        if (const json most = item.value("most_bounces", json()); most.is_number_unsigned())
            most_bounces = most.get<uint32_t>();
    }
    PathsLeftOut left_out(most_bounces);
    for (const PathKind kind : kinds) left_out.add(kind);
    return left_out;
}

}  // namespace

json to_json(const PathsLeftOut& left_out) {
    json list = json::array();
    for (const PathKind kind : left_out.kinds())
        list.push_back({{"kind", kPathKinds[static_cast<size_t>(kind)].name},
                        {"text", left_out.text(kind)},
                        {"most_bounces", kind == PathKind::FurtherBounces ? json(left_out.most_bounces()) : json()}});
    return list;
}

std::optional<PathsLeftOut> left_out_by(const std::string& method, const json& parameters, const Needs& needs) {
    const MethodInfo* info = find_method(method);
    if (!info) return std::nullopt;
    return info->left_out(*params_of(*info, parameters), needs);
}

Needs needs_read(const json& object) {
    Needs needs;
    if (const json known = object.value("needs", json()); known.is_object())
        needs.visit([&](const char* name, bool& needed) { needed = known.value(name, false); });
    if (const json alpha = object.value("least_glossy_alpha", json()); alpha.is_number())
        needs.least_glossy_alpha = alpha.get<float>();
    return needs;
}

std::optional<PathsLeftOut> left_out_of_job(const json& statistics, const json& method) {
    if (!statistics.is_object()) return std::nullopt;
    if (auto recorded = left_out_read(statistics.value("left_out", json()))) return recorded;
    if (!statistics.value("needs", json()).is_object() || !method.is_object()) return std::nullopt;
    return left_out_by(method.value("name", ""), method.value("parameters", json::object()), needs_read(statistics));
}

}  // namespace photond
