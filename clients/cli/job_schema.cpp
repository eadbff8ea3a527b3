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

}  // namespace

std::vector<std::string> job_words(Session& session, const std::string& member) {
    const json document = session.daemon().get("/v1/openapi.json");
    const json::json_pointer body("/paths/~1v1~1jobs/post/requestBody/content/application~1json/schema");
    json schema = resolved(document, document.value(body, json()));
    for (size_t begin = 0; begin < member.size() && schema.is_object();) {
        const size_t end = std::min(member.find('/', begin), member.size());
        const json properties = schema.value("properties", json::object());
        schema = resolved(document, properties.value(member.substr(begin, end - begin), json()));
        begin = end + 1;
    }
    if (schema.is_object() && schema.contains("items")) schema = resolved(document, schema["items"]);
    std::vector<std::string> words;
    if (schema.is_object() && schema.contains("enum"))
        for (const json& word : schema["enum"])
            if (word.is_string()) words.push_back(word.get<std::string>());
    return words;
}

}  // namespace photond::cli
