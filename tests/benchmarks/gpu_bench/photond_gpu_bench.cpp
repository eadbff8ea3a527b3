// photond-gpu-bench: methods on a GPU without the service, for carrying to a bare machine with a card. Reads a list of
// scenes and methods, prints what each took, stage by stage by the device's timestamps, as JSON.
//
//     photond-gpu-bench [--list FILE] [--scenes DIR] [--device gpu:0] [--only TEXT] [--scale S]
//
// The list is an array of objects as in default_list.json, which is used when none is given: a scene (a built-in one's
// name, or a file of DIR that `photonctl bake` wrote), a method and its parameters as in a job, a size, and either
// `passes` to be timed after one that is not, or `time_to_error`: seconds until indirect:relative_mse against a
// path-traced reference of that many passes comes to `target`, on each of `devices`. --scale multiplies photons, passes
// and the image's sides: for trying a list on a slow device. An entry that fails says why, and the next one follows.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <iostream>

#include "protocol/param_json.h"
#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/backends/gpu/device_intersector.h"
#include "renderer/core/rng.h"
#include "renderer/error/curve.h"
#include "renderer/error/error_meter.h"
#include "renderer/methods/path_tracing/path_tracing_gpu.h"
#include "renderer/methods/registry.h"
#include "renderer/scene/baked_scene.h"
#include "renderer/scene/builtin_scenes.h"

namespace photond {
namespace {

using nlohmann::json;

const char* const kDefaultList =
#include "gpu_bench_default_list.inc"
    ;

struct Entry {
    std::string name, scene, method;
    json parameters = json::object();
    Size2 size;
    uint32_t passes = 1;
    std::string kernels;  // of path tracing: mega, wavefront; empty: the method's choice
    std::vector<std::string> devices{"gpu"};
    std::optional<double> target;
    uint32_t reference_passes = 0;
    double most_seconds = 60;
};

Entry read_entry(const json& source, double scale) {
    Entry entry;
    entry.name = source.at("name");
    entry.scene = source.at("scene");
    entry.method = source.at("method");
    entry.parameters = source.value("parameters", json::object());
    const auto scaled = [&](double x) { return static_cast<uint32_t>(std::max(1.0, std::round(x * scale))); };
    entry.size = {scaled(source.at("width").get<double>()), scaled(source.at("height").get<double>())};
    entry.passes = scaled(source.value("passes", 1.0));
    if (entry.parameters.contains("photons")) entry.parameters["photons"] = scaled(entry.parameters["photons"]);
    entry.kernels = source.value("kernels", "");
    entry.devices = source.value("devices", entry.devices);
    if (source.contains("time_to_error")) {
        const json& wanted = source["time_to_error"];
        entry.target = wanted.at("target").get<double>();
        entry.reference_passes = scaled(wanted.at("reference_passes").get<double>());
        entry.most_seconds = wanted.value("most_seconds", entry.most_seconds) * scale;
    }
    return entry;
}

/// A scene where it is rendered: on the host, on the device, or both.
struct Place {
    Place(const std::string& name, const std::filesystem::path& folder)
        : scene(name.ends_with(".baked") ? read_baked_scene(folder / name) : make_builtin_scene(name)) {}

    /// What a method's begin() is given.
    RenderContext context(bool on_gpu, gpu::Device* device, Size2 size, uint64_t seed) {
        if (on_gpu && !device_scene) {
            device_scene.emplace(*device, scene, load);
            device_rays.emplace(*device_scene);
        }
        if (!on_gpu && !host_rays) host_rays = make_embree_intersector(scene, budget, load);
        const Intersector* rays = on_gpu ? static_cast<const Intersector*>(&*device_rays) : host_rays.get();
        return {scene, rays, View{find_camera(scene, ""), size}, seed, budget, on_gpu ? &*device_scene : nullptr};
    }

