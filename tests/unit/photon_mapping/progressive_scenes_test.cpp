// The scenes of the papers on progressive photon mapping are what they are made for: their light comes through glass
// alone, photons bring it, and a path from the eye that must meet the light by itself does not find it.

#include <gtest/gtest.h>

#include "renderer/methods/photon_mapping/photon_mapping.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/path_render.h"

namespace photond::progressive_scenes_test {
namespace {

constexpr Size2 kSize{32, 24};

Film trace_paths(const Scene& scene, uint32_t bounces, uint32_t passes) {
    test::RenderSettings settings;
    settings.size = kSize, settings.passes = passes;
    settings.layers.add(Layer::Albedo);
    settings.params.indirect_bounces = bounces;
    return test::render(scene, settings);
}

Film map_photons(const Scene& scene, uint32_t bounces) {
    test::RenderSettingsOf<PhotonMapping> settings;
    settings.size = kSize;
    settings.layers.add(Layer::Albedo);
    settings.params.gather = Gather::Direct;
    settings.params.photons = 5000;
    settings.params.indirect_bounces = bounces;
    return test::render(scene, settings);
}

Scene without_glass(Scene scene) {
    std::erase_if(scene.instances, [&](const Instance& instance) {
        return scene.materials[scene.meshes[instance.mesh].material].transmission > 0;
    });
    finish_scene(scene);
    return scene;
}

TEST(ProgressiveScenes, AllLightComesThroughGlass) {
    // Shadow rays do not pass glass: light that is direct has found a way around it.
    for (const char* name :
         {"progressive/lamp", "progressive/box", "progressive/mirror-bathroom", "progressive/flashlight"}) {
        const Scene scene = make_builtin_scene(name);
        EXPECT_EQ(test::mean_of(trace_paths(scene, 0, 8).resolve(Layer::Direct)), 0) << name;
        EXPECT_GT(test::mean_of(trace_paths(without_glass(scene), 0, 1).resolve(Layer::Direct)), 0.01) << name;
        const double lit = test::mean_of(map_photons(scene, 4).resolve(Layer::Indirect));
        EXPECT_GT(lit, 0.03) << name;
        EXPECT_LT(lit, 3) << name;
    }
}

/// Mean of a layer over the pixels where the first surface that is no glass is the torus; one pass, so that each pixel
/// is one surface's. Its clay is yellow, the floor grey.
double mean_on_torus(const Film& film, Layer layer) {
    const std::vector<float> albedo = film.resolve(Layer::Albedo), values = film.resolve(layer);
    double sum = 0;
    size_t count = 0;
    for (size_t i = 0; i < albedo.size(); i += 3) {
        if (!(albedo[i + 2] < 0.5f * albedo[i])) continue;
        for (size_t c = i; c < i + 3; ++c) sum += double(values[c]);
        ++count;
    }
    EXPECT_GT(count, kSize.pixels() / 20) << "the torus is hardly to be seen";
    return sum / (3 * double(count));
}

TEST(ProgressiveScenes, PathsFromTheEyeDoNotFindASpotThroughGlass) {
    const Scene scene = make_builtin_scene("progressive/torus-spot");
    // One bounce: the light, the glass, the torus. With more, the torus sees the lit floor by way of the glass.
    const Film paths = trace_paths(scene, 1, 1), photons = map_photons(scene, 1);
    EXPECT_EQ(mean_on_torus(paths, Layer::Direct), 0);
    EXPECT_EQ(mean_on_torus(paths, Layer::Indirect), 0);
    EXPECT_EQ(mean_on_torus(photons, Layer::Direct), 0);
    EXPECT_GT(mean_on_torus(photons, Layer::Indirect), 0.05);
    EXPECT_GT(test::mean_of(paths.resolve(Layer::Direct)), 0.05) << "the floor is lit directly";
}

TEST(ProgressiveScenes, PhotonsLightTheTorusUnderAnAreaLight) {
    const Scene scene = make_builtin_scene("progressive/torus");
    EXPECT_EQ(mean_on_torus(trace_paths(scene, 0, 1), Layer::Direct), 0) << "shadow rays end at the glass";
    EXPECT_GT(mean_on_torus(map_photons(scene, 1), Layer::Indirect), 0.05);
}

}  // namespace
}  // namespace photond::progressive_scenes_test
