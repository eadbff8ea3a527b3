// Moving scenes as a worker renders them: the frame at a time is the picture of the still scene whose vertices were
// posed apart from the renderer, whatever was shown before, and what does not move is not built again.

#include <gtest/gtest.h>

#include <map>

#include "protocol/error.h"
#include "renderer/methods/photon_mapping/photon_mapping.h"
#include "renderer/methods/photon_splatting/photon_splatting.h"
#include "renderer/methods/svo_many_lights/svo_many_lights.h"
#include "renderer/scene/mesh_builder.h"
#include "renderer/scene/rig_builder.h"
#include "server/worker/moving_passes.h"
#include "server/worker/scene_cache.h"
#include "tests/support/animated_gltf.h"
#include "tests/support/gltf_equations.h"
#include "tests/support/path_render.h"

namespace photond::moving_scenes_test {
namespace {

/// The scene without its rig, its vertices those of the equations, rounded; triangles, materials and what the camera
/// sees by stay.
Scene posed_apart(const TestGltf& file, double time) {
    Scene scene = file.load();
    const test::EvaluatedScene evaluated = test::evaluate_gltf(file.json(), file.binary(), 0, time);
    scene.rig = nullptr;
    for (size_t m = 0; m < scene.meshes.size(); ++m) {
        const test::EvaluatedPrimitive& primitive = evaluated.primitives.at(m);
        for (size_t v = 0; v < scene.meshes[m].positions.size(); ++v) {
            scene.meshes[m].positions[v] = vec3(primitive.positions[v]);
            if (!scene.meshes[m].normals.empty()) scene.meshes[m].normals[v] = vec3(primitive.normals[v]);
        }
    }
    scene.cameras.at(0).position = vec3(dvec3(evaluated.cameras.at(0)[3]));
    finish_scene(scene);
    return scene;
}

template <class M>
void expect_same_picture(const Scene& moved, const Scene& apart, const char* name) {
    test::RenderSettingsOf<M> settings;
    settings.size = {24, 24};
    settings.passes = 2;
    if constexpr (requires { settings.params.photons; }) settings.params.photons = 2000;
    const Film film = test::render(moved, settings);
    EXPECT_EQ(film.pixel_hash(), test::render(apart, settings).pixel_hash()) << name;
    EXPECT_GT(test::mean_of(film.resolve_beauty()), 0.01) << name;
}

TEST(MovingScenes, AFrameIsTheStillSceneOfItsMoment) {
    const TestGltf file = test::animated_file("RoomThatMoves");
    Scene scene = file.load();
    for (const double time : {0.0, 0.7, 1.9}) {
        pose_scene(scene, {0, time});
        const Scene apart = posed_apart(file, time);
        expect_same_picture<PathTracing>(scene, apart, "path tracing");
        expect_same_picture<PhotonMapping>(scene, apart, "photon mapping");
        expect_same_picture<PhotonSplatting>(scene, apart, "photon splatting");
        expect_same_picture<SvoManyLights>(scene, apart, "many lights");
    }
}

// --- kept between frames ---------------------------------------------------------------------------------------------
SceneSource builtin(const char* name) { return {name, name, {}, {}}; }
SceneMoment at(double time) { return {JobAnimation{.name = {}, .index = 0}, time}; }

template <class M = PathTracing>
std::string picture(const ReadyScene& ready, Stats* stages = nullptr) {
    test::RenderSettingsOf<M> settings;
    settings.size = {24, 24};
    settings.passes = 2;
    if constexpr (std::is_same_v<M, SvoManyLights>) settings.params.visibility = VplVisibility::Svo;
    Film film(settings.size, settings.layers);
    MemoryBudget budget;
    Stats stats;
    const RenderContext context{.scene = ready.scene,
                                .intersector = ready.intersector.get(),
                                .view = test::view_of(ready.scene, settings),
                                .budget = budget,
                                .kept_voxels = ready.kept_voxels.get()};
    test::run_passes_in(
        context, settings, [&](M& method, uint32_t) { method.resolve(film); }, stages ? *stages : stats);
    return film.pixel_hash();
}

class HardCasesOfMotion : public testing::TestWithParam<const char*> {};

// There and back: nothing of a frame is left in the next.
TEST_P(HardCasesOfMotion, FramesStandAlone) {
    SceneCache kept(1ull << 30);
    MemoryBudget budget;
    Stats stats;
    std::map<double, std::string> alone;
    for (const double time : {0.2, 0.49, 0.5, 0.8, 0.49, 0.2}) {
        if (!alone.contains(time)) {
            SceneCache fresh(1);
            alone[time] = picture(*fresh.get(builtin(GetParam()), {}, budget, stats, false, at(time)));
        }
        EXPECT_EQ(picture(*kept.get(builtin(GetParam()), {}, budget, stats, false, at(time))), alone[time])
            << "at " << time;
    }
    EXPECT_NE(alone[0.2], alone[0.8]);
}

// A job's voxels follow from those of the job before where the scene's bounds, and so the grid, are as they were.
TEST_P(HardCasesOfMotion, LeaveNothingButTheirVoxels) {
    SceneCache kept(1ull << 30);
    MemoryBudget budget;
    Stats stats, warm;
    std::optional<Bounds3> before;  // of the last frame that asked for voxels
    bool follows = false;
    for (const double time : {0.2, 0.49, 0.5, 0.8}) {
        SceneCache fresh(1);
        const std::string alone =
            picture<SvoManyLights>(*fresh.get(builtin(GetParam()), {}, budget, stats, false, at(time)));
        const auto ready = kept.get(builtin(GetParam()), {}, budget, stats, false, at(time));
        EXPECT_EQ(picture<SvoManyLights>(*ready, &warm), alone) << "at " << time;
        EXPECT_EQ(kept.bytes(), ready->bytes() + ready->kept_bytes());
        if (ready->kept_bytes() == 0) continue;  // there is no light
        const Bounds3& bounds = ready->scene.bounds;
        follows |= before && before->min == bounds.min && before->max == bounds.max;
        before = bounds;
    }
    const auto has = [&](const char* name) {
        return std::ranges::any_of(warm.stages, [&](const Stage& stage) { return stage.name == name; });
    };
    EXPECT_TRUE(has("svo_build"));
    EXPECT_EQ(has("svo_update"), follows);
}
INSTANTIATE_TEST_SUITE_P(Scenes, HardCasesOfMotion,
                         testing::Values("moving/cornell-box", "moving/thin-object", "moving/teleport",
                                         "moving/appearing", "moving/light-switched-on", "moving/light-switched-off"),
                         [](const auto& info) { return "Scene" + std::to_string(info.index); });

// What is kept goes where there is no room for it, and the scene stays.
TEST(MovingScenes, LetVoxelsGoFirst) {
    SceneCache scarce(1);
    MemoryBudget budget;
    Stats stats;
    const SceneSource box = builtin("moving/cornell-box");
    const ReadyScene* first = scarce.get(box, {}, budget, stats, false, at(1)).get();
    (void)picture<SvoManyLights>(*first);
    EXPECT_GT(first->kept_bytes(), 0u);
    EXPECT_EQ(scarce.get(box, {}, budget, stats, false, at(2)).get(), first);
    EXPECT_EQ(first->kept_bytes(), 0u);
}

TEST(MovingScenes, AreLoadedOnceAndRefuseAnimationsThatTheyDoNotHave) {
    SceneCache cache(1ull << 30);
    MemoryBudget budget;
    Stats stats;
    const SceneSource box = builtin("moving/cornell-box");
    const ReadyScene* first = cache.get(box, {}, budget, stats, false, at(1)).get();
    EXPECT_EQ(cache.get(box, {}, budget, stats, false, at(2)).get(), first);
    EXPECT_EQ(first->scene.moment, (Moment{0, 2}));
    const JobAnimation by_name{.name = "everything", .index = {}};
    EXPECT_EQ(cache.get(box, {}, budget, stats, false, {by_name, 3}).get(), first);
    EXPECT_EQ(cache.get(box, {}, budget, stats).get(), first);
    EXPECT_EQ(first->scene.moment, Moment{}) << "a job without a time is at rest";
    for (const JobAnimation& wrong :
         {JobAnimation{.name = "everythin", .index = {}}, JobAnimation{.name = {}, .index = 1}})
        try {
            (void)cache.get(box, {}, budget, stats, false, {wrong, 0});
            ADD_FAILURE();
        } catch (const Error& error) {
            EXPECT_EQ(error.code, ErrorCode::UnknownName);
            EXPECT_EQ(error.faults.front().pointer, "/animation");
        }
}

// --- an open shutter -------------------------------------------------------------------------------------------------
TEST(Shutter, MomentsOfAnyPassesInARowLieEvenly) {
    for (const uint32_t first : {0u, 17u})
        for (const uint32_t count : {2u, 8u, 13u, 64u}) {
            std::vector<double> shares;
            for (uint32_t pass = 0; pass < count; ++pass) shares.push_back(shutter_share(5, first + pass));
            std::ranges::sort(shares);
            double widest = shares.front() + 1 - shares.back();
            for (size_t i = 1; i < shares.size(); ++i) widest = std::max(widest, shares[i] - shares[i - 1]);
            EXPECT_LT(widest, 1.9 / count) << "gaps are at most 1 + 2 / sqrt(5) times the even one";
        }
    EXPECT_NE(shutter_share(1, 0), shutter_share(2, 0));
}

// The film is the sum of films of single passes, each of the scene as it is at its moment.
TEST(Shutter, EachPassShowsItsOwnMoment) {
    constexpr double kOpen = 0.1, kFor = 0.6;
    constexpr uint32_t kPasses = 5;
    test::RenderSettings settings;
    settings.size = {24, 24};
    SceneCache scenes(1ull << 30);
    MemoryBudget budget;
    Stats stats;
    const SceneSource box = builtin("moving/cornell-box");
    const auto ready = scenes.get(box, {}, budget, stats, false, at(kOpen));
    const auto context = [&](const ReadyScene& shown) {
        return RenderContext{shown.scene, shown.intersector.get(), test::view_of(shown.scene, settings), 1, budget};
    };
    MovingPasses moving({.make = [] { return std::make_unique<PathTracing>(PathTracingParams()); },
                         .show =
                             [&](double time, Stats& counted) {
                                 scenes.show(at(time), budget, counted);
                                 return context(*ready);
                             },
                         .open_s = kOpen,
                         .shutter_s = kFor,
                         .seed = 1});
    Film film(settings.size, settings.layers);
    moving.begin(context(*ready), stats);
    for (uint32_t pass = 0; pass < kPasses; ++pass) {
        moving.run_pass(pass, stats, CancelToken{});
        moving.resolve(film);
    }
    Film sum(settings.size, settings.layers);
    for (uint32_t pass = 0; pass < kPasses; ++pass) {
        SceneCache fresh(1);
        const double time = kOpen + kFor * shutter_share(1, pass);
        const auto alone = fresh.get(box, {}, budget, stats, false, at(time));
        settings.first_pass = pass;
        Film part(settings.size, settings.layers, pass);
        test::run_passes_in(
            context(*alone), settings, [&](PathTracing& method, uint32_t) { method.resolve(part); }, stats);
        pass == 0 ? void(sum = std::move(part)) : sum.merge(part);
    }
    EXPECT_EQ(film.pixel_hash(), sum.pixel_hash());
}

/// A still sphere of so many triangles that it is not built again, and a small lamp that passes before it.
Scene large_scene() {
    Scene scene;
    Material material;
    material.metallic = 0;
    scene.materials = {material, material};
    scene.materials[1].emission = Rgb(2);
    scene.meshes.push_back(make_icosphere(7, 0));  // 327,680 triangles
    scene.instances.push_back({.mesh = 0});
    Rig rig;
    auto lamp = std::make_shared<ObjectMesh>();
    lamp->mesh = make_icosphere(3, 1);
    add_rigged_mesh(scene, rig, lamp, add_node(rig, {}));
    Animation animation;
    animation.channels = {drive(Property::Translation, 0, {0, 1}, {-0.4f, 0, 1.5f, 0.4f, 0.1f, 1.5f}),
                          drive(Property::Scale, 0, {0, 0.9f, 1}, {0.3f, 0.3f, 0.3f, 0.3f, 0.3f, 0.3f, 0, 0, 0})};
    rig.animations.push_back(std::move(animation));
    adopt_rig(scene, std::make_shared<const Rig>(std::move(rig)));
    finish_scene(scene);
    return scene;
}

// At an edge either of two triangles may answer.
TEST(MovingScenes, AStructureThatFollowsAnswersAsOneThatIsBuiltAnew) {
    Scene scene = large_scene();
    MemoryBudget budget;
    Stats stats;
    std::unique_ptr<Intersector> kept = make_embree_intersector(scene, budget, stats);
    for (const double time : {0.5, 0.1, 1.0, 0.7}) {
        const SceneChange change = pose_scene(scene, {0, time});
        follow_pose(kept, scene, change, budget, stats);
        Scene still = scene;
        still.rig = nullptr;
        const std::unique_ptr<Intersector> built = make_embree_intersector(still, budget, stats);
        uint32_t moving = 0, other = 0;
        for (uint32_t i = 0; i < 4096; ++i) {
            const float x = static_cast<float>(i % 64) / 16 - 1.9997f, y = static_cast<float>(i / 64) / 16 - 1.9993f;
            const Ray ray{vec3(x, y, 6), glm::normalize(vec3(-0.1f * x, -0.1f * y, -1))};
            const Hit a = kept->closest_hit(ray), b = built->closest_hit(ray);
            moving += a.instance == 1, other += a.valid() && a.instance == 0;
            EXPECT_EQ(a.instance, b.instance);
            EXPECT_EQ(a.t, b.t);
            EXPECT_EQ(kept->occluded(ray), built->occluded(ray));
        }
        EXPECT_GT(other, 100u);
        EXPECT_EQ(moving > 0, time != 1.0) << "in the end it is scaled to nothing; at " << time;
    }
}

}  // namespace
}  // namespace photond::moving_scenes_test
