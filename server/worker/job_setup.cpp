#include "server/worker/job_setup.h"

#include <algorithm>

#include "protocol/error.h"
#include "protocol/param_json.h"
#include "renderer/gbuffer/temporal_reprojection.h"
#include "renderer/methods/registry.h"
#include "renderer/scene/scene.h"

namespace photond {

namespace {

PixelFilter filter_named(const std::string& name) {
    if (name == "gaussian") return PixelFilter::Gaussian;
    if (name == "blackman_harris") return PixelFilter::BlackmanHarris;
    return PixelFilter::Box;  // the reader of jobs knows no other
}

}  // namespace

LayerSet layers_named(const std::vector<std::string>& names) {
    LayerSet layers;
    for (const LayerInfo& info : kLayers)
        if (std::find(names.begin(), names.end(), info.name) != names.end()) layers.add(info.layer);
    return layers;
}

std::unique_ptr<Method> make_method(const JobRequest& request, const std::string& device_kind) {
    const MethodInfo* info = find_method(request.method.name);
    if (!info)
        throw Error(ErrorCode::UnknownName, "/method/name", "there is no method \"" + request.method.name + "\"");
    const std::unique_ptr<MethodParams> params = info->make_params();
    std::vector<Fault> faults;
    read_params(*params, request.method.parameters, "/method/parameters", faults);
    if (!faults.empty()) {
        const std::string first = faults.front().detail;
        throw Error(ErrorCode::OutOfRange, first, std::move(faults));
    }
    params->check();
    const bool on_cpu = device_kind == "cpu";
    if (on_cpu ? !info->make : !info->make_gpu)
        throw Error(ErrorCode::Unsupported, "/method/device",
                    request.method.name + " does not run on a " + (on_cpu ? "CPU" : "GPU"));
    if (!on_cpu) info->check_gpu(*params);
    std::unique_ptr<Method> method = on_cpu ? info->make(*params) : info->make_gpu(*params);
    const TemporalParams* temporal = info->temporal ? info->temporal(*params) : nullptr;
    if (!temporal || temporal->reuse == TemporalReuse::None) return method;
    return std::make_unique<TemporalReprojection>(std::move(method), *temporal);
}

View resolve_view(const JobRequest& request, const Scene& scene) {
    View view;
    const JobCamera& wanted = request.camera;
    std::optional<double> focus_distance = wanted.focus_distance;
    if (wanted.look_at) {
        const auto point = [&](const std::array<double, 3>& p) { return dvec3(p[0], p[1], p[2]); };
        const dvec3 eye = point(wanted.look_at->eye), target = point(wanted.look_at->target);
        view.camera = look_at_camera(eye - scene.origin, target - scene.origin, point(wanted.look_at->up),
                                     static_cast<float>(wanted.look_at->yfov));
        if (!focus_distance) focus_distance = glm::length(target - eye);
    } else {
        view.camera = find_camera(scene, wanted.name);
    }
    if (wanted.aperture > 0) {
        if (!focus_distance)
            throw Error(ErrorCode::MissingField, "/camera/focus_distance",
                        "a lens (aperture > 0) needs a focus_distance, unless look_at gives a target");
        view.camera.aperture_radius_m = static_cast<float>(wanted.aperture);
        view.camera.focus_distance_m = static_cast<float>(*focus_distance);
    }
    view.film_size = {request.width, request.height};
    view.filter = filter_named(request.filter);
    view.layers = layers_named(request.layers);
    return view;
}

}  // namespace photond
