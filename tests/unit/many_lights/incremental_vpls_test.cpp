// Lights that frames hand on: which stay and where, how many are new, what they stand for, and that a frame is the same
// whoever renders it.

#include "renderer/many_lights/incremental_vpls.h"

#include <gtest/gtest.h>

#include <cmath>

#include "protocol/error.h"
#include "renderer/methods/svo_many_lights/svo_many_lights.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/mesh_builder.h"
#include "tests/support/aged_frames.h"
#include "tests/support/lit_rooms.h"
#include "tests/support/photons.h"
#include "tests/support/threads.h"

namespace photond::incremental_vpls_test {
namespace {

using test::FrameOf;
using test::PhotonScene;

constexpr uint32_t kPaths = 200;

/// A frame's paths, by what the one before has left.
struct Frame {
    Frame(const PhotonScene& lit, const std::string& before, uint64_t seed = 1, uint32_t new_vpls = 20,
          uint32_t bounces = 1)
        : frames({.on = true, .new_vpls = new_vpls}, kPaths) {
        if (!before.empty()) frames.follow({before, nullptr});
        const VplTracing tracing{.vpls = kPaths, .map_side = 64, .bounces = bounces};
        const VplTracer tracer(lit.scene, *lit.intersector, *lit.intersector, lit.emission, tracing);
        MemoryBudget budget;
        frames.renew(tracer, lit.emission, {lit.scene, lit.intersector.get(), {}, seed, budget}, stats);
        lights = tracer.trace(frames.seed(), frames.paths(), stats, CancelToken{});
        Counts unused;
        const TexelMapPass map(tracer.map(), frames.seed(), 0);
        flux_w = tracer.see_flux(map, unused).total();
        left = frames.left_to_next();
    }
    double reflected_w() const {
        double sum = 0;
        for (const ChosenStart& start : frames.paths().starts) sum += double{start.reflected_w};
        return sum;
    }

