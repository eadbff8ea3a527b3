// Light must not pass a thin wall (hard-cases.md, "Thin walls"). A tunnel, its lamp at one end, is closed in the middle
// by a wall 1e-3 to 1e-5 of the scene thick; the camera stands on the dark side. These are not statistics: dark is
// exactly 0.

#include <gtest/gtest.h>

#include "renderer/methods/photon_mapping/photon_mapping.h"
#include "renderer/scene/mesh_builder.h"
#include "tests/support/render.h"
#include "tests/support/scene_parts.h"

namespace photond::photon_mapping_walls_test {
namespace {

using test::lambert;

constexpr float kLength = 4;  // [m], along x about the origin; 2 high and 2 wide

/// The lamp is the end at -x; floor, ceiling and sides have `tunnel_albedo`. `reach`: of the wall, 1 to where they are.
/// There one light path in 100,000 slips into the seam and lights the wall from within; none where it stands into them.
Scene divided_tunnel(float thickness, float tunnel_albedo, float reach) {
    constexpr float a = kLength / 2;
    const float w = thickness / 2;
    Scene scene;
    scene.materials = {lambert(tunnel_albedo), lambert(0.8f), lambert(0, 1)};
    scene.meshes = {MeshBuilder()
                        .quad({-a, -1, 1}, {a, -1, 1}, {a, -1, -1}, {-a, -1, -1})
                        .quad({-a, 1, -1}, {a, 1, -1}, {a, 1, 1}, {-a, 1, 1})
                        .quad({-a, -1, -1}, {a, -1, -1}, {a, 1, -1}, {-a, 1, -1})
                        .quad({a, -1, 1}, {-a, -1, 1}, {-a, 1, 1}, {a, 1, 1})
                        .quad({a, -1, -1}, {a, -1, 1}, {a, 1, 1}, {a, 1, -1})
                        .build(0),
                    MeshBuilder().box({-w, -reach, -reach}, {w, reach, reach}).build(1),
                    MeshBuilder().quad({-a, -1, 1}, {-a, -1, -1}, {-a, 1, -1}, {-a, 1, 1}).build(2)};
    for (uint32_t i = 0; i < scene.meshes.size(); ++i) scene.instances.push_back({.mesh = i});
    scene.cameras = {look_at_camera({a - 0.1, 0.1, 0.1}, {0, 0, 0}, {0, 1, 0}, 1.5f)};
    finish_scene(scene);
    return scene;
}

using Settings = test::RenderSettingsOf<PhotonMapping>;

Settings settings_of(Gather gather, PhotonSearch::Kind search) {
    Settings settings;
    settings.size = {48, 48};
    settings.params.photons = 20'000;
    settings.params.gather = gather;
    settings.params.gather_rays = 16;
    settings.params.search = search;
    settings.params.radius_m = 0.1f;
    settings.layers.add(Layer::Position);
    return settings;
}

constexpr float kThickness[] = {1e-3f * kLength, 1e-4f * kLength, 1e-5f * kLength};

TEST(ThinWall, NoLightOnItsDarkFace) {
    for (const float thickness : kThickness)
        for (const Gather gather : {Gather::Direct, Gather::Final})
            for (const PhotonSearch::Kind search : {PhotonSearch::Kind::Nearest, PhotonSearch::Kind::Radius}) {
                // In a black tunnel only the wall has photons: the lit face's must not count on the other.
                Stats stats;
                const Film film = test::render(divided_tunnel(thickness, 0, 1.1f), settings_of(gather, search), &stats);
                for (const float value : film.resolve_beauty())
                    ASSERT_EQ(value, 0.0f)
                        << "thickness " << thickness << ", gather " << int(gather) << ", search " << int(search);
            }
}

TEST(ThinWall, LightsTheTunnelsFloorBehindItNoFartherThanTheRadius) {
    // The floor runs on under the wall: a disc of density estimation reaches over to its lit part. Clipped discs take
    // no photon from there but where none of the places that were looked up lies there. Farther than the radius from
    // the wall there is no leak at all.
    for (const float thickness : kThickness) {
        double leaked[2] = {};  // with whole discs, with clipped ones
        for (const DiscBoundary boundary : {DiscBoundary::None, DiscBoundary::Clip}) {
            Settings settings = settings_of(Gather::Direct, PhotonSearch::Kind::Radius);
            settings.params.boundary = boundary;
            const Film film = test::render(divided_tunnel(thickness, 0.8f, 1), settings);
            const std::vector<float> beauty = film.resolve_beauty(), position = film.resolve(Layer::Position);
            for (size_t i = 0; i < beauty.size(); i += 3) {
                if (position[i] > 0.1f + thickness) {
                    for (size_t c = 0; c < 3; ++c) ASSERT_EQ(beauty[i + c], 0.0f) << "pixel " << i / 3;
                }
                leaked[static_cast<size_t>(boundary)] += beauty[i];
            }
        }
        EXPECT_LT(leaked[1], 0.1 * leaked[0]) << "thickness " << thickness;
        EXPECT_GT(leaked[0], 0.0);
    }
}

}  // namespace
}  // namespace photond::photon_mapping_walls_test
