// [Yao 2011] (docs/design/sources.md), chapter 5: Table 1, Table 2, and what its soft shadows and its upsampling cost
// in quality.
//
// "soft" and "hard" are image_space_photon_mapping at the thesis' settings: photons drawn over the pixels as whole
// quads of one size, indirect light at fewer pixels, one shadow ray a pixel to the middle of the lamp, blurred or not.
// "ours" is the method at its defaults. The thesis says of its scenes neither their size nor where they are seen from;
// its radii are taken as those of scenes of 55 units, which leaves about thirty photons on a footprint.

#include "clients/cli/compare_presets.h"

namespace photond::cli {

namespace {

const std::string kIspm = "image_space_photon_mapping@gpu";
const std::string kIspmThesis = ",footprint=quad,boundary=none,scatter=raster,shrink=false,projection_maps=false";

/// A row of Table 1.
struct ThesisRow {
    std::string_view name, scene, file;
    int subsampling, bounces, photons;
    double radius_relative;
    int blur_samples;
    double soft_fps, hard_fps;
};
constexpr ThesisRow kTable1[] = {
    {"box-1", "cornell-box", "cornell_box.glb", 8, 1, 10'000, 0.09, 5, 32, 107},
    {"box-2", "cornell-box", "cornell_box.glb", 8, 2, 20'000, 0.09, 5, 27, 85},
    {"buddha", "cornell-box-glossy", "cornell_diffuse_buddha.glb", 4, 1, 10'000, 0.09, 5, 20, 40},
    {"dragon", "cornell-box-spot", "cornell_diffuse_dragon.glb", 4, 3, 30'000, 0.09, 5, 23, 35},
    {"glass-sphere", "cornell-box-glass", "cornell_glass_sphere.glb", 4, 2, 20'000, 0.09, 5, 34, 70},
    {"glass-bunny", "progressive/torus", "cornell_glass_bunny.glb", 4, 2, 20'000, 0.09, 5, 32, 63},
    {"sibenik", "doors/ajar", "sibenik.glb", 2, 2, 20'000, 0.05, 7, 12, 35},
    {"sponza", "interior", "sponza_crytek.glb", 2, 2, 20'000, 0.06, 7, 9, 20},
};

/// A row of Table 2; all at 8 x 8, four and five samples.
struct FormsRow {
    std::string_view name, scene, file;
    int bounces, photons;
    double radius_relative;
    double quad_soft_fps, quad_hard_fps, volume_soft_fps, volume_hard_fps;
};
constexpr FormsRow kTable2[] = {
    {"forms-box-2", "cornell-box", "cornell_box.glb", 2, 20'000, 0.09, 22.0, 61.0, 21.0, 60.7},
    {"forms-box-3", "cornell-box", "cornell_box.glb", 3, 30'000, 0.09, 23.0, 61.4, 20.4, 54.0},
    {"forms-buddha", "cornell-box-glossy", "cornell_diffuse_buddha.glb", 3, 30'000, 0.09, 11.7, 42.1, 11.3, 37.2},
    {"forms-dragon", "cornell-box-spot", "cornell_diffuse_dragon.glb", 3, 30'000, 0.09, 21.2, 56.3, 20.5, 50.9},
    {"forms-bunny", "progressive/torus", "cornell_glass_bunny.glb", 3, 30'000, 0.09, 22.0, 60.3, 20.6, 51.4},
    {"forms-sibenik", "doors/ajar", "sibenik.glb", 3, 30'000, 0.05, 22.0, 43.0, 18.9, 33.0},
    {"forms-sponza", "interior", "sponza_crytek.glb", 3, 30'000, 0.05, 27.5, 46.4, 24.7, 39.5},
};

std::string setting(std::string_view name, double value) {
    std::string digits = std::to_string(value);
    digits.erase(digits.find_last_not_of('0') + 1);
    if (digits.back() == '.') digits.pop_back();
    return "," + std::string(name) + "=" + digits;
}

template <class Row>
std::string photons_of(const Row& row) {
    return setting("bounces", row.bounces) + setting("photons", row.photons) +
           setting("radius_relative", row.radius_relative);
}

template <class Row>
PresetComparison on_scene_of(const Row& row) {
    PresetComparison comparison{};
    comparison.name = row.name;
    comparison.scene = row.scene;
    comparison.file = row.file;
    comparison.width = 1024, comparison.height = 768;
    comparison.metrics = {"relative_mse", "indirect:relative_mse", "flip_ldr"};
    return comparison;
}

double ms(double fps) { return 1000 / fps; }

PublishedStages frame_stages(std::string_view text, std::vector<std::string_view> rows, std::vector<double> frame_ms) {
    return {text,
            std::move(rows),
            {{"frame",
              {"direct", "rsm", "photon_tracing", "photon_map_build", "splat", "upsample", "soft_shadows", "combine",
               "merge", "readback"},
              false,
              std::move(frame_ms)},
             {"G-buffer, shadow ray", {"direct"}, false, {}},
             {"photons", {"rsm", "photon_tracing", "photon_map_build"}, false, {}},
             {"splatting", {"splat"}, false, {}},
             {"upsampling, soft shadow, sum", {"upsample", "soft_shadows", "combine", "merge"}, false, {}},
             {"readback", {"readback"}, false, {}}}};
}

/// A frame's time beside the thesis', and the error of as many as fit in the time.
PresetComparison table_1(const ThesisRow& row) {
    PresetComparison comparison = on_scene_of(row);
    const std::string thesis = kIspm + kIspmThesis + photons_of(row) + setting("subsampling", row.subsampling);
    const auto texels = row.photons / 2;  // a whole number of them
    const std::string samples = ",soft_shadow=gather" + setting("shadow_blur_samples", row.blur_samples);
    comparison.seconds = 10;
    comparison.reference = "path_tracing,indirect_bounces=" + std::to_string(row.bounces);
    comparison.reference_passes = 256;
    comparison.entries = {
        "soft=" + thesis + samples,
        "hard=" + thesis + ",soft_shadow=none",
        "soft in three steps=" + thesis + samples + ",one_pass=false",
        "soft by tiles=" + thesis + samples + ",scatter=tiles",
        "soft with a bounce map=" + thesis + samples + setting("bounce_map_texels", texels),
        "ours=" + kIspm + setting("bounces", row.bounces),
        "path tracing=path_tracing,indirect_bounces=" + std::to_string(row.bounces),
    };
    comparison.stages = frame_stages("Table 1 of the thesis (GeForce GTX 480), ms", {"soft", "hard"},
                                     {ms(row.soft_fps), ms(row.hard_fps)});
    return comparison;
}

/// What gathered shadows and light at fewer pixels cost: frames of the same photons against one with shadow rays, all
/// of whose pixels are lit.
PresetComparison quality(const ThesisRow& row, std::string_view name) {
    PresetComparison comparison = on_scene_of(row);
    const std::string thesis = kIspm + kIspmThesis + photons_of(row);
    const std::string few = thesis + setting("subsampling", row.subsampling);
    const std::string samples = setting("shadow_blur_samples", row.blur_samples);
    comparison.name = name;
    comparison.frames = 16;
    comparison.reference = thesis;
    comparison.metrics = {"flip_ldr", "relative_mse", "indirect:relative_mse"};
    comparison.entries = {
        "gathered shadows=" + thesis + ",soft_shadow=gather" + samples,
        "shadows of one radius=" + thesis + ",soft_shadow=fixed_radius" + samples,
        "hard shadows=" + thesis + ",soft_shadow=none",
        "nearest=" + few + ",upsampling=nearest",
        "bilinear=" + few + ",upsampling=bilinear",
        "and normals=" + few + ",upsampling=normal",
        "and depth=" + few + ",upsampling=geometry",
    };
    return comparison;
}

PresetComparison table_2(const FormsRow& row) {
    PresetComparison comparison = on_scene_of(row);
    const std::string thesis = kIspm + kIspmThesis + photons_of(row) + ",subsampling=8";
    const std::string soft = ",soft_shadow=gather", hard = ",soft_shadow=none";
    const std::string volume = ",footprint=volume,volume_height=1";
    comparison.seconds = 10;
    comparison.reference = "path_tracing,indirect_bounces=" + std::to_string(row.bounces);
    comparison.reference_passes = 64;
    comparison.entries = {
        "quad soft=" + thesis + soft,
        "quad hard=" + thesis + hard,
        "icosahedron soft=" + thesis + soft + volume,
        "icosahedron hard=" + thesis + hard + volume,
        "compressed icosahedron hard=" + thesis + hard + ",footprint=volume",
        "auto hard=" + thesis + hard + ",footprint=auto",
    };
    comparison.stages =
        frame_stages("Table 2 of the thesis (GeForce GTX 480), ms",
                     {"quad soft", "quad hard", "icosahedron soft", "icosahedron hard"},
                     {ms(row.quad_soft_fps), ms(row.quad_hard_fps), ms(row.volume_soft_fps), ms(row.volume_hard_fps)});
    return comparison;
}

}  // namespace

ComparePreset ispm_thesis() {
    ComparePreset preset{};
    preset.name = "ispm-thesis";
    preset.text =
        "Tables 1 and 2 of the thesis on image-space photon mapping with soft shadows, and what its shortcuts cost";
    for (const ThesisRow& row : kTable1) preset.comparisons.push_back(table_1(row));
    static const std::string kNames[] = {"quality-box-1",   "quality-box-2",        "quality-buddha",
                                         "quality-dragon",  "quality-glass-sphere", "quality-glass-bunny",
                                         "quality-sibenik", "quality-sponza"};
    static_assert(std::size(kNames) == std::size(kTable1));
    for (size_t i = 0; i < std::size(kTable1); ++i) preset.comparisons.push_back(quality(kTable1[i], kNames[i]));
    for (const FormsRow& row : kTable2) preset.comparisons.push_back(table_2(row));
    return preset;
}

}  // namespace photond::cli