    VplsBetweenFrames frames;
    Stats stats;
    TracedReflections lights;
    float flux_w;
    std::string left;
};

/// A grey floor with a step on it, and a spot above that may be moved.
Scene lit_step(float lamp_x, float step_x = 0) {
    Scene scene;
    const uint32_t grey = add_material(scene, lambert("grey", Rgb(0.5f)));
    add_mesh(scene, MeshBuilder().quad({-4, 0, 4}, {4, 0, 4}, {4, 0, -4}, {-4, 0, -4}).build(grey));
    add_mesh(scene, MeshBuilder()
                        .quad({step_x - 0.5f, 0.3f, 0.5f}, {step_x + 0.5f, 0.3f, 0.5f}, {step_x + 0.5f, 0.3f, -0.5f},
                              {step_x - 0.5f, 0.3f, -0.5f})
                        .build(grey));
    PunctualLight spot;
    spot.kind = PunctualLight::Kind::Spot;
    spot.position = {lamp_x, 3, 0};
    spot.direction = {0, -1, 0};
    spot.intensity = Rgb(10);
    spot.cos_inner = 0.9f;
    spot.cos_outer = 0.8f;
    scene.punctual_lights.push_back(spot);
    finish_scene(scene);
    return scene;
}

// All kinds of lights, at points that their own paths reach.
TEST(IncrementalVpls, PathsAreAimedAtTheirPoints) {
    const Scene scene = test::room_of_all_lights();
    const EmissionSampler emission(scene);
    RandomStream random(3, RandomDomain::Test, 0, 0);
    std::vector<uint32_t> aimed(emission.lights());
    for (uint32_t i = 0; i < 2000; ++i) {
        const uint32_t light = i % emission.lights();
        const vec2 u_position = random.next_2d(), u_direction = random.next_2d();
        EmissionSample first, again;
        if (!emission.sample_light(light, 1, u_position, u_direction, first)) continue;
        const vec3 point = first.ray.origin + (0.2f + random.next()) * scene.bounds.radius() * first.ray.direction;
        vec2 position = emission.guided_by_position(light) ? vec2(0.5f) : u_position, direction = u_direction;
        ASSERT_TRUE(emission.aim(light, point, position, direction)) << light;
        ASSERT_TRUE(emission.sample_light(light, 1, position, direction, again));
        const vec3 way = point - again.ray.origin;
        const vec3 beside = way - glm::dot(way, again.ray.direction) * again.ray.direction;
        // Near the rim of a lamp's hemisphere the numbers are coarser than the directions.
        EXPECT_LT(glm::length(beside), 2e-3f * glm::length(way)) << light;
        EXPECT_LT(glm::length(again.power_w - first.power_w), 1e-3f * glm::length(first.power_w)) << light;
        ++aimed[light];
    }
    for (uint32_t light = 0; light < emission.lights(); ++light)
        EXPECT_EQ(aimed[light] > 0, emission.probability(light) > 0) << light;
}

TEST(IncrementalVpls, WhereNoPathLeadsThereIsNoAim) {
    const Scene scene = lit_step(0);
    const EmissionSampler emission(scene);
    vec2 position(0.5f), direction(0.5f);
    EXPECT_TRUE(emission.aim(0, {0.1f, 0, 0}, position, direction));
    EXPECT_FALSE(emission.aim(0, {0, 4, 0}, position, direction)) << "behind the spot";
    EXPECT_FALSE(emission.aim(0, {3, 0, 0}, position, direction)) << "outside of its cone";
}

TEST(IncrementalVpls, AFirstFrameHasAllPathsAndAllOfTheFlux) {
    for (const Scene& scene : {lit_step(0), make_builtin_scene("cornell-box-glass"), test::room_of_all_lights()}) {
        const PhotonScene lit(scene);
        const Frame frame(lit, "", 1, 20, 3);
        EXPECT_EQ(frame.stats.counts.vpls_kept, 0u);
        EXPECT_GT(frame.stats.counts.vpls_new, kPaths * 9 / 10);
        EXPECT_LE(frame.stats.counts.vpls_new, kPaths);
        EXPECT_NEAR(frame.reflected_w(), double{frame.flux_w}, 1e-4 * double{frame.flux_w});
    }
}

TEST(IncrementalVpls, AStillSceneKeepsItsLights) {
    const PhotonScene lit(make_builtin_scene("cornell-box-glass"));
    const Frame first(lit, "", 7);
    std::string left = first.left;
    for (uint64_t seed = 8; seed < 13; ++seed) left = Frame(lit, left, seed).left;
    const Frame last(lit, left, 13);
    EXPECT_GE(last.stats.counts.vpls_kept + 5, first.stats.counts.vpls_new);
    EXPECT_LE(last.stats.counts.vpls_new, 5u);
    uint32_t same = 0, all = 0;
    for (uint32_t i = 0; i < kPaths; ++i) {
        const EmissionSample& a = first.frames.paths().starts[i].first;
        const EmissionSample& b = last.frames.paths().starts[i].first;
        if (is_black(a.power_w) || is_black(b.power_w)) continue;
        ++all;
        same += glm::length(a.ray.direction - b.ray.direction) < 1e-4f &&
                glm::length(a.power_w - b.power_w) < 0.02f * glm::length(a.power_w);
    }
    EXPECT_GE(same, all * 9 / 10);
    EXPECT_GT(all, kPaths * 9 / 10);
}

/// Shares of the lights of `now` that lie where one of `before` does.
double share_in_place(const TracedReflections& before, const TracedReflections& now) {
    uint32_t in_place = 0;
    for (const ReflectedPhoton& light : now.photons)
        in_place += std::ranges::any_of(before.photons, [&](const ReflectedPhoton& other) {
            return glm::length(light.position - other.position) < 1e-3f;
        });
    return double(in_place) / double(now.photons.size());
}

// A lamp that moves finds its lights where they were, as far as it sees them; the new ones keep within their number,
// and whatever there is stands for all of the flux.
TEST(IncrementalVpls, LightsStayWhereTheyAreWhenTheLampMoves) {
    constexpr uint32_t kNew = 30;
    auto before = std::make_unique<Frame>(PhotonScene(lit_step(0)), "");
    for (int frame = 1; frame <= 12; ++frame) {
        SCOPED_TRACE(frame);
        const Scene scene = lit_step(0.15f * static_cast<float>(frame));
        const PhotonScene lit(scene);
        auto now_frame = std::make_unique<Frame>(lit, before->left, 1, kNew);
        const Frame& now = *now_frame;
        EXPECT_LE(now.stats.counts.vpls_new, kNew);
        EXPECT_GT(now.stats.counts.vpls_kept, kPaths / 2);
        EXPECT_LE(now.stats.counts.vpls_kept + now.stats.counts.vpls_new, kPaths);
        EXPECT_GT(share_in_place(before->lights, now.lights), 0.75);
        EXPECT_NEAR(now.reflected_w(), double{now.flux_w}, 1e-4 * double{now.flux_w});
        for (const ReflectedPhoton& light : now.lights.photons) {
            const vec3 way = glm::normalize(light.position - scene.punctual_lights[0].position);
            EXPECT_GT(-way.y, scene.punctual_lights[0].cos_outer - 1e-3f) << "what the lamp does not see is gone";
        }
        before = std::move(now_frame);
    }
}

// A surface that moves takes its lights with it, and those that it hides are gone.
TEST(IncrementalVpls, LightsGoWithTheirSurfaces) {
    const PhotonScene lit(lit_step(0)), moved(lit_step(0, 0.4f));
    const Frame before(lit, ""), now(moved, before.left);
    uint32_t carried = 0, on_step = 0, hidden = 0;
    for (const ReflectedPhoton& light : now.lights.photons) {
        const bool raised = light.position.y > 0.2f;
        on_step += raised;
        carried += raised && std::ranges::any_of(before.lights.photons, [&](const ReflectedPhoton& other) {
                       return glm::length(light.position - vec3(0.4f, 0, 0) - other.position) < 1e-3f;
                   });
        // On the floor, within the shadow of the step.
        hidden += !raised && std::fabs(light.position.z) < 0.5f && std::fabs(light.position.x - 0.44f) < 0.5f;
    }
    EXPECT_GT(on_step, 10u);
    EXPECT_GT(carried, on_step / 2);
    EXPECT_EQ(hidden, 0u);
}

TEST(IncrementalVpls, WhatIsLeftIsReadAsItWasOrRefused) {
    LeftVplPaths left{.slots = 8, .lights = 2, .seed = 5, .paths = {}};
    left.paths.push_back({3, 1, {0.1f, 0.2f}, {0.3f, 0.4f}, 7, 9, {0.5f, 0.25f}});
    const LeftVplPaths back = LeftVplPaths::decode(left.encode(), 8);
    EXPECT_EQ(back.encode(), left.encode());
    EXPECT_EQ(back.paths[0].triangle, 9u);
    for (const std::string& wrong : {std::string("no lights"), left.encode() + "x"})
        EXPECT_THROW(LeftVplPaths::decode(wrong, 8), Error);
    EXPECT_THROW(LeftVplPaths::decode(left.encode(), 16), Error);
    left.paths.push_back(left.paths[0]);
    EXPECT_THROW(LeftVplPaths::decode(left.encode(), 8), Error) << "two paths of one slot";
}

// A scene without light leaves no lights, and what follows such a frame begins anew. What names what is not there any
// more is dropped.
TEST(IncrementalVpls, FollowsFramesThatHaveNothingForIt) {
    Scene dark = lit_step(0);
    dark.punctual_lights[0].intensity = Rgb(0);
    finish_scene(dark);
    const PhotonScene without(dark), lit(lit_step(0));
    SvoManyLightsParams params;
    params.incremental.on = true;
    params.vpls = kPaths;
    EXPECT_NO_THROW(LeftVplPaths::decode(SvoManyLights(params).left_to_next(), kPaths));
    const Frame follows(lit, SvoManyLights(params).left_to_next(), 4);
    EXPECT_EQ(follows.frames.paths().starts.size(), kPaths);
    EXPECT_EQ(follows.stats.counts.vpls_kept, 0u);

    LeftVplPaths strange = LeftVplPaths::decode(follows.left, kPaths);
    for (LeftVplPath& path : strange.paths) path.triangle = 100, path.instance = path.slot % 2 == 0 ? 0u : 99u;
    EXPECT_EQ(Frame(lit, strange.encode()).stats.counts.vpls_kept, 0u);
    strange = LeftVplPaths::decode(follows.left, kPaths);
    strange.lights = 2;
    EXPECT_EQ(Frame(lit, strange.encode()).stats.counts.vpls_kept, 0u) << "other lights";
}

TEST(IncrementalVpls, FramesAreTheSameWhoeverRendersThem) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    const PhotonScene lit(scene);
    test::RenderSettingsOf<SvoManyLights> settings;
    settings.size = {24, 20};
    settings.passes = 3;
    settings.params.vpls = kPaths;
    settings.params.bounces = 3;
    settings.params.caustic_photons = 0;
    settings.params.map_resolution = 64;
    settings.params.incremental.on = true;
    const auto frame = [&](const test::RenderSettingsOf<SvoManyLights>& asked, const std::string& before,
                           const std::string& state = {}) {
        MemoryBudget budget;
        SvoManyLights method(asked.params);
        return test::frame_after(method,
                                 {scene, lit.intersector.get(), test::view_of(scene, asked), asked.seed, budget}, asked,
                                 before, state);
    };
    const FrameOf first = frame(settings, "");
    settings.seed = 2;
    const FrameOf second = frame(settings, first.left);
    EXPECT_NE(second.film.pixel_hash(), frame(settings, "").film.pixel_hash()) << "it follows";
    for (const int threads : {1, 8}) {
        const FrameOf again = test::on_threads(threads, [&] { return frame(settings, first.left); });
        EXPECT_EQ(again.film.pixel_hash(), second.film.pixel_hash()) << threads;
        EXPECT_EQ(again.left, second.left) << threads;
    }
    // Another worker goes on with the last pass.
    auto part = settings;
    part.passes = 2;
    FrameOf begun = frame(part, first.left);
    part.first_pass = 2, part.passes = 1;
    const FrameOf ended = frame(part, first.left, begun.state);
    begun.film.merge(ended.film);
    EXPECT_EQ(begun.film.pixel_hash(), second.film.pixel_hash());
    EXPECT_EQ(ended.left, second.left);
    EXPECT_THROW(frame(part, second.left, begun.state), Error) << "passes of another frame";

    SvoManyLightsParams plain = settings.params;
    plain.incremental.on = false;
    EXPECT_THROW(SvoManyLights(plain).follow({first.left, nullptr}), Error);
    plain.incremental.on = true, plain.placement = VplPlacement::Camera;
    EXPECT_THROW(plain.check(), Error);
}

}  // namespace
}  // namespace photond::incremental_vpls_test
