// What is the best buy in real time: every method that runs on GPUs, by the error after so long, on the Cornell box
// with statues, Sponza, a furnished room and a conference room. On a card --seconds 0.1 and 0.016 are a tenth of a
// second and a frame of sixty a second; what a card's own time is good for, without the job's beginning,
// photond-gpu-bench ranks (tests/benchmarks/gpu_bench/real_time.json), by more settings of each.

#include "clients/cli/compare_presets.h"

namespace photond::cli {

namespace {

PresetComparison in_real_time(std::string_view name, std::string_view scene, std::string_view file,
                              std::string_view camera) {
    PresetComparison comparison{};
    comparison.name = name;
    comparison.scene = scene;
    comparison.file = file;
    comparison.camera = camera;
    comparison.width = 1280, comparison.height = 720;
    comparison.seconds = 10;
    comparison.reference = "bidirectional_path_tracing";
    comparison.reference_passes = 512;
    comparison.metrics = {"indirect:relative_mse", "indirect:flip_hdr", "flip_ldr"};
    comparison.entries = {
        "path tracing=path_tracing@gpu",
        "vertex connection and merging=vertex_connection_and_merging@gpu",
        "radiance cache=radiance_cache@gpu,gather_rays=1",
        "photon mapping=photon_mapping@gpu,gather=direct",
        "stochastic progressive photon mapping=stochastic_progressive_photon_mapping@gpu",
        "probabilistic progressive photon mapping=probabilistic_progressive_photon_mapping@gpu",
        "photon splatting=photon_splatting@gpu",
        "image-space photon mapping=image_space_photon_mapping@gpu",
        "many lights=svo_many_lights@gpu",
        "filtered many lights=svo_many_lights@gpu,filter=5",
        "many lights by voxels=svo_many_lights@gpu,visibility=svo,filter=5",
        "visibility filtering=visibility_filtering@gpu",
        "imperfect shadow maps=imperfect_shadow_maps@gpu,vpls=256,filter=8",
        "reflective shadow maps=reflective_shadow_maps@gpu",
        "light propagation volumes=light_propagation_volumes@gpu",
        "voxel cone tracing=voxel_cone_tracing@gpu",
    };
    return comparison;
}

}  // namespace

ComparePreset real_time() {
    ComparePreset preset{};
    preset.name = "real-time";
    preset.text = "every method that runs on GPUs, by its error after so long: which is the best buy";
    preset.comparisons = {
        in_real_time("box", "cornell-box", "cornell_dragon_buddha.glb", ""),
        in_real_time("sponza", "", "sponza_crytek.glb", "CameraMain"),
        in_real_time("interior", "interior", "", ""),
        in_real_time("conference", "real-time/conference", "", ""),
    };
    return preset;
}

}  // namespace photond::cli
