// What one frame can leave to the next: methods with and without reuse at equal time a frame, on the moving Cornell box
// and on Sponza with a swinging lamp and a walking figure, which tests/benchmarks/moving_sponza.py makes.

#include "clients/cli/compare_presets.h"

namespace photond::cli {

namespace {

PresetComparison with_and_without_reuse(std::string_view name) {
    PresetComparison comparison{};
    comparison.name = name;
    comparison.reference = "path_tracing";
    comparison.entries = {
        "path tracing=path_tracing",
        "path tracing with reprojection=path_tracing,temporal=reproject",
        "radiance cache=radiance_cache",
        "radiance cache with reprojection=radiance_cache,temporal=reproject",
        "aged radiance cache=radiance_cache,aged=true",
        "aged radiance cache with reprojection=radiance_cache,aged=true,temporal=reproject",
        "many lights=svo_many_lights",
        "many lights with reprojection=svo_many_lights,temporal=reproject",
        "incremental many lights=svo_many_lights,incremental=true",
        "incremental many lights with reprojection=svo_many_lights,incremental=true,temporal=reproject",
        "photon splatting=photon_splatting",
        "photon splatting with reprojection=photon_splatting,temporal=reproject",
    };
    return comparison;
}

}  // namespace

ComparePreset moving() {
    PresetComparison box = with_and_without_reuse("cornell-box");
    box.scene = "moving/cornell-box";
    box.width = box.height = 96;
    box.seconds = 0.25;
    box.reference_passes = 48;
    box.sequence = {.count = 16, .fps = 8};

    PresetComparison sponza = with_and_without_reuse("sponza");
    sponza.file = "sponza_moving.glb";
    sponza.camera = "CameraWalk";
    sponza.width = 128, sponza.height = 72;
    sponza.seconds = 0.5;
    sponza.reference_passes = 24;
    sponza.sequence = {.count = 12, .fps = 6};

    ComparePreset preset{};
    preset.name = "moving";
    preset.text = "error, flicker and lag of a moving scene with what one frame leaves to the next, and without";
    preset.comparisons = {box, sponza};
    return preset;
}

}  // namespace photond::cli
