// What the photons that leave surfaces promise beside the right power: bits that do not depend on threads, the paths of
// the photons that arrive, counts, limits, references that hold, and maps whose texels see their own directions.

#include <gtest/gtest.h>

#include <cstring>

#include "renderer/photons/reflective_shadow_map.h"
#include "renderer/scene/builtin_families.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/mesh_builder.h"
#include "renderer/transport/bsdf.h"
#include "tests/support/photons.h"
#include "tests/support/threads.h"

namespace photond::reflected_photons_test {
namespace {

using test::photon_tracing;
using test::PhotonScene;
using Spread = ReflectedPhoton::Spread;

constexpr PhotonInjection kInjections[] = {PhotonInjection::Paths, PhotonInjection::ReflectiveShadowMap};

PhotonTracing settings(uint32_t photons, PhotonInjection injection = PhotonInjection::Paths) {
    PhotonTracing tracing = photon_tracing(PhotonMapKind::Global, photons);
    tracing.injection = injection;
    return tracing;
}

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}
bool same(const TracedReflections& a, const TracedReflections& b) {
    return same_bits(a.photons, b.photons) && same_bits(a.surfaces, b.surfaces);
}

size_t count(const TracedReflections& traced, Spread spread) {
    return static_cast<size_t>(std::count_if(traced.photons.begin(), traced.photons.end(),
                                             [=](const ReflectedPhoton& p) { return p.spread() == spread; }));
}

/// The Cornell box with a mirror, a glass ball and, for its walls, all ways to leave: Lambert, Rough, Beam.
Scene mixed_scene() {
    Scene scene = make_builtin_scene("cornell-box-glass");
    for (Material& material : scene.materials)
        if (is_black(material.emission) && material.specular == 0) {
            material = plastic("coated", material.base_color, 0.5f);
            break;
        }
    finish_scene(scene);
    return scene;
}

TEST(ReflectedPhotons, AreTheSameForAnyNumberOfThreads) {
    const PhotonScene lit(mixed_scene());
    for (const PhotonInjection injection : kInjections) {
        std::vector<TracedReflections> traced;
        for (const int threads : {1, 2, 8})
            traced.push_back(
                test::on_threads(threads, [&] { return lit.trace_reflected(settings(30'000, injection)); }));
        for (const Spread spread : {Spread::Lambert, Spread::Rough, Spread::Beam})
            EXPECT_GT(count(traced[0], spread), 100u);
        for (const TracedReflections& other : traced) {
            EXPECT_TRUE(same(traced[0], other));
            EXPECT_EQ(traced[0].counts.photon_rays, other.counts.photon_rays);
        }
    }
}

TEST(ReflectedPhotons, APassIsAPureFunctionOfItsIndex) {
    const PhotonScene lit(mixed_scene());
    for (const PhotonInjection injection : kInjections) {
        const PhotonTracing tracing = settings(5'000, injection);
        const TracedReflections alone = lit.trace_reflected(tracing, 1, 7);
        EXPECT_TRUE(same(alone, lit.trace_reflected(tracing, 1, 7)));
        EXPECT_FALSE(same(alone, lit.trace_reflected(tracing, 1, 8)));
        EXPECT_FALSE(same(alone, lit.trace_reflected(tracing, 2, 7)));
    }
}

// In a scene of flat Lambert reflectors what goes on is what is kept: each photon that leaves is one that arrived, with
// the share of its power that roulette left it.
TEST(ReflectedPhotons, LeaveWhereTheSamePathsArrive) {
    const PhotonScene lit(make_builtin_scene("cornell-box-spot"));
    PhotonTracing tracing = settings(SequenceSampler::kRun);  // one batch, ordered by scatterings
    tracing.most_scatterings = 4;
    const TracedReflections left = lit.trace_reflected(tracing);
    tracing.most_scatterings = 3;
    const TracedPhotons arrived = lit.trace(tracing);
    EXPECT_EQ(left.counts.photon_rays, arrived.counts.photon_rays);
    ASSERT_TRUE(left.surfaces.empty());
    size_t next = 0, matched = 0;
    for (const ReflectedPhoton& photon : left.photons) {
        EXPECT_EQ(photon.spread(), Spread::Lambert);
        EXPECT_EQ(photon.surface, ReflectedPhoton::kNoSurface);
        EXPECT_EQ(photon.correction, 1.0f);
        EXPECT_GT(glm::dot(photon.normal, photon.direction), 0.0f);
        if (photon.scatterings() == 1) continue;
        while (next < arrived.photons.size() &&
               (arrived.photons[next].position != photon.position ||
                arrived.photons[next].payload.scatterings() + 1 != photon.scatterings()))
            ++next;
        ASSERT_LT(next, arrived.photons.size());
        const Rgb share = photon.power_w / arrived.photons[next].payload.power_w;
        EXPECT_LE(max_component(photon.power_w), 1.03f * max_component(arrived.photons[0].payload.power_w));
        EXPECT_GT(max_component(share), 0.9f);  // 1 but for the reflectance's colour
        ++matched;
    }
    EXPECT_GT(matched, 500u);
}

TEST(ReflectedPhotons, ScatteringsAreLimitedAndCounted) {
    const PhotonScene lit(mixed_scene());
    for (const bool apart : {true, false}) {
        PhotonTracing tracing = settings(SequenceSampler::kRun);
        tracing.rough_apart = apart;
        const TracedReflections all = lit.trace_reflected(tracing);
        EXPECT_EQ(all.surfaces.empty(), !apart);
        EXPECT_EQ(count(all, Spread::Rough), all.surfaces.size());
        for (const uint32_t most : {0u, 1u, 2u, 5u}) {
            tracing.most_scatterings = most;
            const TracedReflections limited = lit.trace_reflected(tracing);
            std::vector<ReflectedPhoton> expected;
            for (const ReflectedPhoton& photon : all.photons)
                if (photon.scatterings() <= most) expected.push_back(photon);
            EXPECT_TRUE(same_bits(limited.photons, expected)) << most;
            EXPECT_EQ(limited.photons.empty(), most == 0);
            EXPECT_LE(limited.counts.photon_rays, uint64_t{most} * tracing.photons);
            EXPECT_EQ(limited.counts.photons_stored, limited.photons.size());
            EXPECT_EQ(limited.counts.photons_emitted, tracing.photons);
            EXPECT_EQ(limited.paths, tracing.photons);
            EXPECT_EQ(limited.counts.nan_samples + limited.counts.infinite_samples, 0u);
        }
    }
}

// Over many batches: what the index refers to is the photon's own place, and each is referred to once.
TEST(ReflectedPhotons, RoughOnesReferToTheirSurface) {
    const PhotonScene lit(mixed_scene());
    const TracedReflections traced = lit.trace_reflected(settings(20'000));
    uint32_t next = 0;
    for (const ReflectedPhoton& photon : traced.photons) {
        if (photon.spread() != Spread::Rough) {
            EXPECT_EQ(photon.surface, ReflectedPhoton::kNoSurface);
            continue;
        }
        ASSERT_EQ(photon.surface, next++);
        const ReflectingSurface& surface = traced.surfaces[photon.surface];
        const ShadingPoint point = make_shading_point(lit.scene, surface.hit, -surface.wi_world);
        EXPECT_EQ(point.position, photon.position);
        EXPECT_EQ(point.geometric_normal, photon.normal);
        EXPECT_GT(glm::dot(photon.normal, surface.wi_world), 0.0f);
        EXPECT_GT(glm::dot(photon.normal, photon.direction), 0.0f);
        const Rgb albedo = make_bsdf(lit.scene, point, surface.outside_ior).rough_part(0.05f).albedo();
        EXPECT_EQ(photon.power_w, surface.arriving_power_w * albedo);
    }
    EXPECT_EQ(next, traced.surfaces.size());
    EXPECT_GT(next, 1'000u);
}

/// A floor that a spot light looks at straight from above.
Scene lit_floor(const Material& material) {
    Scene scene;
    add_mesh(scene,
             MeshBuilder().quad({-9, 0, 9}, {9, 0, 9}, {9, 0, -9}, {-9, 0, -9}).build(add_material(scene, material)));
    PunctualLight spot;
    spot.kind = PunctualLight::Kind::Spot;
    spot.position = {0, 2, 0};
    spot.direction = {0, -1, 0};
    spot.cos_inner = 0.95f;
    spot.cos_outer = 0.9f;
    scene.punctual_lights.push_back(spot);
    finish_scene(scene);
    return scene;
}

TEST(ReflectedPhotons, AMirrorsAreBeams) {
    const PhotonScene lit(lit_floor(metal("mirror", Rgb(0.5f), 0)));
    for (const PhotonInjection injection : kInjections) {
        const TracedReflections traced = lit.trace_reflected(settings(4'000, injection));
        EXPECT_NEAR(double(traced.photons.size()), 0.5 * double(traced.paths), 0.1 * double(traced.paths));
        for (const ReflectedPhoton& photon : traced.photons) {
            ASSERT_EQ(photon.spread(), Spread::Beam);
            const vec3 from = glm::normalize(photon.position - vec3(0, 2, 0));
            EXPECT_LT(glm::length(photon.direction - vec3(from.x, -from.y, from.z)), 1e-5f);
        }
    }
}

// A thin sheet that scatters through itself has no one-sided part to be evaluated: beams, to both sides.
TEST(ReflectedPhotons, WhatARoughSheetScattersIsBeams) {
    Material sheet = plastic("sheet", Rgb(0.9f), 0.5f);
    sheet.transmission = 1;
    const PhotonScene lit(lit_floor(sheet));
    const TracedReflections traced = lit.trace_reflected(settings(4'000));
    size_t through = 0;
    for (const ReflectedPhoton& photon : traced.photons) {
        ASSERT_EQ(photon.spread(), Spread::Beam);
        EXPECT_GT(photon.normal.y, 0.99f);
        through += photon.direction.y < 0;
    }
    EXPECT_GT(through, 1'000u);
    EXPECT_GT(traced.photons.size() - through, 50u);
}

// A normal map asks for the general shading, but a Lambert reflector stays one; only rounding differs.
TEST(ReflectedPhotons, LanesAndSinglePathsReflectAlike) {
    Scene lanes = lit_floor(lambert("floor", Rgb(0.7f)));
    add_mesh(lanes, MeshBuilder().sphere({0, 0.6f, 0}, 0.5f, 8).build(0));  // its coarse shading normals lean far
    finish_scene(lanes);
    Scene single = lanes;
    Texture flat;
    flat.size = {1, 1};
    flat.texels = {{128, 128, 255, 255}};
    single.textures.push_back(flat);
    single.materials[0].normal_texture.texture = 0;
    single.materials[0].normal_scale = 0;
    finish_scene(single);
    PhotonTracing tracing = settings(20'000, PhotonInjection::ReflectiveShadowMap);
    const TracedReflections a = PhotonScene(lanes).trace_reflected(tracing);
    const TracedReflections b = PhotonScene(single).trace_reflected(tracing);
    EXPECT_TRUE(b.surfaces.empty());
    double corrected[2] = {}, power[2] = {};
    const TracedReflections* traced[] = {&a, &b};
    for (int i = 0; i < 2; ++i)
        for (const ReflectedPhoton& photon : traced[i]->photons) {
            EXPECT_EQ(photon.spread(), Spread::Lambert);
            EXPECT_GE(photon.correction, 0.0f);
            const vec3 smooth = Octahedral<16>::decode(photon.smooth_normal);
            EXPECT_GT(glm::dot(smooth, photon.normal), -1e-4f);
            EXPECT_EQ(photon.correction_towards(smooth), photon.correction);
            EXPECT_EQ(photon.correction_towards(-smooth), 1.0f);
            corrected[i] += double{photon.power_w.x * photon.correction_towards(photon.direction)};
            power[i] += double{photon.power_w.x};
        }
    EXPECT_NEAR(power[0], power[1], 0.02 * power[0]);  // roulette by the numbers' other end
    EXPECT_NEAR(corrected[0], corrected[1], 0.02 * corrected[0]);
    EXPECT_GT(std::abs(corrected[0] / power[0] - 1), 1e-3);  // the correction was put to the test
}

TEST(ReflectedPhotons, NoneLeaveWithoutLightOrReflectors) {
    const Scene lit = lit_floor(lambert("floor", Rgb(0.5f)));
    for (const PhotonInjection injection : kInjections) {
        EXPECT_FALSE(PhotonScene(lit).trace_reflected(settings(3'000, injection)).photons.empty());
        Scene dark = lit, black = lit, unlit = lit, empty;
        dark.punctual_lights.clear();
        black.materials[0].base_color = Rgb(0);
        unlit.materials[0].unlit = true;
        for (Scene* scene : {&dark, &black, &unlit, &empty}) {
            finish_scene(*scene);
            const TracedReflections none = PhotonScene(*scene).trace_reflected(settings(3'000, injection));
            EXPECT_TRUE(none.photons.empty());
            EXPECT_GT(none.paths, 2'900u);
            EXPECT_EQ(none.counts.photons_emitted, none.paths);
            EXPECT_EQ(none.counts.photons_stored, 0u);
        }
    }
}

TEST(ReflectedPhotons, DropsAndCountsPowerThatIsNotFinite) {
    Scene scene = lit_floor(lambert("floor", Rgb(0.5f)));
    scene.punctual_lights[0].intensity = Rgb(3e38f);
    scene.punctual_lights[0].kind = PunctualLight::Kind::Point;  // x 4 pi: beyond float
    finish_scene(scene);
    const PhotonScene lit(std::move(scene));
    for (const PhotonInjection injection : kInjections) {
        const TracedReflections traced = lit.trace_reflected(settings(2'000, injection));
        EXPECT_TRUE(traced.photons.empty());
        EXPECT_EQ(traced.counts.infinite_samples + traced.counts.nan_samples, traced.paths);
    }
}

TEST(ReflectedPhotons, StopWhenCancelled) {
    const PhotonScene lit(make_builtin_scene("cornell-box"));
    CancelToken cancel;
    cancel.cancel();
    for (const PhotonInjection injection : kInjections) {
        const PhotonTracer tracer(lit.scene, *lit.intersector, lit.emission, settings(100'000, injection));
        EXPECT_EQ(tracer.trace_reflected(1, 0, cancel).counts.photon_rays, 0u);
    }
}

// A point light's directions, back to the square they were drawn from: one path in each cell, elsewhere in it each
// pass.
TEST(ReflectiveShadowMaps, EachTexelSeesItsOwnDirections) {
    Scene scene = lit_floor(lambert("floor", Rgb(0.5f)));
    scene.punctual_lights[0].kind = PunctualLight::Kind::Point;
    finish_scene(scene);
    const EmissionSampler emission(scene);
    const ReflectiveShadowMaps maps(emission, 21 * 20);
    const ReflectiveShadowMapPass pass(maps, 1, 0);
    ASSERT_EQ(pass.texels(), 21u * 20u);
    for (const vec2& u : {vec2(0.01f), vec2(0.5f), vec2(0.99f, 0.02f)})
        for (uint32_t texel = 0; texel < pass.texels(); ++texel) {
            EmissionSample sample;
            ASSERT_TRUE(pass.sample(texel, u, vec2(0.3f), vec2(0.7f), sample));
            const vec3 d = sample.ray.direction;
            const float turn = std::atan2(d.y, d.x) / (2 * kPi);
            const vec2 drawn((1 - d.z) / 2, turn < 0 ? turn + 1 : turn);
            EXPECT_NEAR(drawn.x * 21, float(texel % 21) + u.x, 2e-3f);
            EXPECT_NEAR(drawn.y * 20, float(texel / 21) + u.y, 2e-3f);
            EXPECT_NEAR(sample.power_w.x * 420, 4 * kPi, 1e-4f);
        }
}

// A directional light is seen through a grid of places.
TEST(ReflectiveShadowMaps, ADirectionalLightsTexelsAreApart) {
    Scene scene = lit_floor(lambert("floor", Rgb(0.5f)));
    scene.punctual_lights[0].kind = PunctualLight::Kind::Directional;
    finish_scene(scene);
    const EmissionSampler emission(scene);
    const ReflectiveShadowMaps maps(emission, 100);
    const ReflectiveShadowMapPass pass(maps, 1, 0);
    std::vector<vec3> origins;
    for (uint64_t texel = 0; texel < pass.texels(); ++texel) {
        EmissionSample sample;
        ASSERT_TRUE(pass.sample(texel, vec2(0.5f), vec2(0.1f), vec2(0.9f), sample));
        for (const vec3& other : origins)
            EXPECT_GT(glm::length(other - sample.ray.origin), 0.02f * scene.bounds.radius());
        origins.push_back(sample.ray.origin);
    }
    EXPECT_EQ(origins.size(), 99u);  // 11 x 9
}

// Lights of very different power: texels in proportion, the weak ones now and then, and all of the flux on the average.
TEST(ReflectiveShadowMaps, WeakLightsTakeTurns) {
    Scene scene = lit_floor(lambert("floor", Rgb(0.5f)));
    const PunctualLight spot = scene.punctual_lights[0];
    for (uint32_t i = 0; i < 40; ++i) {
        PunctualLight weak = spot;
        weak.intensity = Rgb(1e-3f * static_cast<float>(i + 1));
        scene.punctual_lights.push_back(weak);
    }
    finish_scene(scene);
    const EmissionSampler emission(scene);
    constexpr uint32_t kTexels = 200, kPasses = 4'000;
    const ReflectiveShadowMaps maps(emission, kTexels);
    std::vector<double> seen(emission.lights()), power(emission.lights());
    for (uint32_t p = 0; p < kPasses; ++p) {
        const ReflectiveShadowMapPass pass(maps, 1, p);
        EXPECT_LE(pass.texels(), kTexels + 1);
        EXPECT_GE(pass.texels(), kTexels * 9 / 10);
        for (uint64_t texel = 0; texel < pass.texels(); ++texel) {
            EmissionSample sample;
            ASSERT_TRUE(pass.sample(texel, vec2(0.5f), vec2(0.5f), vec2(0.5f), sample));
            seen[sample.light] += 1.0 / kPasses;
            power[sample.light] += double{sample.power_w.x} / kPasses;
        }
    }
    const double flux = power[0];
    size_t weak = 0;
    for (uint32_t light = 0; light < emission.lights(); ++light) {
        const double expected = double{emission.probability(light)} * kTexels;
        EXPECT_GT(expected, 0);
        if (expected >= 1) {
            EXPECT_NEAR(seen[light], std::round(seen[light]), 1e-9);
            EXPECT_LE(seen[light], expected + 1);
            EXPECT_NEAR(power[light], flux * double{scene.punctual_lights[light].intensity.x}, 1e-5 * flux);
            continue;
        }
        ++weak;
        // Six standard deviations of a light's turns, which come independently in each pass.
        EXPECT_NEAR(seen[light], expected, 6 * std::sqrt(expected * (1 - expected) / kPasses)) << light;
        EXPECT_NEAR(power[light] / seen[light] * expected, flux * double{scene.punctual_lights[light].intensity.x},
                    1e-5 * flux);
    }
    EXPECT_GT(weak, 3u);
    EXPECT_LT(weak, 40u);
}

}  // namespace
}  // namespace photond::reflected_photons_test
