#include "tests/benchmarks/gpu_bench/bench_run.h"

#include "protocol/param_json.h"
#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/core/rng.h"
#include "renderer/error/estimate.h"
#include "renderer/methods/registry.h"
#include "renderer/scene/baked_scene.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/scene.h"

namespace photond::bench {

namespace {

const MethodInfo& method_of(const Rendering& rendering) {
    const MethodInfo* info = find_method(rendering.method);
    if (!info) throw Error(ErrorCode::UnknownName, "there is no method " + rendering.method);
    return *info;
}

std::unique_ptr<MethodParams> params_of(const Rendering& rendering) {
    std::unique_ptr<MethodParams> params = method_of(rendering).make_params();
    std::vector<Fault> faults;
    read_params(*params, rendering.parameters, "/parameters", faults);
    if (!faults.empty()) throw Error(ErrorCode::OutOfRange, faults.front().pointer + ": " + faults.front().detail);
    return params;
}

bool traces_on_host(const Rendering& rendering) {
    const MethodInfo& info = method_of(rendering);
    return info.traces_on_host && info.traces_on_host(*params_of(rendering));
}

std::unique_ptr<Method> make_method(const Rendering& rendering, bool on_gpu) {
    const MethodInfo* info = &method_of(rendering);
    const std::string& name = rendering.method;
    if (on_gpu ? !info->make_gpu : !info->make)
        throw Error(ErrorCode::DeviceUnavailable, name + " does not run on a " + (on_gpu ? "GPU" : "CPU"));
    const std::unique_ptr<MethodParams> params = params_of(rendering);
    if (on_gpu) info->check_gpu(*params);
    return on_gpu ? info->make_gpu(*params) : info->make(*params);
}

/// The layers whose variance between passes a film keeps.
std::optional<double> own_relative_mse(const Film& film, const std::string& layer, std::span<const float> image) {
    if (film.passes() < 2) return std::nullopt;
    std::vector<float> variance = layer == "beauty"
                                      ? film.pass_variance_beauty()
                                      : film.pass_variance(layer == "direct" ? Layer::Direct : Layer::Indirect);
    for (float& value : variance) value /= static_cast<float>(film.passes());
    return expected_relative_mse(image, variance);
}

}  // namespace

const ErrorMeter& Reference::meter(const std::string& layer) const {
    const auto found = meters.find(layer);
    if (found == meters.end()) throw Error(ErrorCode::UnknownName, "there is no reference of the layer " + layer);
    return *found->second;
}

Place::Place(const std::string& scene, const std::filesystem::path& folder, gpu::Device* device)
    : scene_(scene.ends_with(".baked") ? read_baked_scene(folder / scene) : make_builtin_scene(scene)),
      device_(device) {}

const gpu::DeviceScene& Place::device_scene() {
    if (!device_scene_) device_scene_.emplace(*device_, scene_, load_);
    return *device_scene_;
}

RenderContext Place::context(bool on_gpu, const Rendering& rendering, uint64_t seed) {
    if (on_gpu && !device_rays_) device_rays_.emplace(device_scene());
    const bool on_host = !on_gpu || traces_on_host(rendering);
    if (on_host && !host_rays_) host_rays_ = make_embree_intersector(scene_, budget_, load_);
    const Intersector* rays = on_gpu ? static_cast<const Intersector*>(&*device_rays_) : host_rays_.get();
    const View view{find_camera(scene_, rendering.camera), rendering.size};
    return {
        scene_, rays, view, seed, budget_, on_gpu ? &device_scene() : nullptr, on_host ? host_rays_.get() : nullptr};
}

const Reference& Place::reference(const Rendering& view, const ReferenceWanted& wanted) {
    Rendering rendering;
    rendering.method = "path_tracing";
    rendering.parameters = wanted.parameters;
    rendering.camera = view.camera;
    rendering.size = view.size;
    const std::string key =
        nlohmann::json{wanted.parameters, wanted.passes, view.camera, view.size.width, view.size.height}.dump();
    const auto [at, is_new] = references_.try_emplace(key);
    if (!is_new) return at->second;
    try {
        Run run(rendering, *this, device_ != nullptr, reference_seed(1));
        for (uint32_t i = 0; i < wanted.passes; ++i) run.pass(i + 1 < wanted.passes);
        for (const char* layer : {"beauty", "direct", "indirect"}) {
            std::vector<float> image = run.image(layer);
            at->second.own_relative_mse[layer] = own_relative_mse(run.film, layer, image);
            at->second.meters[layer] = std::make_unique<ErrorMeter>(view.size, std::move(image));
        }
        at->second.seconds = run.seconds;
    } catch (...) {
        references_.erase(at);
        throw;
    }
    return at->second;
}

Run::Run(const Rendering& rendering, Place& place, bool on_gpu, uint64_t seed)
    : method_(make_method(rendering, on_gpu)), film(rendering.size, LayerSet()) {
    const RenderContext context = place.context(on_gpu, rendering, seed);
    const double start = wall_now_seconds();
    method_->begin(context, stats);
    begin_seconds = seconds = wall_now_seconds() - start;
}

void Run::pass(bool more_follow) {
    const double start = wall_now_seconds();
    method_->run_pass(film.next_pass(), stats, CancelToken{});
    if (more_follow) method_->expect_pass(film.next_pass() + 1);
    method_->resolve(film);
    seconds += wall_now_seconds() - start;
}

double Run::pass_alone() {
    const double start = wall_now_seconds();
    method_->run_pass(film.next_pass(), stats, CancelToken{});
    const double elapsed = wall_now_seconds() - start;
    method_->resolve(film);
    return elapsed;
}

void Run::settle() {
    const double start = wall_now_seconds();
    method_->settle();
    seconds += wall_now_seconds() - start;
}

void Run::begin_film() { film = Film(film.size(), film.layers(), film.next_pass()); }

std::vector<float> Run::image(const std::string& layer) const {
    if (layer == "beauty") return film.resolve_beauty();
    for (const LayerInfo& info : kLayers)
        if (info.name == layer) return film.resolve(info.layer);
    throw Error(ErrorCode::UnknownName, "there is no layer " + layer);
}

}  // namespace photond::bench
