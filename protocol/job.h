#pragma once
// A render job as the wire says it (protocol.md, "Jobs"): read strictly, every fault named at once, echoed with every
// default filled in.

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "protocol/param_info.h"

namespace photond {

struct LookAt {
    std::array<double, 3> eye{}, target{}, up{0, 1, 0};
    double yfov = 0.7;  // radians
};

struct JobCamera {
    std::string name;  // empty: the scene's first camera, else one framed on its bounds
    std::optional<LookAt> look_at;
    double aperture = 0;                   // lens radius [m]
    std::optional<double> focus_distance;  // [m]; none: no lens, or the distance to look_at's target
};

struct StopConditions {
    std::optional<double> seconds;
    std::optional<uint32_t> passes;
};

struct JobEnvironment {
    std::string image;  // "image:ID"
    double scale = 1;
    double rotation = 0;  // radians about +Y
};

struct JobRequest {
    std::string scene;
    JobCamera camera;
    uint32_t width = 0;
    uint32_t height = 0;
    std::string filter = "box";
    std::string method;
    std::string device = "cpu";
    nlohmann::json parameters = nlohmann::json::object();  // every default filled in
    StopConditions stop;
    uint64_t seed = 1;
    std::vector<std::string> layers;
    int priority = 0;
    std::map<std::string, std::string> labels;
    std::optional<JobEnvironment> environment;
    std::string glass = "as_stored";
    double time = 0;
};

/// What the reader needs to know of the rest of the program: known names and how to check method parameters.
struct JobVocabulary {
    std::vector<std::string> method_names;
    std::vector<std::string> layer_names;  // on request, of any method
    uint32_t max_width = 65536, max_height = 65536;
    /// Makes the parameter struct of a method, nullptr when there is no such method.
    std::function<std::unique_ptr<MethodParams>(const std::string& method)> make_params;
    /// Device kinds a method runs on.
    std::function<std::vector<std::string>(const std::string& method)> devices_of;
    /// Those of `layer_names` that a method can fill.
    std::function<std::vector<std::string>(const std::string& method)> layers_of;
};

/// Reads a body. Throws photond::Error with all faults, each with its JSON pointer and, for a misspelt name, the
/// nearest known one.
JobRequest parse_job_request(const nlohmann::json& body, const JobVocabulary& vocabulary);

/// The request as understood, every default filled in; parse_job_request() of it gives the same request.
nlohmann::json to_json(const JobRequest& request);

}  // namespace photond
