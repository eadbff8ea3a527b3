// [Sun 2015] (docs/design/sources.md), chapter 5: Table 5.1, Figures 5.1 and 5.2, and what is said beside them.
//
// "thesis" is svo_many_lights at the thesis' settings: 4 x 4 interleaving, voxels for visibility, shadow maps for the
// scene's own point and spot lights, a clamp that is not repaid, a geometry-aware box filter of twice the block. "ours"
// asks rays of lights chosen for each point, repays the clamp and filters nothing: no bias is left. The thesis' box has
// a dragon, an elephant and two spot lights, its Sponza one spot light: ours have a dragon and a Buddha below the
// box's area light, and a sun beside the spot light.

#include "clients/cli/compare_presets.h"

namespace photond::cli {

namespace {

const std::string kThesis =
    "svo_many_lights,visibility=svo,vpl_choice=interleaved,interleave=4,filter=8,direct=shadow_maps,repay=false,narrow_"
    "lobes=false";
const std::string kThesisInBox = kThesis + ",bounces=1,voxel_resolution=128";
const std::string kThesisInSponza = kThesis + ",bounces=1,voxel_resolution=256";
const std::string kOurs = "svo_many_lights,vpls=1024,visibility=rays,vpl_choice=resampled,repay=true";

PublishedStages table_5_1(std::vector<double> voxels_ms, std::vector<double> rsm_ms, std::vector<double> vpls_ms,
                          std::vector<double> direct_ms, std::vector<double> indirect_ms) {
    return {"Table 5.1 of the thesis (GeForce Titan X), ms",
            {"thesis, vpls 512", "thesis, vpls 1024", "thesis, vpls 2048"},
            {
                {"scene voxelization and SVO generation", {"voxelise", "svo_build"}, true, std::move(voxels_ms)},
                {"RSM rendering", {"rsm"}, false, std::move(rsm_ms)},
                {"VPL generation", {"vpl_generation"}, false, std::move(vpls_ms)},
                {"direct illumination", {"direct"}, false, std::move(direct_ms)},
                {"indirect illumination", {"indirect"}, false, std::move(indirect_ms)},
                {"shadow maps", {"shadow_maps"}, true, {}},
                {"G-buffer, split", {"g_buffer", "g_buffer_split"}, false, {}},
                {"merge, filter", {"merge", "filter"}, false, {}},
                {"readback", {"readback"}, false, {}},
            }};
}

/// What is sooner at an equal error, one bounce: time to indirect:relative_mse, and the stages of a pass.
PresetComparison timed(const std::string& thesis) {
    PresetComparison comparison{};
    comparison.seconds = 30;
    comparison.reference = "path_tracing,indirect_bounces=1";
    comparison.reference_passes = 256;
    comparison.metrics = {"indirect:relative_mse", "relative_mse", "flip_ldr"};
    comparison.entries = {
        "thesis=" + thesis,
        "ours=" + kOurs + ",bounces=1",
        "photon splatting=photon_splatting,bounces=1",
        "photon mapping=photon_mapping,gather=direct,indirect_bounces=1",
        "path tracing=path_tracing,indirect_bounces=1",
    };
    comparison.sweeps = {"thesis:vpls=512,1024,2048"};
    return comparison;
}

PresetComparison in_box(PresetComparison comparison) {
    comparison.scene = "cornell-box-spot";
    comparison.file = "cornell_dragon_buddha.glb";
    comparison.width = comparison.height = 768;
    return comparison;
}

PresetComparison in_sponza(PresetComparison comparison) {
    comparison.scene = "interior";
    comparison.file = "sponza_crytek.glb";
    comparison.camera = "CameraMain";
    comparison.width = 1280, comparison.height = 720;
    return comparison;
}

/// "The visual difference between two settings is very small" (512 and 2048 lights), and 256^3 voxels instead of 128^3
/// are a "negligible" improvement: one frame of each against one of 2048 lights and 128^3 voxels.
PresetComparison frames_in_box() {
    PresetComparison comparison{};
    comparison.frames = 1;
    comparison.reference = kThesisInBox + ",vpls=2048";
    comparison.metrics = {"flip_ldr", "indirect:relative_mse", "relative_mse"};
    comparison.entries = {
        "thesis=" + kThesisInBox,
        "256^3 voxels=" + kThesis + ",bounces=1,voxel_resolution=256,vpls=2048",
    };
    comparison.sweeps = {"thesis:vpls=512,1024"};
    return in_box(comparison);
}

/// "One-bounce indirect illumination is not enough to illuminate all the regions": one, two and three bounces against
/// all that light makes. The lights of the thesis' further bounces are found by the voxels.
PresetComparison bounces_in_sponza() {
    PresetComparison comparison{};
    comparison.seconds = 30;
    comparison.reference = "path_tracing";
    comparison.reference_passes = 256;
    comparison.metrics = {"indirect:relative_mse", "relative_mse", "flip_ldr"};
    comparison.entries = {
        "thesis=" + kThesis + ",voxel_resolution=256,vpls=1024,bounce_tracing=voxels",
        "ours=" + kOurs,
    };
    comparison.sweeps = {"thesis:bounces=1,2,3", "ours:bounces=1,2,3"};
    return in_sponza(comparison);
}

}  // namespace

ComparePreset svo_thesis() {
    ComparePreset preset{};
    preset.name = "svo-thesis";
    preset.text = "Table 5.1 and the claims of the thesis on many lights and a sparse voxel octree, and what is sooner";

    PresetComparison box = in_box(timed(kThesisInBox));
    box.name = "cornell";
    box.stages =
        table_5_1({0.57, 0.57, 0.58}, {0.46, 0.46, 0.46}, {0.02, 0.02, 0.02}, {0.17, 0.17, 0.18}, {16, 33, 69});
    preset.comparisons.push_back(box);

    PresetComparison frames = frames_in_box();
    frames.name = "cornell-frames";
    preset.comparisons.push_back(frames);

    PresetComparison sponza = in_sponza(timed(kThesisInSponza));
    sponza.stages =
        table_5_1({4.65, 4.65, 4.65}, {0.61, 0.62, 0.62}, {0.02, 0.02, 0.02}, {0.31, 0.31, 0.31}, {19.5, 36.2, 73});
    sponza.name = "sponza";
    preset.comparisons.push_back(sponza);
    sponza.scene = "";  // stands in for one camera only
    for (const auto& [name, camera] :
         std::initializer_list<std::pair<std::string_view, std::string_view>>{{"sponza-alternate", "CameraAlternate"},
                                                                              {"sponza-balcony", "CameraBalcony"},
                                                                              {"sponza-alcove", "CameraAlcove"}}) {
        sponza.name = name, sponza.camera = camera;
        preset.comparisons.push_back(sponza);
    }

    PresetComparison bounces = bounces_in_sponza();
    bounces.name = "sponza-bounces";
    preset.comparisons.push_back(bounces);
    return preset;
}

}  // namespace photond::cli
