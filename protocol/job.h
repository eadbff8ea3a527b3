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

#include "protocol/object_reader.h"
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

/// Met when the metric's value is at most this.
struct ErrorTarget {
    static constexpr double kGreatest = 1e30;

    std::string metric;  // "relative_mse", "indirect:rmse"
    double value = 0;
};

/// The first one met ends the job; all of them count from the film's first pass, whatever attempt rendered it.
struct StopConditions {
    static constexpr double kLeastSeconds = 1e-3;

    std::optional<double> seconds;
    std::optional<uint32_t> passes;
    std::optional<ErrorTarget> target;
};

/// How far a job has come, 0 to 1, as far as passes and seconds say.
double progress_of(const StopConditions& stop, uint32_t passes, double seconds);

/// What renders: a method, where, and with which parameters.
struct JobMethod {
    std::string name;
    std::string device = "cpu";
    nlohmann::json parameters = nlohmann::json::object();  // every default filled in
};

/// What a job's image is measured against. Exactly one member is set.
struct JobReference {
    std::string job;    // "J17"
    std::string image;  // id of an uploaded one
    struct Rendering {
        JobMethod method;
        StopConditions stop;
    };
    std::optional<Rendering> rendering;  // made once from the job's own scene and view, and kept
};

struct JobEnvironment {
    std::string image;  // "image:ID"
    double scale = 1;
    double rotation = 0;  // radians about +Y
};

/// One of the scene's animations, by name or by index.
struct JobAnimation {
    std::string name;
    std::optional<uint32_t> index;  // instead of the name
};

struct JobRequest {
    std::string scene;
    JobCamera camera;
    uint32_t width = 0;
    uint32_t height = 0;
    std::string filter = "box";
    JobMethod method;
    StopConditions stop;
    uint32_t first_pass = 0;  // index of the first pass rendered: a part of a larger job, to be merged
    uint64_t seed = 1;
    std::vector<std::string> layers;
    std::optional<JobReference> reference;
    std::vector<std::string> metrics;  // measured besides those that cost little
    int priority = 0;
    std::optional<double> quiet_machine;  // seconds that it may wait for a machine on which nothing else runs
    std::map<std::string, std::string> labels;
    std::optional<JobEnvironment> environment;
    std::string glass = "as_stored";
    std::optional<JobAnimation> animation;  // none: the scene at rest
    double time = 0;                        // of the animation [s]
    double shutter = 0;                     // how long it stays open from then on [s]
};

/// What the reader needs to know of the rest of the program: known names and how to check method parameters.
struct JobVocabulary {
    std::vector<std::string> method_names;
    std::vector<std::string> always_layers;      // of every image, besides the beauty
    std::vector<std::string> layer_names;        // on request, of any method
    std::vector<std::string> metric_names;       // that are one number: for targets and curves
    std::vector<std::string> estimated_metrics;  // those of them that need no reference
    std::vector<std::string> radiance_layers;    // that can be measured, besides the beauty
    uint32_t max_width = 65536, max_height = 65536;
    /// Makes the parameter struct of a method, nullptr when there is no such method.
    std::function<std::unique_ptr<MethodParams>(const std::string& method)> make_params;
    /// Device kinds a method runs on.
    std::function<std::vector<std::string>(const std::string& method)> devices_of;
    /// Those of `layer_names` that a method can fill.
    std::function<std::vector<std::string>(const std::string& method)> layers_of;
};

/// "look_at" of a camera. Faults are added; what is at fault has its default.
LookAt read_look_at(const nlohmann::json& source, const std::string& pointer, BodyFaults& faults);
/// The first thing that read_look_at() would refuse of a view that was made, not read: "up must not be zero nor ...";
/// empty: nothing.
std::string fault_of_view(const LookAt& view);

/// Reads a body. Throws photond::Error with all faults, each with its JSON pointer and, for a misspelt name, the
/// nearest known one.
JobRequest parse_job_request(const nlohmann::json& body, const JobVocabulary& vocabulary);

/// A stop object by itself, as POST /v1/jobs/{id}/extend has it. `has_reference`: targets may need one. Faults are
/// added.
StopConditions read_stop_conditions(const nlohmann::json& source, const std::string& pointer,
                                    const JobVocabulary& vocabulary, bool has_reference, BodyFaults& faults);
/// Throws ErrorCode::UnknownName unless a scene with animations of these names, in the order of their indices, has it.
void check_animation(const JobAnimation& animation, const std::vector<std::string>& names);
/// "relative_mse" or "LAYER:relative_mse"; a fault is added where it is neither.
void check_metric_name(const std::string& metric, const std::string& pointer, const JobVocabulary& vocabulary,
                       BodyFaults& faults);
/// The layer a metric is of: "beauty" where it names none.
std::string layer_of_metric(const std::string& metric);

nlohmann::json to_json(const LookAt& look_at);
nlohmann::json to_json(const StopConditions& stop);
nlohmann::json to_json(const JobMethod& method);
nlohmann::json to_json(const JobAnimation& animation);
nlohmann::json to_json(const JobReference& reference);  // "job:J17", "image:ID" or {"method", "stop"}
/// The request as understood, every default filled in; parse_job_request() of it gives the same request.
nlohmann::json to_json(const JobRequest& request);
/// What is hashed of a request as understood, a job's or one of many jobs: members that say nothing and that earlier
/// versions did not have are left out, so that what they hashed keeps its name.
nlohmann::json naming_json(nlohmann::json request);
inline nlohmann::json naming_json(const JobRequest& request) { return naming_json(to_json(request)); }

}  // namespace photond
