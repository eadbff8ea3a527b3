// What photon tracing promises beside the right power: bits that do not depend on threads, counts, limits, flags,
// nothing where no light comes, and that its two ways of shading agree.

#include <gtest/gtest.h>

#include <cstring>

#include "renderer/scene/builtin_families.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/mesh_builder.h"
#include "renderer/transport/lambert_lanes.h"
#include "tests/support/photons.h"
#include "tests/support/threads.h"

namespace photond::photon_tracer_test {
namespace {

using test::photon_tracing;
using test::PhotonScene;

constexpr PhotonMapKind kKinds[] = {PhotonMapKind::Global, PhotonMapKind::Caustic};

bool same_photons(std::span<const Photon> a, std::span<const Photon> b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

/// A room of which every wall is seen from inside.
MeshBuilder& add_room(MeshBuilder& builder, const vec3& min, const vec3& max) {
    const vec3 a = min, b = max;
    return builder.quad({a.x, a.y, b.z}, {b.x, a.y, b.z}, {b.x, a.y, a.z}, {a.x, a.y, a.z})
        .quad({a.x, b.y, a.z}, {b.x, b.y, a.z}, {b.x, b.y, b.z}, {a.x, b.y, b.z})
        .quad({a.x, a.y, a.z}, {b.x, a.y, a.z}, {b.x, b.y, a.z}, {a.x, b.y, a.z})
        .quad({b.x, a.y, b.z}, {a.x, a.y, b.z}, {a.x, b.y, b.z}, {b.x, b.y, b.z})
        .quad({a.x, a.y, b.z}, {a.x, a.y, a.z}, {a.x, b.y, a.z}, {a.x, b.y, b.z})
        .quad({b.x, a.y, a.z}, {b.x, a.y, b.z}, {b.x, b.y, b.z}, {b.x, b.y, a.z});
}

Scene lit_room(float albedo, const vec3& light) {
    Scene scene;
    MeshBuilder room;
    add_mesh(scene, add_room(room, vec3(-1), vec3(1)).build(add_material(scene, lambert("wall", Rgb(albedo)))));
    PunctualLight point;
    point.position = light;
    scene.punctual_lights.push_back(point);
    finish_scene(scene);
    return scene;
}

TEST(PhotonTracer, PhotonsAreTheSameForAnyNumberOfThreads) {
    for (const char* name : {"cornell-box", "cornell-box-glass"}) {
        const PhotonScene lit(make_builtin_scene(name));
        for (const PhotonMapKind kind : kKinds) {
            std::vector<TracedPhotons> traced;
            for (const int threads : {1, 2, 8})
                traced.push_back(test::on_threads(threads, [&] { return lit.trace(photon_tracing(kind, 30'000)); }));
            for (const TracedPhotons& other : traced) {
                EXPECT_TRUE(same_photons(traced[0].photons, other.photons)) << name;
                EXPECT_EQ(traced[0].counts.photon_rays, other.counts.photon_rays);
                EXPECT_EQ(traced[0].first_hits_specular, other.first_hits_specular);
            }
        }
    }
}

TEST(PhotonTracer, APassIsAPureFunctionOfItsIndex) {
    const PhotonScene lit(make_builtin_scene("cornell-box-glass"));
    const PhotonTracing tracing = photon_tracing(PhotonMapKind::Global, 5'000);
    const TracedPhotons alone = lit.trace(tracing, 1, 7);
    EXPECT_TRUE(same_photons(alone.photons, lit.trace(tracing, 1, 7).photons));
    EXPECT_FALSE(same_photons(alone.photons, lit.trace(tracing, 1, 8).photons));
    EXPECT_FALSE(same_photons(alone.photons, lit.trace(tracing, 2, 7).photons));
    PhotonTracing random = tracing;
    random.sampler = SamplerKind::Random;
    EXPECT_FALSE(same_photons(alone.photons, lit.trace(random, 1, 7).photons));
    EXPECT_GT(lit.trace(tracing, 1, UINT32_MAX).photons.size(), 0u);  // elements beyond 2^32
}

TEST(PhotonTracer, CountsWhatItDid) {
    const PhotonScene lit(make_builtin_scene("cornell-box-glass"));
    for (const PhotonMapKind kind : kKinds)
        for (const uint32_t photons : {1u, 1023u, 1025u, 20'000u}) {
            const TracedPhotons traced = lit.trace(photon_tracing(kind, photons), 1, 3);
            EXPECT_EQ(traced.paths, photons);
            EXPECT_EQ(traced.counts.photons_emitted, photons);
            EXPECT_EQ(traced.counts.photons_stored, traced.photons.size());
            EXPECT_GE(traced.counts.photon_rays, photons);
            EXPECT_EQ(traced.counts.nan_samples + traced.counts.infinite_samples, 0u);
            EXPECT_LE(traced.first_hits_specular, photons);
            EXPECT_GE(traced.first_hits_specular, photons / 200);
        }
}

// A limited run is the unlimited one without what comes later, in the same order within a batch.
TEST(PhotonTracer, ScatteringsAreLimited) {
    const PhotonScene lit(make_builtin_scene("cornell-box-glass"));
    for (const PhotonMapKind kind : kKinds) {
        PhotonTracing tracing = photon_tracing(kind, SequenceSampler::kRun);
        const TracedPhotons all = lit.trace(tracing);
        for (const uint32_t most : {0u, 1u, 2u, 5u}) {
            tracing.most_scatterings = most;
            const TracedPhotons limited = lit.trace(tracing);
            std::vector<Photon> expected;
            for (const Photon& photon : all.photons)
                if (photon.payload.scatterings() <= most) expected.push_back(photon);
            EXPECT_TRUE(same_photons(limited.photons, expected)) << most;
            EXPECT_LE(limited.counts.photon_rays, uint64_t{most + 1} * tracing.photons);
            EXPECT_EQ(limited.photons.empty(), most == 0);
        }
    }
}

TEST(PhotonTracer, FlagsTellThePath) {
    Scene glossy = make_builtin_scene("cornell-box-glass");
    for (Material& material : glossy.materials)
        if (!is_plain_lambert(material)) material = metal("brushed", Rgb(0.9f), 0.15f);  // alpha 0.0225, below 0.05
    finish_scene(glossy);
    const PhotonScene smooth_scene(make_builtin_scene("cornell-box-glass")), glossy_scene(std::move(glossy));
    for (const PhotonScene* lit : {&smooth_scene, &glossy_scene})
        for (const PhotonMapKind kind : kKinds) {
            const TracedPhotons traced = lit->trace(photon_tracing(kind, 20'000));
            size_t delta = 0;
            for (const Photon& photon : traced.photons) {
                EXPECT_GE(photon.payload.scatterings(), 1u);
                EXPECT_GT(glm::dot(photon.payload.normal(), photon.payload.wi_world()), -1e-2f);
                delta += photon.payload.all_delta();
            }
            ASSERT_GT(traced.photons.size(), 100u);
            EXPECT_EQ(delta, kind == PhotonMapKind::Caustic && lit == &smooth_scene ? traced.photons.size() : 0);
        }
    PhotonTracing strict = photon_tracing(PhotonMapKind::Caustic, 20'000);
    strict.glossy_threshold = 0.02f;  // the metal is rough now, and a cornell box without specular surfaces
    const TracedPhotons none = glossy_scene.trace(strict);
    EXPECT_EQ(none.photons.size(), 0u);
    EXPECT_EQ(none.first_hits_specular, 0u);
}

TEST(PhotonTracer, NothingComesFromADarkScene) {
    Scene dark = make_builtin_scene("cornell-box");
    for (Material& material : dark.materials) material.emission = Rgb(0);
    finish_scene(dark);
    const PhotonScene unlit(std::move(dark));
    for (const PhotonMapKind kind : kKinds) {
        const TracedPhotons traced = unlit.trace(photon_tracing(kind, 3'000));
        EXPECT_EQ(traced.paths, 3'000u);
        EXPECT_EQ(traced.counts.photons_emitted, 3'000u);
        EXPECT_EQ(traced.counts.photon_rays, 0u);
        EXPECT_TRUE(traced.photons.empty());
    }
}

TEST(PhotonTracer, BlackAndUnlitSurfacesAbsorb) {
    Scene black = lit_room(0, vec3(0));
    EXPECT_TRUE(PhotonScene(black).trace(photon_tracing(PhotonMapKind::Global, 3'000)).photons.empty());
    Scene unlit = lit_room(0.5f, vec3(0));
    EXPECT_FALSE(PhotonScene(unlit).trace(photon_tracing(PhotonMapKind::Global, 3'000)).photons.empty());
    unlit.materials[0].unlit = true;
    finish_scene(unlit);
    EXPECT_TRUE(PhotonScene(unlit).trace(photon_tracing(PhotonMapKind::Global, 3'000)).photons.empty());
}

TEST(PhotonTracer, NothingArrivesBeyondALightsRange) {
    Scene scene = lit_room(0.8f, vec3(0));
    scene.punctual_lights[0].range_m = 0.99f;  // the walls are 1 m away
    const TracedPhotons traced = PhotonScene(scene).trace(photon_tracing(PhotonMapKind::Global, 3'000));
    EXPECT_TRUE(traced.photons.empty());
    EXPECT_EQ(traced.counts.photon_rays, 3'000u);
}

// A closed box with a partition, which reaches into the walls, as thin as it gets: nothing comes through, nor around.
TEST(PhotonTracer, NoPhotonPassesAThinWall) {
    for (const float thickness : {1e-3f, 1e-4f}) {
        Scene scene = lit_room(0.9f, {-0.5f, 0.2f, 0.1f});
        const float half = 0.5f * thickness * glm::length(vec3(2));
        add_mesh(scene, MeshBuilder().box({-half, -1.1f, -1.1f}, {half, 1.1f, 1.1f}).build(0));
        finish_scene(scene);
        const TracedPhotons traced = PhotonScene(scene).trace(photon_tracing(PhotonMapKind::Global, 200'000));
        ASSERT_GT(traced.photons.size(), 400'000u);
        size_t behind = 0;
        for (const Photon& photon : traced.photons) behind += photon.position.x > -0.5f * half;
        EXPECT_EQ(behind, 0u) << thickness;
    }
}

TEST(PhotonTracer, DropsAndCountsPowerThatIsNotFinite) {
    Scene scene = lit_room(0.5f, vec3(0));
    scene.punctual_lights[0].intensity = Rgb(1e38f);  // x 4 pi: beyond float
    finish_scene(scene);
    const TracedPhotons traced = PhotonScene(scene).trace(photon_tracing(PhotonMapKind::Global, 2'000));
    EXPECT_TRUE(traced.photons.empty());
    EXPECT_EQ(traced.counts.infinite_samples + traced.counts.nan_samples, 2'000u);
}

TEST(PhotonTracer, StopsWhenCancelled) {
    const PhotonScene lit(make_builtin_scene("cornell-box"));
    CancelToken cancel;
    cancel.cancel();
    const PhotonTracer tracer(lit.scene, *lit.intersector, lit.emission, photon_tracing(kKinds[0], 100'000));
    EXPECT_EQ(tracer.trace(1, 0, cancel).counts.photon_rays, 0u);
}

// The same numbers drive both; only rounding differs, which now and then sends a path elsewhere. The coarse sphere's
// shading normals lean far.
TEST(PhotonTracer, LanesAndSinglePathsScatterAlike) {
    Scene lanes = lit_room(0.8f, {0.1f, 0.6f, 0.2f});
    add_mesh(lanes, MeshBuilder().sphere({0, -0.3f, 0}, 0.5f, 8).build(0));
    const mat3 turn(glm::rotate(mat4(1.0f), 0.7f, glm::normalize(vec3(1, 2, 3))));  // off the axes: no zeros of a sign
    for (Mesh& mesh : lanes.meshes) {
        for (vec3& p : mesh.positions) p = turn * p;
        for (vec3& n : mesh.normals) n = turn * n;
    }
    lanes.punctual_lights[0].position = turn * lanes.punctual_lights[0].position;
    finish_scene(lanes);
    Scene single = lanes;
    Texture flat;  // a normal map that changes nothing asks for the general shading
    flat.size = {1, 1};
    flat.texels = {{128, 128, 255, 255}};
    single.textures.push_back(flat);
    single.materials[0].normal_texture.texture = 0;
    single.materials[0].normal_scale = 0;
    finish_scene(single);

    PhotonTracing tracing = photon_tracing(PhotonMapKind::Global, 20'000);
    tracing.most_scatterings = 4;
    const TracedPhotons a = PhotonScene(lanes).trace(tracing), b = PhotonScene(single).trace(tracing);
    for (uint32_t scatterings = 1; scatterings <= 4; ++scatterings) {
        const auto of_order = [=](const Photon& p) { return p.payload.scatterings() == scatterings; };
        const auto x = double(std::count_if(a.photons.begin(), a.photons.end(), of_order));
        const auto y = double(std::count_if(b.photons.begin(), b.photons.end(), of_order));
        EXPECT_NEAR(x, y, 2e-3 * x) << scatterings;
        const dvec3 power = test::power_after(a, scatterings), other = test::power_after(b, scatterings);
        EXPECT_NEAR(power.x, other.x, 2e-3 * power.x) << scatterings;
    }
    // Of the first scattering, photon by photon: their places and powers, wherever both have the same number of them.
    std::vector<Photon> first_a, first_b;
    for (const auto& [from, to] : {std::pair{&a, &first_a}, {&b, &first_b}})
        for (const Photon& photon : from->photons)
            if (photon.payload.scatterings() == 1) to->push_back(photon);
    ASSERT_EQ(first_a.size(), first_b.size());
    size_t different = 0;
    for (size_t i = 0; i < first_a.size(); ++i)
        different += glm::length(first_a[i].position - first_b[i].position) > 1e-3f ||
                     std::abs(first_a[i].payload.power_w.x / first_b[i].payload.power_w.x - 1) > 1e-3f;
    EXPECT_LT(different, first_a.size() / 200);
}

}  // namespace
}  // namespace photond::photon_tracer_test
