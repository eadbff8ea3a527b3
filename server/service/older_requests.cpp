#include "server/service/older_requests.h"

#include <spdlog/spdlog.h>

#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "protocol/param_json.h"
#include "renderer/core/sha256.h"
#include "renderer/methods/registry.h"
#include "server/service/references.h"

namespace photond {

using nlohmann::json;

namespace {

/// All parameters of a method, as what a request of before lacks is done.
json make_parameters_before(const MethodInfo& method) {
    json before = json::object();
    for (const ParamSetting& setting : method.settings_before) {
        const json number = json::parse(setting.word, nullptr, false);
        before[std::string(setting.name)] = number.is_discarded() ? json(setting.word) : number;
    }
    const std::unique_ptr<MethodParams> params = method.make_params();
    std::vector<Fault> faults;
    read_params(*params, before, "", faults);
    if (!faults.empty()) throw Error(ErrorCode::Internal, std::string(method.name) + ": " + faults.front().detail);
    return params_to_json(*params);
}

/// The same; of a store's many requests each asks for them.
const json& parameters_before(const MethodInfo& method) {
    static const std::map<std::string_view, json> kBefore = [] {
        std::map<std::string_view, json> before;
        for (const MethodInfo& any : all_methods()) before[any.name] = make_parameters_before(any);
        return before;
    }();
    return kBefore.at(method.name);
}

bool complete_method(json& holder) {
    json* method = holder.is_object() && holder.contains("method") ? &holder["method"] : nullptr;
    if (!method || !method->is_object()) return false;
    const MethodInfo* info = find_method(method->value("name", ""));
    if (!info) return false;
    json& parameters = (*method)["parameters"];
    if (!parameters.is_object()) parameters = json::object();
    const size_t given = parameters.size();
    for (const auto& [name, value] : parameters_before(*info).items()) parameters.emplace(name, value);
    return parameters.size() > given;
}

/// Which parameters there are.
std::string known_parameters() {
    json known = json::object();
    for (const MethodInfo& method : all_methods()) known[std::string(method.name)] = parameters_before(method);
    const std::string text = known.dump();
    return sha256_hex(text.data(), text.size());
}

}  // namespace

bool complete_request(json& request) {
    bool completed = complete_method(request);
    if (request.is_object() && request.contains("reference"))
        completed = complete_method(request["reference"]) || completed;
    if (request.is_object() && request.contains("entries") && request["entries"].is_array())
        for (json& entry : request["entries"]) completed = complete_method(entry) || completed;
    return completed;
}

void complete_requests(Store& store, const JobVocabulary& vocabulary) {
    const std::string known = known_parameters();
    if (store.requests_are_of() == known) return;
    size_t completed = 0;
    auto transaction = store.transaction();
    store.change_requests([&](KeptRequest& kept) {
        json request = json::parse(kept.request, nullptr, false);
        if (request.is_discarded() || !complete_request(request)) return false;
        kept.request = request.dump(-1, ' ', false, json::error_handler_t::replace);
        if (References::is_one_of_two(kept.content)) {
            try {
                kept.content = References::reference_content(parse_job_request(request, vocabulary), kept.scene);
            } catch (const Error& error) {  // nobody can ask for it any more
                spdlog::warn("a reference of an older version is not found by what it shows: {}", error.what());
            }
        }
        ++completed;
        return true;
    });
    store.set_requests_are_of(known);
    transaction.commit();
    if (completed > 0) spdlog::info("{} requests of an older version have parameters that are new", completed);
}

}  // namespace photond