    Scene scene;
    Stats load;
    MemoryBudget budget;
    std::optional<gpu::DeviceScene> device_scene;
    std::optional<gpu::DeviceIntersector> device_rays;
    std::unique_ptr<Intersector> host_rays;
};

/// `kernels`: path tracing laid out so (PathTracingGpu::Kernels).
std::unique_ptr<Method> make_method(const std::string& name, const json& parameters, bool on_gpu,
                                    const std::string& kernels) {
    const MethodInfo* info = find_method(name);
    if (!info) throw Error(ErrorCode::UnknownName, "there is no method " + name);
    if (on_gpu ? !info->make_gpu : !info->make)
        throw Error(ErrorCode::DeviceUnavailable, name + " does not run on a " + (on_gpu ? "GPU" : "CPU"));
    const std::unique_ptr<MethodParams> params = info->make_params();
    std::vector<Fault> faults;
    read_params(*params, parameters, "/parameters", faults);
    if (!faults.empty()) throw Error(ErrorCode::OutOfRange, faults.front().pointer + ": " + faults.front().detail);
    if (on_gpu) info->check_gpu(*params);
    if (on_gpu && !kernels.empty())
        return std::make_unique<PathTracingGpu>(
            dynamic_cast<const PathTracingParams&>(*params),
            kernels == "wavefront" ? PathTracingGpu::Kernels::Wavefront : PathTracingGpu::Kernels::Mega);
    return on_gpu ? info->make_gpu(*params) : info->make(*params);
}

/// A method under way, with a job's clock: passes and what folds them into the film, nothing else.
class Run {
public:
    Run(const Entry& entry, Place& place, bool on_gpu, gpu::Device* device, uint64_t seed = 1)
        : method_(make_method(entry.method, entry.parameters, on_gpu, entry.kernels)), film(entry.size, LayerSet()) {
        const RenderContext context = place.context(on_gpu, device, entry.size, seed);
        const double start = wall_now_seconds();
        method_->begin(context, stats);
        begin_seconds = seconds = wall_now_seconds() - start;
    }
    void pass(bool more_follow) {
        const double start = wall_now_seconds();
        method_->run_pass(film.passes(), stats, CancelToken{});
        if (more_follow) method_->expect_pass(film.passes() + 1);
        method_->resolve(film);
        seconds += wall_now_seconds() - start;
    }
    /// Before something that is off the clock.
    void settle() {
        const double start = wall_now_seconds();
        method_->settle();
        seconds += wall_now_seconds() - start;
    }

private:
    std::unique_ptr<Method> method_;

public:
    Film film;
    Stats stats;
    double begin_seconds = 0, seconds = 0;
};

json counts_json(const Counts& counts, double passes) {
    json object = json::object();
    const auto add = [&](const char* name, uint64_t count) {
        if (count > 0) object[name] = static_cast<double>(count) / passes;
    };
    add("camera_rays", counts.camera_rays), add("bounce_rays", counts.bounce_rays);
    add("shadow_rays", counts.shadow_rays), add("photon_rays", counts.photon_rays);
    add("photons_emitted", counts.photons_emitted), add("photons_stored", counts.photons_stored);
    add("splats", counts.splats), add("splat_contributions", counts.splat_contributions);
    return object;
}

json time_passes(const Entry& entry, Place& place, bool on_gpu, gpu::Device* device) {
    Run run(entry, place, on_gpu, device);
    run.pass(true);  // compiles and warms up
    run.settle();
    const double before = run.seconds;
    run.stats = {};
    for (uint32_t i = 0; i < entry.passes; ++i) run.pass(i + 1 < entry.passes);
    const double passes = entry.passes, seconds = (run.seconds - before) / passes;
    json stages = json::object();
    double device_seconds = 0;
    for (const Stage& stage : run.stats.stages) {
        stages[stage.name] = {{"wall_seconds", stage.wall_seconds / passes},
                              {"gpu_seconds", stage.gpu_seconds / passes}};
        device_seconds += stage.gpu_seconds / passes;
    }
    const double rays = static_cast<double>(run.stats.counts.rays()) / passes;
    json result{{"begin_seconds", run.begin_seconds},
                {"seconds_a_pass", seconds},
                {"gpu_seconds_a_pass", device_seconds},
                {"rays_per_second", rays / seconds},
                {"stages", stages},
                {"counts_a_pass", counts_json(run.stats.counts, passes)},
                {"pixel_hash", run.film.pixel_hash()}};
    if (on_gpu) {
        result["rays_per_gpu_second"] = device_seconds > 0 ? json(rays / device_seconds) : json(nullptr);
        result["device_bytes"] = device->memory().structures();
    }
    return result;
}

/// The indirect layer of a path-traced image with as many bounces as the entry's method follows.
std::vector<float> make_reference(const Entry& entry, Place& place, gpu::Device* device) {
    Entry reference = entry;
    reference.method = "path_tracing";
    reference.parameters = json::object();
    for (const char* bounces : {"indirect_bounces", "bounces"})
        if (entry.parameters.contains(bounces)) reference.parameters["indirect_bounces"] = entry.parameters[bounces];
    Run run(reference, place, device != nullptr, device, reference_seed(1));
    for (uint32_t i = 0; i < entry.reference_passes; ++i) run.pass(i + 1 < entry.reference_passes);
    return run.film.resolve(Layer::Indirect);
}

json time_to_error(const Entry& entry, Place& place, bool on_gpu, gpu::Device* device, const ErrorMeter& meter) {
    Run run(entry, place, on_gpu, device);
    CurveSchedule schedule;
    std::vector<TimedError> curve;
    json points = json::array();
    while (run.seconds < entry.most_seconds && (curve.empty() || curve.back().error > *entry.target)) {
        run.pass(!schedule.is_due(run.film.passes() + 1, run.seconds));
        if (!schedule.is_due(run.film.passes(), run.seconds)) continue;
        run.settle();
        schedule.skip_to(run.film.passes(), run.seconds);
        const double error = meter.measure(Metric::RelativeMse, run.film.resolve(Layer::Indirect)).at(0);
        curve.push_back({run.seconds, error});
        points.push_back({{"seconds", run.seconds}, {"passes", run.film.passes()}, {"error", error}});
    }
    const std::optional<double> reached = photond::time_to_error(curve, *entry.target);
    return {
        {"seconds_to_error", reached ? json(*reached) : json(nullptr)}, {"target", *entry.target}, {"curve", points}};
}

json run_entry(const Entry& entry, const std::filesystem::path& folder, gpu::Device* device) {
    Place place(entry.scene, folder);
    json result{{"name", entry.name},
                {"scene", entry.scene},
                {"method", entry.method},
                {"parameters", entry.parameters},
                {"width", entry.size.width},
                {"height", entry.size.height},
                {"triangles", place.scene.triangle_count}};
    std::optional<ErrorMeter> meter;
    if (entry.target) meter.emplace(entry.size, make_reference(entry, place, device));
    for (const std::string& kind : entry.devices) {
        const bool on_gpu = kind != "cpu";
        if (on_gpu && !device) continue;
        result[kind] = entry.target ? time_to_error(entry, place, on_gpu, device, *meter)
                                    : time_passes(entry, place, on_gpu, device);
    }
    for (const Stage& stage : place.load.stages) result["load"][stage.name] = stage.wall_seconds;
    return result;
}

json report_of(const gpu::DeviceReport& device) {
    const gpu::Limits& limits = device.limits;
    return {{"id", device.id},
            {"name", device.name},
            {"driver", device.driver},
            {"software", device.software},
            {"memory_bytes", device.memory_bytes},
            {"storage_buffer_range", limits.storage_buffer_range},
            {"shared_memory", limits.shared_memory},
            {"subgroup_size", limits.subgroup_size}};
}

int run(int argc, char** argv) {
    std::string list_file, scenes = ".", id = "gpu", only;
    double scale = 1;
    CLI::App app{"times photond's methods on a GPU; prints JSON"};
    app.add_option("--list", list_file, "scenes and methods, as default_list.json");
    app.add_option("--scenes", scenes, "folder of baked scenes");
    app.add_option("--device", id, "gpu, gpu:N, or cpu: no GPU at all");
    app.add_option("--only", only, "entries whose name contains that");
    app.add_option("--scale", scale, "multiplies photons, passes and the image's sides")->check(CLI::PositiveNumber);
    CLI11_PARSE(app, argc, argv);

    json list;
    if (list_file.empty()) {
        list = json::parse(kDefaultList);
    } else {
        std::ifstream in(list_file);
        if (!in) throw Error(ErrorCode::NotFound, list_file + " cannot be opened");
        list = json::parse(in);
    }
    std::unique_ptr<gpu::Device> device;
    if (id != "cpu") device = std::make_unique<gpu::Device>(gpu::DeviceOptions{.id = id});
    json entries = json::array();
    bool all_ran = true;
    for (const json& source : list) {
        const Entry entry = read_entry(source, scale);
        if (entry.name.find(only) == std::string::npos) continue;
        std::cerr << entry.name << std::endl;
        try {
            entries.push_back(run_entry(entry, scenes, device.get()));
        } catch (const gpu::DeviceLost&) {
            throw;  // nothing can follow
        } catch (const Error& error) {
            all_ran = false;
            entries.push_back({{"name", entry.name}, {"error", error.what()}});
        }
    }
    const json device_report = device ? report_of(device->report()) : json(nullptr);
    std::cout << json{{"device", device_report}, {"version", PHOTOND_VERSION}, {"entries", entries}}.dump(2)
              << std::endl;
    return all_ran ? 0 : 1;
}

}  // namespace
}  // namespace photond

int main(int argc, char** argv) try { return photond::run(argc, argv); } catch (const std::exception& error) {
    std::cerr << "photond-gpu-bench: " << error.what() << std::endl;
    return 2;
}
