// photond-gpu-bench: methods on a GPU without the service, for carrying to a bare machine with a card. Reads a list of
// what to measure (bench_list.h; all that is known of when none is given) and prints the figures as JSON, and in short
// on stderr.
//
//     photond-gpu-bench [--list FILE] [--scenes DIR] [--device gpu:0] [--only TEXT] [--scale S] [--output FILE]
//
// --scale multiplies photons, passes, builds, seconds and the image's sides: for trying a list on a slow device.
// --output is written anew after every entry, so that a run that is cut short leaves what it has. An entry that fails
// says why, and the next one follows.

#include <CLI/CLI.hpp>
#include <fstream>
#include <iostream>

#include "renderer/scene/scene.h"
#include "tests/benchmarks/gpu_bench/bench_measures.h"

namespace photond::bench {
namespace {

using nlohmann::json;

/// Those of the methods' rooms (gpu_bench.json), then comparisons.json.
const char* const kDefaultLists[] = {
#include "gpu_bench_default_lists.inc"
};

json measure(const Entry& entry, Place& place, bool on_gpu) {
    if (entry.time_to_error) return time_to_error(entry, place, on_gpu);
    if (entry.quality) return rank_by_quality(entry, place, on_gpu);
    return time_passes(entry, place, on_gpu);
}

json run_entry(const Entry& entry, Place& place) {
    const Rendering& rendering = entry.rendering;
    json result{{"name", rendering.name}, {"scene", entry.scene}, {"triangles", place.scene().triangle_count}};
    if (!entry.voxels)
        result.update({{"width", rendering.size.width},
                       {"height", rendering.size.height},
                       {"camera", find_camera(place.scene(), rendering.camera).name}});
    if (!rendering.method.empty()) result.update({{"method", rendering.method}, {"parameters", rendering.parameters}});
    for (const std::string& kind : entry.devices) {
        const bool on_gpu = kind != "cpu";
        if (on_gpu && !place.device()) continue;
        if (entry.voxels && !on_gpu)
            throw Error(ErrorCode::Unsupported, "voxels are measured on a GPU; svo_bench has the CPU's");
        result[kind] = entry.voxels ? time_voxels(entry, place) : measure(entry, place, on_gpu);
    }
    for (const Stage& stage : place.load().stages) result["load"][stage.name] = stage.wall_seconds;
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

json default_list() {
    json all = json::array();
    for (const char* list : kDefaultLists)
        for (json& entry : json::parse(list)) all.push_back(std::move(entry));
    return all;
}

json read_json(const std::string& file) {
    std::ifstream in(file);
    if (!in) throw Error(ErrorCode::NotFound, file + " cannot be opened");
    return json::parse(in);
}

/// What has been measured so far, as text.
void write_report(const json& report, const std::string& file) {
    std::ofstream out(file, std::ios::trunc);
    out << report.dump(2) << std::endl;
    if (!out) throw Error(ErrorCode::NoSpace, file + " cannot be written");
}

int run(int argc, char** argv) {
    std::string list_file, scenes = ".", id = "gpu", only, output;
    double scale = 1;
    CLI::App app{"times photond's methods on a GPU; prints JSON"};
    app.add_option("--list", list_file, "what to measure instead, a JSON array as renderer/methods/*/gpu_bench.json");
    app.add_option("--scenes", scenes, "folder of baked scenes");
    app.add_option("--device", id, "gpu, gpu:N, or cpu: no GPU at all");
    app.add_option("--only", only, "entries whose name contains that");
    app.add_option("--scale", scale, "multiplies photons, passes, builds, seconds and the image's sides")
        ->check(CLI::PositiveNumber);
    app.add_option("--output", output, "a file for the JSON, written anew after every entry; else it is printed");
    CLI11_PARSE(app, argc, argv);

    const std::vector<Entry> list = read_list(list_file.empty() ? default_list() : read_json(list_file), scale);
    std::unique_ptr<gpu::Device> device;
    if (id != "cpu") device = std::make_unique<gpu::Device>(gpu::DeviceOptions{.id = id});
    json report{{"device", device ? report_of(device->report()) : json(nullptr)},
                {"version", PHOTOND_VERSION},
                {"scale", scale},
                {"entries", json::array()}};
    std::cerr.precision(4);
    bool all_ran = true;
    std::string place_scene;
    std::unique_ptr<Place> place;  // of the entries that follow one another in one scene
    for (const Entry& entry : list) {
        const std::string& name = entry.rendering.name;
        if (name.find(only) == std::string::npos) continue;
        std::cerr << name << std::endl;
        try {
            if (!place || place_scene != entry.scene) {
                place.reset();
                place = std::make_unique<Place>(entry.scene, scenes, device.get());
                place_scene = entry.scene;
            }
            report["entries"].push_back(run_entry(entry, *place));
        } catch (const gpu::DeviceLost&) {
            throw;  // nothing can follow
        } catch (const Error& error) {
            all_ran = false;
            std::cerr << "  " << error.what() << std::endl;
            report["entries"].push_back({{"name", name}, {"error", error.what()}});
        }
        if (!output.empty()) write_report(report, output);
    }
    if (output.empty()) std::cout << report.dump(2) << std::endl;
    return all_ran ? 0 : 1;
}

}  // namespace
}  // namespace photond::bench

int main(int argc, char** argv) try { return photond::bench::run(argc, argv); } catch (const std::exception& error) {
    std::cerr << "photond-gpu-bench: " << error.what() << std::endl;
    return 2;
}
