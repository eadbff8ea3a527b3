// [Chen 2014] (docs/design/sources.md): Table 1, Figures 5 and 6, and what each of the method's answers costs in error.
//
// "paper" is visibility_filtering at the paper's settings: its numbers of proxies and voxels, lists of whether a voxel
// was met, at 64 x 64 and 128 x 128 of 512 x 512 pixels, light at 256 x 256. The paper says neither how many rays a
// pixel shoots nor up to where proxies count one by one; 64 and 1.5 voxels here. "ours" is the method at its defaults.

#include "clients/cli/compare_presets.h"

namespace photond::cli {

namespace {

const std::string kProxies = "visibility_filtering@gpu";
const std::string kProxiesPaper = kProxies + ",disc_scale=1,filter_side=7,subsampling=2,near_voxels=1.5,rays=64";
const std::string kOneBounce = "path_tracing,indirect_bounces=1";

/// A column of Table 1.
struct PaperColumn {
    std::string_view name, scene, file, camera;
    int proxies, voxels, march_subsampling;
    std::vector<double> published_ms;  // voxelisation, marching, filter, illumination, upsampling
};

std::string paper_entry(const PaperColumn& column) {
    return kProxiesPaper + ",proxies=" + std::to_string(column.proxies) + ",voxels=" + std::to_string(column.voxels) +
           ",march_subsampling=" + std::to_string(column.march_subsampling);
}

/// One bounce on that scene, against path tracing's.
PresetComparison one_bounce_on(std::string_view name, std::string_view scene, std::string_view file,
                               std::string_view camera) {
    PresetComparison comparison{};
    comparison.name = name;
    comparison.scene = scene;
    comparison.file = file;
    comparison.camera = camera;
    comparison.width = comparison.height = 512;
    comparison.seconds = 10;
    comparison.reference = kOneBounce;
    comparison.reference_passes = 256;
    comparison.metrics = {"indirect:relative_mse", "indirect:flip_hdr"};
    return comparison;
}

PresetComparison table_1(const PaperColumn& column) {
    PresetComparison comparison = one_bounce_on(column.name, column.scene, column.file, column.camera);
    const std::string paper = paper_entry(column);
    comparison.entries = {
        "paper=" + paper + ",lists=indices",
        "by the number of lists=" + paper + ",lists=indices,normalisation=paper",
        "sets of bits=" + paper + ",lists=bits",
        "without the filter=" + paper + ",lists=bits,filter_side=1",
        "octree=" + paper + ",lists=bits,visibility=svo",
        "shadow rays=" + paper + ",visibility=rays",
        "counts=" + paper + ",lists=counts",
        "ours=" + kProxies,
        "path tracing=" + kOneBounce,
    };
    const std::vector<double>& ms = column.published_ms;
    comparison.stages = {"Table 1 of the paper (GeForce GTX 670), ms",
                         {"paper"},
                         {{"voxelization", {"vpl_generation", "voxelise"}, false, {ms[0]}},
                          {"ray marching", {"march"}, false, {ms[1]}},
                          {"visibility filter", {"visibility_filter"}, false, {ms[2]}},
                          {"illumination", {"gather"}, false, {ms[3]}},
                          {"upsampling", {"upsample"}, false, {ms[4]}},
                          {"direct light", {"direct"}, false, {}}}};
    return comparison;
}

/// Beside the other methods of many lights in the same time: imperfect shadow maps at the paper's 4,096 lights and
/// 8,000 points among them (Figure 5).
PresetComparison beside(std::string_view name, std::string_view scene) {
    PresetComparison comparison = one_bounce_on(name, scene, "", "");
    comparison.entries = {
        "ours=" + kProxies,
        "ours by rays=" + kProxies + ",visibility=rays",
        "paper=" + kProxiesPaper + ",proxies=24000,voxels=6,march_subsampling=8,lists=bits",
        "imperfect shadow maps=imperfect_shadow_maps@gpu",
        "imperfect shadow maps of the paper=imperfect_shadow_maps@gpu,vpls=4096,points=8000,shadow_resolution=64",
        "svo=svo_many_lights@gpu,bounces=1",
        "path tracing=" + kOneBounce,
    };
    return comparison;
}

/// Narrow lobes by the BSDF and by the paper's Gaussian, as the glossiness changes (Figure 6).
PresetComparison gloss(std::string_view name, std::string_view scene) {
    PresetComparison comparison = one_bounce_on(name, scene, "", "");
    const std::string paper = kProxiesPaper + ",proxies=24000,voxels=6,march_subsampling=8,lists=bits";
    comparison.entries = {"ggx=" + paper, "paper=" + paper + ",specular=paper", "ours=" + kProxies,
                          "ours with the paper's lobe=" + kProxies + ",specular=paper"};
    return comparison;
}

}  // namespace

ComparePreset visibility_filtering_paper() {
    ComparePreset preset{};
    preset.name = "visibility-filtering-paper";
    preset.text =
        "Table 1 and Figures 5 and 6 of the paper on visibility filtering, and what each of its answers costs";
    preset.comparisons = {
        table_1({"box-64", "cornell-box", "cornell_box.glb", "", 24'000, 6, 8, {0.26, 89.6, 18.9, 326, 7.9}}),
        table_1({"box-128", "cornell-box", "cornell_box.glb", "", 24'000, 6, 4, {0.26, 272.7, 77.2, 396.6, 7.9}}),
        table_1({"sponza", "interior", "sponza_crytek.glb", "", 170'000, 20, 4, {1.56, 182.3, 110.6, 323.4, 8.1}}),
        beside("beside-box", "cornell-box"),
        beside("beside-spot", "cornell-box-spot"),
        beside("beside-glossy", "cornell-box-glossy"),
        beside("beside-interior", "interior"),
        gloss("gloss-10", "visibility-filtering/glossiness-10"),
        gloss("gloss-30", "visibility-filtering/glossiness-30"),
        gloss("gloss-50", "visibility-filtering/glossiness-50"),
        gloss("gloss-box", "cornell-box-glossy"),
        gloss("gloss-interior", "interior"),
    };
    return preset;
}

}  // namespace photond::cli
