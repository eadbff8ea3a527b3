#include "server/service/estimates.h"

#include <algorithm>
#include <set>
#include <thread>

#include "renderer/error/estimate.h"
#include "renderer/film/film.h"
#include "renderer/methods/registry.h"
#include "server/comparisons/report_text.h"
#include "server/left_out_json.h"
#include "server/method_params.h"

namespace photond {

using nlohmann::json;

namespace {

constexpr uint32_t kEarlierJobs = 50;  // looked at for how long a sample takes
// What a scene has on a GPU and not on the host; the rest takes about the same on both, ray structure included.
constexpr uint64_t kDeviceTableBytes = 40 << 10;  // of albedos and of directions
constexpr uint64_t kDeviceLightBytes = 176;       // each

LayerSet layers_of(const JobRequest& request) {
    LayerSet layers;
    for (const LayerInfo& info : kLayers)
        if (std::find(request.layers.begin(), request.layers.end(), info.name) != request.layers.end())
            layers.add(info.layer);
    return layers;
}

/// What a worker keeps to follow a job's error: the estimate's earlier image, and for each layer that is measured the
/// reference's pixels, as they are and as a display shows them, and their standard error. Of two films half of what
/// tells them apart as well, their mean once more, and what relative errors divide by.
uint64_t measuring_bytes(const JobRequest& request) {
    const uint64_t image_bytes = uint64_t{request.width} * request.height * 3 * sizeof(float);
    uint64_t bytes = ErrorEstimator::bytes_for({request.width, request.height});
    if (!request.reference) return bytes;
    std::set<std::string> layers{"beauty"};
    if (request.stop.target) layers.insert(layer_of_metric(request.stop.target->metric));
    for (const std::string& metric : request.metrics) layers.insert(layer_of_metric(metric));
    for (const std::string& layer : layers) {
        const bool noise_known = request.reference->image.empty() && layer != "emitted" && layer != "caustic";
        bytes += image_bytes * ((noise_known ? 3 : 2) + (request.reference->rendering ? 3 : 0));
    }
    return bytes;
}

/// One of the method's estimates for a request.
uint64_t ask_method(const JobRequest& request, const Workload& workload,
                    uint64_t (*MethodInfo::*estimate)(const MethodParams&, const Workload&)) {
    const MethodInfo* method = find_method(request.method.name);
    if (!method) throw Error(ErrorCode::Internal, "a request for a method that is not there");
    return (method->*estimate)(*params_of(*method, request.method.parameters), workload);
}

/// How long a pass of the request would take, going by an earlier job: what that spent on photons, by their number; all
/// else by the number of pixels.
std::optional<double> seconds_of_a_pass(const JobRequest& request, const EarlierJob& before) {
    if (before.pixels * before.passes <= 0) return std::nullopt;
    double more_photons = 1;
    if (before.photon_seconds > 0) {
        const double then = before.parameters.value("photons", 0.0);
        if (then > 0) more_photons = request.method.parameters.value("photons", then) / then;
    }
    const double more_pixels = static_cast<double>(request.width) * request.height / before.pixels;
    return (before.photon_seconds * more_photons + (before.seconds - before.photon_seconds) * more_pixels) /
           before.passes;
}

EarlierJob earlier_job(const JobRow& row) {
    const json request = json::parse(row.request);
    const json& image = request["image"];
    EarlierJob job{row.scene, request["method"]["parameters"], image.value("width", 0.0) * image.value("height", 0.0),
                   row.seconds, static_cast<double>(row.passes_done)};
    const json statistics = row.statistics.empty() ? json::object() : json::parse(row.statistics);
    for (const json& stage : statistics.value("stages", json::array()))
        if (stage.value("name", "") == "photon_tracing" || stage.value("name", "") == "photon_map_build")
            job.photon_seconds += stage.value("wall_seconds", 0.0);
    job.photon_seconds = std::min(job.photon_seconds, job.seconds);
    return job;
}

uint64_t film_bytes(const JobRequest& request) {
    return Film::bytes_for({request.width, request.height}, layers_of(request));
}

}  // namespace

Workload Estimates::workload_of(const JobRequest& request, const json& summary) {
    Workload workload;
    workload.film_size = {request.width, request.height};
    workload.layers = layers_of(request);
    workload.threads =
        core_.options.threads ? core_.options.threads : std::max(1u, std::thread::hardware_concurrency());
    const json lights = summary.value("lights", json::object());
    workload.lights = lights.value("area", uint64_t{0}) + lights.value("punctual", uint64_t{0});
    workload.triangles = summary.value("triangles", uint64_t{0});
    workload.needs = needs_read(summary);
    const json yield = summary.value("photon_yield", json());
    if (yield.is_object() && !request.environment)  // whose light takes other ways
        workload.photon_yield = PhotonYield{
            // Scenes uploaded before global photons were led have one number for both.
            .global = {yield.value("global", 0.0), yield.value("global_unguided", yield.value("global", 0.0))},
            .caustic = {yield.value("caustic", 0.0), yield.value("caustic_unguided", 0.0)}};
    if (request.environment)
        if (const auto image = core_.store.image(request.environment->image.substr(6))) {
            workload.environment_size = {static_cast<uint32_t>(image->width), static_cast<uint32_t>(image->height)};
            workload.needs.environment = true;
        }
    return workload;
}

namespace {

using HistoryBytes = uint64_t (*)(const MethodInfo& method, const MethodParams& params, Size2 film_size);

uint64_t bytes_of_history(const JobRequest& request, HistoryBytes bytes) {
    const MethodInfo* method = find_method(request.method.name);
    if (!method || !method->temporal) return 0;
    const std::unique_ptr<MethodParams> params = params_of(*method, request.method.parameters);
    return bytes(*method, *params, {request.width, request.height});
}

/// What a job holds to take over, and to leave to the next frame, and about what its film's file has of it.
uint64_t history_bytes(const JobRequest& request) { return bytes_of_history(request, &photond::history_bytes); }

}  // namespace

uint64_t Estimates::estimate_memory_bytes(const JobRequest& request, const SceneRef& scene) {
    const auto summary = scenes_.summary_of(scene);
    const Workload workload = workload_of(request, *summary);
    const bool on_gpu = request.method.device != "cpu";
    uint64_t scene_bytes = summary->value("memory_bytes", uint64_t{0});
    const MethodInfo* method = find_method(request.method.name);
    if (on_gpu && !(method && traces_on_host(*method, request.method.parameters)))
        scene_bytes -= summary->value("acceleration_bytes", uint64_t{0});  // it lies on the device
    return film_bytes(request) + measuring_bytes(request) + scene_bytes + history_bytes(request) +
           workload.environment_size.pixels() * sizeof(Rgb) +
           ask_method(request, workload, on_gpu ? &MethodInfo::estimate_bytes_gpu : &MethodInfo::estimate_bytes);
}

std::optional<uint64_t> Estimates::estimate_device_bytes(const JobRequest& request, const SceneRef& scene) {
    const MethodInfo* method = find_method(request.method.name);
    if (request.method.device == "cpu" || !method || !method->estimate_device_bytes) return std::nullopt;
    const auto summary = scenes_.summary_of(scene);
    const Workload workload = workload_of(request, *summary);
    return kDeviceTableBytes + kDeviceLightBytes * workload.lights + summary->value("memory_bytes", uint64_t{0}) +
           workload.environment_size.pixels() * sizeof(Rgb) +
           bytes_of_history(request, &photond::history_device_bytes) +
           ask_method(request, workload, &MethodInfo::estimate_device_bytes);
}

uint64_t Estimates::estimate_disk_bytes(const JobRequest& request, const SceneRef& scene) {
    const Workload workload = workload_of(request, *scenes_.summary_of(scene));
    // A film that is saved again lies beside the one before until it is whole.
    return 2 * (film_bytes(request) + history_bytes(request)) +
           ask_method(request, workload, &MethodInfo::estimate_artefact_bytes);
}

PathsLeftOut Estimates::paths_left_out(const JobRequest& request, const SceneRef& scene) {
    const Needs needs = workload_of(request, *scenes_.summary_of(scene)).needs;
    const auto left_out = left_out_by(request.method.name, request.method.parameters, needs);
    if (!left_out) throw Error(ErrorCode::Internal, "a request for a method that is not there");
    return *left_out;
}

std::optional<double> Estimates::estimate_pass_seconds(const JobRequest& request, const SceneRef& scene,
                                                       EarlierJobs& earlier) {
    const std::string device = core_.device_of(request.method);
    const auto [known, unread] = earlier.try_emplace({request.method.name, device});
    if (unread)
        for (const JobRow& row : core_.store.latest_succeeded(request.method.name, kEarlierJobs))
            if (row.device == device) known->second.push_back(earlier_job(row));
    // From what the method took before: in this scene if it was ever rendered, with these parameters if they ever
    // were asked for; of several such jobs the newest.
    std::optional<double> a_pass;
    int most_alike = -1;
    for (const EarlierJob& before : known->second) {
        const int alike = 2 * (before.scene == scene.id) + (before.parameters == request.method.parameters);
        if (alike <= most_alike) continue;
        const auto as_then = seconds_of_a_pass(request, before);
        if (!as_then) continue;
        a_pass = as_then;
        most_alike = alike;
    }
    return a_pass;
}

TimeEstimate Estimates::estimate_time(const JobRequest& request, const SceneRef& scene, EarlierJobs& earlier) {
    TimeEstimate estimate;
    estimate.pass_seconds = estimate_pass_seconds(request, scene, earlier);
    const std::optional<double>&a_pass = estimate.pass_seconds, &asked = request.stop.seconds;
    if (request.stop.passes && a_pass) estimate.seconds = *a_pass * *request.stop.passes;
    if (asked) estimate.seconds = std::max(std::min(estimate.seconds.value_or(*asked), *asked), a_pass.value_or(0));
    if (asked && a_pass && *a_pass > *asked)
        estimate.warning = "a pass takes about " + short_seconds(*a_pass) +
                           ", and the first one is always finished: the " + short_seconds(*asked) +
                           " asked for will be overshot";
    return estimate;
}

}  // namespace photond
