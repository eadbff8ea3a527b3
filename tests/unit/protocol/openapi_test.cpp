#include "protocol/openapi.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "protocol/error.h"

namespace photond::openapi_test {
namespace {

using nlohmann::json;

json document() {
    ApiVocabulary vocabulary;
    vocabulary.version = "1.2.3";
    vocabulary.methods = {{"path_tracing", {{"type", "object"}}, {"albedo"}},
                          {"photon_mapping", {{"type", "object"}}, {"albedo", "depth"}}};
    vocabulary.layers = {"albedo", "depth"};
    vocabulary.metrics = {"rmse", "estimated_relative_mse"};
    vocabulary.image_metrics = {"rmse", "percentiles"};
    vocabulary.radiance_layers = {"emitted", "direct"};
    vocabulary.preview_layers = {"direct", "vpls"};
    vocabulary.artefacts = {{"photon_map.glb", "model/gltf-binary", "the photon map"}};
    return openapi_document(vocabulary);
}

void find_references(const json& value, std::set<std::string>& found) {
    if (value.is_object() && value.contains("$ref")) found.insert(value["$ref"].get<std::string>());
    if (value.is_structured())
        for (const json& part : value) find_references(part, found);
}

TEST(OpenApi, EveryReferenceLeadsSomewhere) {
    const json api = document();
    std::set<std::string> references;
    find_references(api, references);
    EXPECT_GT(references.size(), 10u);
    for (const std::string& reference : references)
        EXPECT_TRUE(api.contains(json::json_pointer(reference.substr(1)))) << reference;
}

TEST(OpenApi, EveryOperationIsWholeAndNamedOnce) {
    const json api = document();
    EXPECT_EQ(api["openapi"], "3.1.0");
    std::set<std::string> ids;
    for (const auto& [path, methods] : api["paths"].items())
        for (const auto& [method, operation] : methods.items()) {
            EXPECT_TRUE(ids.insert(operation["operationId"].get<std::string>()).second) << path;
            EXPECT_TRUE(operation["responses"].contains("default")) << path;
            EXPECT_GE(operation["responses"].size(), 2u) << path;
            std::set<std::string> declared;
            for (const json& parameter : operation["parameters"])
                if (parameter["in"] == "path") declared.insert(parameter["name"].get<std::string>());
            for (size_t at = path.find('{'); at != std::string::npos; at = path.find('{', at + 1))
                EXPECT_EQ(declared.count(path.substr(at + 1, path.find('}', at) - at - 1)), 1u) << path;
            EXPECT_EQ(operation.contains("requestBody"),
                      method == "patch" || (method == "post" && !path.ends_with("/retry") &&
                                            !path.ends_with("/repeat") && path != "/v1/backups"))
                << path;
        }
    EXPECT_EQ(openapi_operations(api).size(), ids.size());
}

TEST(OpenApi, ProblemKnowsEveryErrorCode) {
    const json codes = document()["components"]["schemas"]["Problem"]["properties"]["code"]["enum"];
    EXPECT_EQ(codes.size(), std::size(kErrorKinds));
}

TEST(OpenApi, RequestKnowsMethodsAndLayers) {
    const json schemas = document()["components"]["schemas"], request = schemas["JobRequest"];
    EXPECT_EQ(request["additionalProperties"], false);
    EXPECT_EQ(schemas["JobMethod"]["oneOf"][0]["properties"]["name"]["const"], "path_tracing");
    EXPECT_EQ(request["properties"]["layers"]["anyOf"][0]["items"]["enum"].dump(), R"(["albedo","depth"])");
    EXPECT_EQ(schemas["Stop"]["anyOf"][0]["required"].dump(), R"(["seconds"])");
    EXPECT_EQ(request["properties"]["metrics"]["anyOf"][0]["items"]["pattern"],
              "^((emitted|direct|beauty):)?(rmse|estimated_relative_mse)$");
    EXPECT_EQ(schemas["MeasurementRequest"]["properties"]["metrics"]["anyOf"][0]["items"]["pattern"],
              "^((emitted|direct|beauty):)?(rmse|percentiles)$");
    // Only the method that lacks a layer narrows the list.
    ASSERT_EQ(request["allOf"].size(), 1u);
    EXPECT_EQ(request["allOf"][0]["if"]["properties"]["method"]["properties"]["name"]["const"], "path_tracing");
    EXPECT_EQ(request["allOf"][0]["then"]["properties"]["layers"]["items"]["enum"].dump(), R"(["albedo"])");
}

TEST(OpenApi, PreviewsKnowTheLayersThatHaveOne) {
    const json api = document();
    for (const json& parameter : api["paths"]["/v1/jobs/{id}/preview.png"]["get"]["parameters"]) {
        if (parameter["name"] == "layer") {
            EXPECT_EQ(parameter["schema"]["enum"].dump(), R"(["beauty","direct","vpls"])");
            return;
        }
    }
    FAIL() << "no parameter layer";
}

TEST(OpenApi, ArtefactsOfMethodsAreServedAndLinked) {
    const json api = document();
    const json& operation = api["paths"]["/v1/jobs/{id}/photon_map.glb"]["get"];
    EXPECT_TRUE(operation["responses"]["200"]["content"].contains("model/gltf-binary"));
    EXPECT_TRUE(operation["responses"].contains("202"));
    EXPECT_EQ(operation["operationId"], "getPhotonMap");
    const json& links = api["components"]["schemas"]["Job"]["properties"]["links"];
    EXPECT_EQ(links["properties"]["photon_map"]["type"].dump(), R"(["string","null"])");
    const json& required = links["required"];
    EXPECT_NE(std::find(required.begin(), required.end(), "photon_map"), required.end());
}

}  // namespace
}  // namespace photond::openapi_test
