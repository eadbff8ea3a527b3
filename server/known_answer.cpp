#include "server/known_answer.h"

#include "renderer/methods/registry.h"

namespace photond {

using nlohmann::json;

namespace {

json check_object(const KnownCheck& check) {
    json value = nullptr;
    if (check.value) value = {check.value->x, check.value->y, check.value->z};
    return {{"relation", relation_name(check.relation)},
            {"layer", check.layer},
            {"region", check.region},
            {"value", std::move(value)},
            {"scene", check.same_as.empty() ? json() : json(check.same_as)},
            {"scale", check.scale},
            {"bounces", check.bounces ? json(*check.bounces) : json()},
            {"tolerance", check.tolerance}};
}

json answer_object(const KnownAnswer& answer) {
    json checks = json::array();
    for (const KnownCheck& check : answer.checks) checks.push_back(check_object(check));
    json not_applicable = json::object();
    for (const MethodInfo& method : all_methods())
        for (const CaseRefusal& refusal : method.refusals)
            if (answer.row.find(refusal.row) != std::string::npos)
                not_applicable[std::string(method.name)] = refusal.text;
    return {{"case", answer.row},           {"strains", answer.strains},
            {"text", answer.text},          {"checks", std::move(checks)},
            {"passes", answer.passes},      {"width", answer.size.width},
            {"height", answer.size.height}, {"not_applicable", std::move(not_applicable)}};
}

}  // namespace

json known_answer_of(const std::string& scene_name) {
    const HardCase* hard_case = find_hard_case(scene_name);
    return hard_case ? answer_object(hard_case->answer) : json();
}

json hard_cases_tested_elsewhere() {
    json tests = json::array();
    for (const HardCase& hard_case : hard_cases())
        if (!hard_case.make)
            tests.push_back({{"name", hard_case.name},
                             {"test", hard_case.test},
                             {"known_answer", answer_object(hard_case.answer)}});
    return tests;
}

}  // namespace photond
