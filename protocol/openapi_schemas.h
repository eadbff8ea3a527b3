#pragma once
// The words the OpenAPI document is written in: JSON Schema (2020-12), as the service takes and gives.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace photond::openapi {

using nlohmann::json;

inline json schema_ref(const std::string& name) { return {{"$ref", "#/components/schemas/" + name}}; }
inline json typed(const char* type, const char* text = "") {
    json schema{{"type", type}};
    if (*text != '\0') schema["description"] = text;
    return schema;
}
inline json nullable(const char* type, const char* text = "") {
    json schema = typed(type, text);
    schema["type"] = {type, "null"};
    return schema;
}
inline json with_text(json schema, const char* text) {
    schema["description"] = text;
    return schema;
}
inline json nullable_ref(const std::string& name) { return {{"anyOf", {schema_ref(name), {{"type", "null"}}}}}; }
inline json in_range(json schema, const json& minimum, const json& maximum) {
    schema["minimum"] = minimum;
    if (!maximum.is_null()) schema["maximum"] = maximum;
    return schema;
}
inline json count(const char* text = "") { return in_range(typed("integer", text), 0, nullptr); }
inline json list_of(json items) { return {{"type", "array"}, {"items", std::move(items)}}; }
inline json map_of(json values) { return {{"type", "object"}, {"additionalProperties", std::move(values)}}; }
inline json one_of_words(const std::vector<std::string>& words) { return {{"type", "string"}, {"enum", words}}; }

/// An image somebody has rendered or uploaded.
inline json job_or_image() { return {{"type", "string"}, {"pattern", "^(job|image):."}, {"maxLength", 256}}; }

/// What the service gives: each property is there, null where it does not apply; more may be added later.
inline json given(json properties) {
    json required = json::array();
    for (const auto& [key, value] : properties.items()) required.push_back(key);
    return {{"type", "object"}, {"properties", std::move(properties)}, {"required", required}};
}
/// The same with members that results of earlier versions lack.
inline json with_later(json schema, const json& properties) {
    schema["properties"].update(properties);
    return schema;
}
/// [least, greatest].
inline json interval_of(const char* text) {
    json ends = list_of(typed("number"));
    ends["minItems"] = ends["maxItems"] = 2;
    return with_text(std::move(ends), text);
}
/// Kinds of path that an image leaves out; null where that is not known.
inline json left_out_list(const char* text) {
    json kind = given({{"kind", typed("string", "its name; more may be added later")},
                       {"text", typed("string", "a phrase")},
                       {"most_bounces", nullable("integer", "of further_bounces: paths of more are left out")}});
    return with_text({{"type", {"array", "null"}}, {"items", std::move(kind)}}, text);
}
/// What the service takes: nothing beside what is declared.
inline json taken(json properties, const std::vector<std::string>& required) {
    return {{"type", "object"},
            {"properties", std::move(properties)},
            {"required", required},
            {"additionalProperties", false}};
}
/// The same where null is as good as absent.
inline json or_null(json schema) { return {{"anyOf", {std::move(schema), {{"type", "null"}}}}}; }

/// Of jobs and of what is made of them.
inline constexpr const char* kStates[] = {"queued", "running", "succeeded", "failed", "cancelled"};
inline json state() { return one_of_words({std::begin(kStates), std::end(kStates)}); }
inline json time_or_none() { return {{"type", {"string", "null"}}, {"format", "date-time"}}; }

inline json page_of(const char* name) {
    return given({{"items", list_of(schema_ref(name))}, {"next_cursor", nullable("string")}});
}

/// Of scenes, their page and their known answers, by name.
json scene_schemas();

/// Of sequences, likewise.
nlohmann::json sequence_schemas(const nlohmann::json& job_request);
/// Of comparisons, by name. `job_request`: the schema JobRequest, which their members are taken from.
json comparison_schemas(const json& job_request);

}  // namespace photond::openapi
