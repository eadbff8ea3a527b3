// What the daemon's OpenAPI document says of a job.

#include "clients/cli/commands.h"

namespace photond::cli {

using nlohmann::json;

namespace {

constexpr int kMostReferences = 16;  // a $ref chain longer than this is a loop

/// A schema with its `$ref`s into the same document followed.
json resolved(const json& document, json schema) {
    for (int i = 0; i < kMostReferences && schema.is_object() && schema.contains("$ref"); ++i) {
        const std::string reference = schema["$ref"].get<std::string>();
        if (!reference.starts_with("#/")) return nullptr;
        schema = document.value(json::json_pointer(reference.substr(1)), json());
    }
    return schema;
}

/// The schemas that `schema` stands for: itself, or each alternative of its anyOf.
std::vector<json> alternatives(const json& document, const json& schema) {
    const json whole = resolved(document, schema);
    if (!whole.is_object()) return {};
    if (!whole.contains("anyOf")) return {whole};
    std::vector<json> all;
    for (const json& part : whole["anyOf"]) all.push_back(resolved(document, part));
    return all;
}

}  // namespace

std::vector<std::string> job_words(Session& session, const std::string& member) {
    const json document = session.daemon().get("/v1/openapi.json");
    const json::json_pointer body("/paths/~1v1~1jobs/post/requestBody/content/application~1json/schema");
    std::vector<json> schemas = alternatives(document, document.value(body, json()));
    for (size_t begin = 0; begin < member.size();) {
        const size_t end = std::min(member.find('/', begin), member.size());
        std::vector<json> inner;
        for (const json& schema : schemas) {
            const json properties = schema.value("properties", json::object());
            for (json& found : alternatives(document, properties.value(member.substr(begin, end - begin), json())))
                inner.push_back(std::move(found));
        }
        schemas = std::move(inner);
        begin = end + 1;
    }
    std::vector<std::string> words;
    for (const json& schema : schemas) {
        const json single = schema.contains("items") ? resolved(document, schema["items"]) : schema;
        for (const json& word : single.value("enum", json::array()))
            if (word.is_string()) words.push_back(word.get<std::string>());
    }
    return words;
}

}  // namespace photond::cli
