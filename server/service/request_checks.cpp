#include "server/service/request_checks.h"

#include <algorithm>

#include "protocol/enumerated.h"
#include "protocol/nearest_name.h"
#include "protocol/scene_families.h"
#include "renderer/methods/registry.h"
#include "renderer/scene/builtin_scenes.h"
#include "server/comparisons/report_text.h"
#include "server/device_memory.h"
#include "server/method_params.h"
#include "server/service/references.h"

namespace photond {

using nlohmann::json;

namespace {

std::string nearest_hint(const std::string& wrong, const std::vector<std::string>& known) {
    const std::string near = nearest_name(wrong, known);
    return near.empty() ? "" : "; did you mean '" + near + "'?";
}

/// Metrics a request names, with their places.
std::vector<std::pair<std::string, std::string>> measured(const JobRequest& request) {
    std::vector<std::pair<std::string, std::string>> metrics;
    if (request.stop.target) metrics.emplace_back(request.stop.target->metric, "/stop/target/metric");
    for (size_t i = 0; i < request.metrics.size(); ++i)
        metrics.emplace_back(request.metrics[i], "/metrics/" + std::to_string(i));
    return metrics;
}

bool is_kept_always(const std::string& layer) {
    if (layer == "beauty") return true;
    for (const LayerInfo& info : kLayers)
        if (info.name == layer) return LayerSet().has(info.layer);
    return false;
}

/// Refuses metrics of layers that the reference does not hold.
void check_layers(const JobRequest& request, const std::string& reference, const std::vector<std::string>& layers) {
    std::vector<Fault> faults;
    for (const auto& [metric, pointer] : measured(request)) {
        const std::string layer = layer_of_metric(metric);
        if (is_kept_always(layer) || std::find(layers.begin(), layers.end(), layer) != layers.end()) continue;
        faults.emplace_back(ErrorCode::Conflict, pointer,
                            std::string("'")
                                .append(metric)
                                .append("' needs the layer '")
                                .append(layer)
                                .append("', which ")
                                .append(reference)
                                .append(" has not"));
    }
    if (faults.empty()) return;
    const std::string first = faults.front().detail;
    throw Error(ErrorCode::Conflict, first, std::move(faults));
}

void check_same_size(const JobRequest& request, const std::string& reference, int64_t width, int64_t height) {
    if (width == request.width && height == request.height) return;
    throw Error(ErrorCode::Conflict, "/reference",
                reference + " has " + std::to_string(width) + " x " + std::to_string(height) +
                    " pixels, the image is to have " + std::to_string(request.width) + " x " +
                    std::to_string(request.height));
}

}  // namespace

void RequestChecks::check_parameters(const JobMethod& method, const std::string& prefix) {
    const MethodInfo* info = find_method(method.name);
    if (!info || method.device == "cpu") return;
    try {
        info->check_gpu(*params_of(*info, method.parameters));
    } catch (const Error& error) {
        std::vector<Fault> faults = error.faults;
        for (Fault& fault : faults) fault.pointer.insert(0, prefix);
        throw Error(error.code, error.what(), std::move(faults));
    }
}

SceneRef RequestChecks::check_request(const JobRequest& request) {
    core_.device_of(request.method);
    check_parameters(request.method, "");
    const MethodInfo* info = find_method(request.method.name);
    const bool is_part = request.first_pass > 0 || request.shutter > 0;
    const std::string building(info && is_part ? builds_on_before(*info, request.method.parameters) : "");
    if (!building.empty() && request.first_pass > 0)
        throw Error(ErrorCode::Unsupported, "/first_pass",
                    building + " of " + request.method.name +
                        " build on those before with these parameters: its jobs begin at pass 0");
    if (!building.empty() && request.shutter > 0)
        throw Error(ErrorCode::Unsupported, "/shutter",
                    building + " of " + request.method.name +
                        " build on those before with these parameters, and all passes show one moment");
    auto scene = scenes_.find_scene(request.scene);
    if (!scene) {
        std::vector<std::string> known;
        for (const std::string_view name : builtin_scene_names()) known.emplace_back(name);
        for (const std::string_view family : kSceneFamilies)
            for (const std::string_view name : builtin_scene_names(family)) known.emplace_back(name);
        for (const SceneRow& row : core_.store.scenes(INT64_MAX, 1000)) known.push_back(row.name);
        throw Error(ErrorCode::UnknownName, "/scene",
                    "there is no scene '" + request.scene + "'" + nearest_hint(request.scene, known));
    }
    if (!request.camera.name.empty()) {
        std::vector<std::string> cameras;
        if (scene->builtin) {
            cameras.emplace_back("camera");
        } else {
            const auto summary = scenes_.summary_of(*scene);
            for (const json& camera : summary->value("cameras", json::array()))
                cameras.push_back(camera.value("name", ""));
        }
        if (std::find(cameras.begin(), cameras.end(), request.camera.name) == cameras.end())
            throw Error(ErrorCode::UnknownName, "/camera/name",
                        "the scene has no camera '" + request.camera.name + "'" +
                            nearest_hint(request.camera.name, cameras) +
                            (cameras.empty() ? "; it has none" : "; it has " + enumerated(cameras)));
    }
    if (request.animation) {
        const auto summary = scenes_.summary_of(*scene);
        // Of a scene that nobody has looked at for them the worker says.
        if (const json motion = summary->value("motion", json()); motion.is_array()) {
            std::vector<std::string> names;
            for (const json& animation : motion) names.push_back(animation.value("name", ""));
            check_animation(*request.animation, names);
        }
    }
    if (request.environment) {
        const std::string& image = request.environment->image;
        if (!image.starts_with("image:") || !core_.store.image(image.substr(6)))
            throw Error(ErrorCode::UnknownName, "/environment/image", "there is no image '" + image + "'");
    }
    check_size(request, *scene, "/image");
    check_device_memory(request, *scene, "/image");
    check_reference(request, *scene);
    return *std::move(scene);
}

void RequestChecks::check_size(const JobRequest& request, const SceneRef& scene, const std::string& pointer) {
    const uint64_t bytes = estimates_.estimate_memory_bytes(request, scene);
    const std::string needs = "; the job needs about " + std::to_string(bytes) + " bytes (" + short_bytes(bytes) + ")";
    const uint64_t memory_limit = core_.options.memory_limit_bytes;
    const uint64_t pixels = uint64_t{request.width} * request.height;
    if (pixels > core_.options.limits.max_pixels)
        throw Error(ErrorCode::OutOfRange, pointer,
                    std::to_string(request.width) + " x " + std::to_string(request.height) + " = " +
                        std::to_string(pixels) + " pixels, the limit is " +
                        std::to_string(core_.options.limits.max_pixels) + " in all" + needs);
    if (bytes > memory_limit)
        throw Error(ErrorCode::OutOfMemory, pointer,
                    "the limit of a worker is " + std::to_string(memory_limit) + " bytes (" +
                        short_bytes(memory_limit) + ")" + needs);
}

void RequestChecks::check_device_memory(const JobRequest& request, const SceneRef& scene, const std::string& pointer) {
    const auto bytes = estimates_.estimate_device_bytes(request, scene);
    if (!bytes) return;
    const std::string id = core_.device_of(request.method);
    const json device = core_.listed_device(id);
    const uint64_t limit = job_device_limit_bytes(device_limit_bytes(
        device.value("memory_bytes", uint64_t{0}), device.value("software", false), core_.options.memory_limit_bytes));
    if (*bytes > limit)
        throw Error(ErrorCode::OutOfMemory, pointer,
                    "a job may hold " + std::to_string(limit) + " bytes of " + id + " (" + device.value("name", "") +
                        "), " + short_bytes(limit) + "; this one needs about " + std::to_string(*bytes) + ", " +
                        short_bytes(*bytes));
}

void RequestChecks::check_reference(const JobRequest& request, const SceneRef& scene) {
    if (!request.reference) return;
    if (request.reference->rendering) {
        const JobRequest reference = References::reference_request(request, 0);
        core_.device_of(reference.method, "/reference/method/device");
        check_parameters(reference.method, "/reference");
        check_size(reference, scene, "/reference/method");
        check_device_memory(reference, scene, "/reference/method");
        return check_layers(request, "'" + reference.method.name + "'", reference.layers);
    }
    if (!request.reference->image.empty()) {
        const auto image = core_.store.image(request.reference->image);
        if (!image)
            throw Error(ErrorCode::UnknownName, "/reference", "there is no image '" + request.reference->image + "'");
        check_same_size(request, "the image", image->width, image->height);
        // Of one with more channels only its reader knows which layers they are.
        if (image->channels <= 4) check_layers(request, "the image", {});
        return;
    }
    const std::string name = "job " + request.reference->job;
    const int64_t seq = job_seq(request.reference->job);
    const auto job = seq ? core_.store.job(seq) : std::nullopt;
    if (!job) throw Error(ErrorCode::UnknownName, "/reference", "there is no " + name);
    if (is_over(job->state) && job->film.empty())
        throw Error(ErrorCode::Conflict, "/reference",
                    name + " " + std::string(job_state_name(job->state)) + " without leaving a film");
    const json theirs = json::parse(job->request);
    check_same_size(request, name, theirs["image"].value("width", int64_t{0}),
                    theirs["image"].value("height", int64_t{0}));
    check_layers(request, name, theirs.value("layers", std::vector<std::string>()));
}

}  // namespace photond
