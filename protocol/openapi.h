#pragma once
// The API as an OpenAPI 3.1 document, built from the tables the service itself reads by.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace photond {

/// What the document needs to know of the rest of the program.
struct ApiVocabulary {
    std::string version;
    struct Method {
        std::string name;
        nlohmann::json parameters;        // params_schema()
        std::vector<std::string> layers;  // on request, those it can fill
    };
    std::vector<Method> methods;
    std::vector<std::string> always_layers;    // of every image, besides the beauty
    std::vector<std::string> layers;           // on request, of any method
    std::vector<std::string> metrics;          // that are one number: for targets and curves
    std::vector<std::string> image_metrics;    // of two images
    std::vector<std::string> radiance_layers;  // that can be measured
    std::vector<std::string> pages;            // patterns of the paths where the dashboard is shown
    std::vector<std::string> preview_layers;   // that a display can show, besides the beauty
    struct Artefact {
        std::string name;  // "photon_map.glb"
        std::string media_type;
        std::string text;  // what it is, as in "photon map"
    };
    std::vector<Artefact> artefacts;  // that methods leave beside the image
    uint32_t max_width = 65536, max_height = 65536;
    uint64_t max_pixels = 0;  // width * height
};

/// The link of an artefact in a job: its name without the suffix.
std::string artefact_link(const std::string& name);

/// Every path served, with the schemas (JSON Schema 2020-12, below /components/schemas) of every body taken and given.
nlohmann::json openapi_document(const ApiVocabulary& vocabulary);

/// Paths and methods in the document, "GET /v1/jobs/{id}": what the route table is checked against.
std::vector<std::string> openapi_operations(const nlohmann::json& document);

}  // namespace photond
