// The pass loop and what is around it: when it stops, what its clock counts, what a cancelled pass leaves, and that the
// messages of a whole job are those of the contract.

#include "server/worker/job_runner.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <thread>

#include "protocol/error.h"
#include "renderer/core/sha256.h"
#include "renderer/film/film_file.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/solid_glass.h"
#include "server/worker/process_memory.h"
#include "server/worker/statistics.h"
#include "tests/support/counting_method.h"
#include "tests/support/job_runs.h"

namespace photond::job_runner_test {
namespace {

using nlohmann::json;
using test::CountingMethod;
using test::NoIntersector;

class PassLoopTest : public testing::Test {
protected:
    PassLoop::Result run(CountingMethod& method, StopConditions stop) {
        const RenderContext context{scene_, &intersector_, {Camera(), {4, 2}, PixelFilter::Box, LayerSet()}, 1, budget};
        PassLoop loop{method, context, stop, cancel, after_pass, first_pass, film, seconds_before, now, pauses};
        return loop.run(stats);
    }
    MemoryBudget budget;
    CancelToken cancel;
    Stats stats;
    std::function<bool(const Film&, double)> after_pass;
    uint32_t first_pass = 0;
    std::optional<Film> film;
    double seconds_before = 0;
    std::function<double()> now = wall_now_seconds;
    std::function<bool(const Film&, double)> pauses;

private:
    Scene scene_;
    NoIntersector intersector_;
};

TEST_F(PassLoopTest, StopsByPasses) {
    CountingMethod method;
    const PassLoop::Result result = run(method, {.seconds = {}, .passes = 5});
    EXPECT_EQ(method.passes_run, 5u);
    EXPECT_EQ(result.film.passes(), 5u);
    EXPECT_FALSE(result.cancelled);
    EXPECT_EQ(result.film.resolve_beauty()[0], 3.0f);  // the mean of 1 .. 5
    EXPECT_EQ(budget.structures().at("film"), result.film.bytes());
}

TEST_F(PassLoopTest, StopsBySecondsAfterAtLeastOnePass) {
    CountingMethod method;
    method.pass_time = std::chrono::milliseconds(2);
    const PassLoop::Result result = run(method, {.seconds = 1e-9, .passes = {}});
    EXPECT_EQ(result.film.passes(), 1u);
    const PassLoop::Result longer = [&] {
        CountingMethod again;
        again.pass_time = std::chrono::milliseconds(2);
        return run(again, {.seconds = 0.02, .passes = 1000});
    }();
    EXPECT_GE(longer.render_seconds, 0.02);
    EXPECT_LE(longer.film.passes(), 10u);  // each pass takes 2 ms or more
}

TEST_F(PassLoopTest, TheClockCountsTheMethodAndNothingElse) {
    CountingMethod method;
    method.begin_time = std::chrono::milliseconds(5), method.pass_time = std::chrono::milliseconds(1);
    double spent_after_passes = 0;
    after_pass = [&](const Film&, double) {
        const double start = wall_now_seconds();
        std::this_thread::sleep_for(std::chrono::milliseconds(30));
        spent_after_passes += wall_now_seconds() - start;
        return false;
    };
    const double start = wall_now_seconds();
    const PassLoop::Result result = run(method, {.seconds = {}, .passes = 4});
    EXPECT_GE(result.render_seconds, 0.009);
    EXPECT_LE(result.render_seconds + spent_after_passes, wall_now_seconds() - start);
}

TEST_F(PassLoopTest, TheNextPassIsExpectedWhileThisOneIsFoldedAndTheLastIsTheLast) {
    CountingMethod method;
    run(method, {.seconds = {}, .passes = 3});
    EXPECT_EQ(method.said, "e1re2rr");
}

// What a device does beside the loop is on the clock, also when the loop is about to leave it.
TEST_F(PassLoopTest, ADeviceComesToRestOnTheClockBeforeAPause) {
    CountingMethod method;
    method.settle_time = std::chrono::milliseconds(5);
    pauses = [](const Film& passes, double) { return passes.passes() == 2; };
    const PassLoop::Result result = run(method, {.seconds = {}, .passes = 3});
    EXPECT_EQ(method.said, "e1re2rsr");
    EXPECT_GE(result.render_seconds, 0.005);
}

TEST_F(PassLoopTest, AnUnfinishedPassLeavesNothing) {
    CountingMethod method;
    method.cancel_in_pass = &cancel, method.cancel_pass = 3;
    const PassLoop::Result result = run(method, {.seconds = {}, .passes = 100});
    EXPECT_TRUE(result.cancelled);
    EXPECT_EQ(method.passes_run, 4u);
    EXPECT_EQ(result.film.passes(), 3u);
    EXPECT_EQ(result.film.resolve_beauty()[0], 2.0f);  // the mean of 1 .. 3
}

TEST_F(PassLoopTest, TheClockIsTheOneItIsGivenAndGoesOnFromTheFilms) {
    CountingMethod method;
    double time = 0;
    now = [&] { return time += 0.25; };  // each interval takes 0.25 s
    const PassLoop::Result first = run(method, {.seconds = {}, .passes = 3});
    EXPECT_EQ(first.render_seconds, 1.0);  // begin and three passes
    EXPECT_EQ(first.passes_rendered, 3u);

    CountingMethod next;
    next.passes_run = 3;  // the pass it expects
    film = first.film, seconds_before = first.render_seconds;
    const PassLoop::Result second = run(next, {.seconds = 2.0, .passes = {}});
    EXPECT_EQ(second.render_seconds, 2.0);
    EXPECT_EQ(second.film.passes(), 6u);
    EXPECT_EQ(second.passes_rendered, 3u);
    EXPECT_EQ(second.film.resolve_beauty()[0], 3.5f);  // the mean of 1 .. 6

    CountingMethod never;
    film = second.film, seconds_before = second.render_seconds;
    const PassLoop::Result same = run(never, {.seconds = 2.0, .passes = {}});
    EXPECT_EQ(never.passes_run, 0u);
    EXPECT_FALSE(never.began);
    EXPECT_EQ(same.passes_rendered, 0u);
    EXPECT_TRUE(same.film == second.film);
}

TEST_F(PassLoopTest, APassThatIsNotDoneInTimeIsCutOffButTheFirst) {
    CountingMethod method;
    double time = 0;
    now = [&] { return time; };
    // A pass takes three seconds, and looks at the clock every half second.
    method.in_pass = [&](Stats&, const CancelToken& cancel) {
        for (const double end = time + 3; time < end && !cancel.cancelled();) time += 0.5;
    };
    const PassLoop::Result result = run(method, {.seconds = 7.25, .passes = {}});
    EXPECT_FALSE(result.cancelled);
    EXPECT_EQ(result.film.passes(), 2u);
    EXPECT_EQ(result.film.resolve_beauty()[0], 1.5f);  // the mean of 1 and 2
    EXPECT_EQ(result.passes_rendered, 2u);
    EXPECT_EQ(result.render_seconds, 7.5);  // the first look at the clock past 7.25
    EXPECT_EQ(result.passes_seconds, 6);
    EXPECT_EQ(result.cut_off_seconds, 1.5);

    CountingMethod first;
    first.in_pass = method.in_pass;
    const PassLoop::Result overshot = run(first, {.seconds = 1.0, .passes = {}});
    EXPECT_EQ(overshot.film.passes(), 1u);
    EXPECT_EQ(overshot.render_seconds, 3);
    EXPECT_EQ(overshot.cut_off_seconds, 0);

    CountingMethod next;  // a film that goes on has its first pass
    next.passes_run = 1, next.in_pass = method.in_pass;
    film = overshot.film, seconds_before = 3;
    const PassLoop::Result resumed = run(next, {.seconds = 4.0, .passes = {}});
    EXPECT_EQ(resumed.film.passes(), 1u);
    EXPECT_EQ(resumed.passes_rendered, 0u);
    EXPECT_EQ(resumed.render_seconds, 4);
    EXPECT_EQ(resumed.cut_off_seconds, 1);
}

// The clock may pass the end between a pass' last look at it and its return.
TEST_F(PassLoopTest, APassThatWasToldNothingIsWhole) {
    CountingMethod method;
    double time = 0;
    now = [&] { return time; };
    method.in_pass = [&](Stats&, const CancelToken& cancel) {
        EXPECT_FALSE(cancel.cancelled());
        time += 3;
    };
    const PassLoop::Result result = run(method, {.seconds = 4.0, .passes = {}});
    EXPECT_EQ(result.film.passes(), 2u);
    EXPECT_EQ(result.render_seconds, 6);
    EXPECT_EQ(result.cut_off_seconds, 0);
}

TEST_F(PassLoopTest, TheStagesAddUpToTheClock) {
    CountingMethod method;
    double time = 0;
    now = [&] { return time; };
    method.in_pass = [&](Stats& stats, const CancelToken&) {
        stats.stage("indirect").wall_seconds += 2;
        time += 2.5;
    };
    const PassLoop::Result result = run(method, {.seconds = {}, .passes = 3});
    EXPECT_EQ(result.render_seconds, 7.5);
    EXPECT_EQ(stats.stage("indirect").wall_seconds, 6);
    EXPECT_NEAR(stats.stage("indirect").wall_seconds + stats.stage("waiting").wall_seconds +
                    stats.stage("combine").wall_seconds,
                7.5, 1e-9);
}

TEST_F(PassLoopTest, EndsWhenToldAndBeginsAtItsFirstPass) {
    CountingMethod method;
    method.passes_run = first_pass = 10;
    after_pass = [](const Film& so_far, double) { return so_far.passes() == 2; };
    const PassLoop::Result result = run(method, {.seconds = {}, .passes = 5});
    EXPECT_FALSE(result.cancelled);
    EXPECT_EQ(result.film.pass_ranges().text(), "10-11");
}

TEST_F(PassLoopTest, AFilmPastTheBudgetIsRefusedFirst) {
    budget = MemoryBudget(Film::bytes_for({4, 2}, LayerSet()) - 1);
    CountingMethod method;
    try {
        run(method, {.seconds = {}, .passes = 1});
        ADD_FAILURE() << "rendered past the budget";
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::OutOfMemory);
    }
    EXPECT_EQ(method.passes_run, 0u);
}

TEST(ResolveView, CamerasLensesAndLayers) {
    const Scene scene = make_builtin_scene("cornell-box");
    JobRequest request;
    request.width = 32, request.height = 16, request.filter = "gaussian";
    request.layers = {"depth", "albedo"};
    View view = resolve_view(request, scene);
    EXPECT_EQ(view.camera.name, "camera");
    EXPECT_EQ(view.film_size, (Size2{32, 16}));
    EXPECT_EQ(view.filter, PixelFilter::Gaussian);
    EXPECT_TRUE(view.layers.has(Layer::Depth) && view.layers.has(Layer::Albedo) && view.layers.has(Layer::Direct));
    EXPECT_FALSE(view.layers.has(Layer::Normal));
    EXPECT_EQ(view.camera.aperture_radius_m, 0.0f);

    request.camera.aperture = 0.1;
    EXPECT_THROW(resolve_view(request, scene), Error);  // nothing to focus on
    request.camera.look_at = LookAt{{0, 0, 5}, {0, 3, 1}, {0, 1, 0}, 0.5};
    view = resolve_view(request, scene);
    EXPECT_FLOAT_EQ(view.camera.focus_distance_m, 5.0f);  // the 3-4-5 triangle to the target
    EXPECT_FLOAT_EQ(view.camera.aperture_radius_m, 0.1f);
    request.camera.focus_distance = 2.5;
    EXPECT_FLOAT_EQ(resolve_view(request, scene).camera.focus_distance_m, 2.5f);

    Scene far_away = scene;
    far_away.origin = dvec3(1e6, 0, 0);
    request.camera.look_at->eye[0] = request.camera.look_at->target[0] = 1e6;
    EXPECT_FLOAT_EQ(resolve_view(request, far_away).camera.position.x, 0.0f);

    request.camera = {};
    request.camera.name = "camer";
    EXPECT_THROW(resolve_view(request, scene), Error);
}

TEST(SolidGlass, ClosedMeshesOnly) {
    Scene scene;
    scene.materials.resize(1);
    scene.materials[0].transmission = 1, scene.materials[0].metallic = 0;
    Mesh tetrahedron;
    tetrahedron.positions = {vec3(0), vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1)};
    tetrahedron.triangles = {uvec3(0, 2, 1), uvec3(0, 1, 3), uvec3(0, 3, 2), uvec3(1, 2, 3)};
    Mesh unwelded;  // the same with corners of its own for each triangle
    for (const uvec3& triangle : tetrahedron.triangles) {
        const uint32_t first = static_cast<uint32_t>(unwelded.positions.size());
        for (int k = 0; k < 3; ++k) unwelded.positions.push_back(tetrahedron.positions[triangle[k]]);
        unwelded.triangles.push_back(uvec3(first, first + 1, first + 2));
    }
    Mesh open = tetrahedron;
    open.triangles.pop_back();
    Mesh turned = tetrahedron;  // one face inside out: not the boundary of a solid
    std::swap(turned.triangles[3].y, turned.triangles[3].z);
    scene.meshes = {tetrahedron, unwelded, open, turned};
    scene.instances.resize(4);
    for (uint32_t i = 0; i < 4; ++i) scene.instances[i].mesh = i;
    finish_scene(scene);
    EXPECT_FALSE(scene.needs.solid_glass);
    EXPECT_EQ(make_closed_glass_solid(scene), 2u);
    const auto solid = [&](size_t mesh) { return scene.materials[scene.meshes[mesh].material].solid; };
    EXPECT_TRUE(solid(0) && solid(1));
    EXPECT_FALSE(solid(2) || solid(3));
    EXPECT_TRUE(scene.needs.solid_glass);
    EXPECT_EQ(make_closed_glass_solid(scene), 0u);
}

using JobRunnerTest = test::JobRuns;

TEST_F(JobRunnerTest, AJobFromOrderToFilm) {
    const json finished = run(order());
    ASSERT_EQ(finished["state"], "succeeded") << finished.dump(1);
    EXPECT_EQ(sent.front(), json({{"type", "started"}, {"job", "J1"}, {"attempt", 2}}));
    EXPECT_EQ(finished["type"], "finished");
    EXPECT_EQ(finished["passes_done"], 3);
    EXPECT_EQ(finished["attempt"], 2);
    EXPECT_TRUE(finished["failure"].is_null());
    const Film film = FilmFile::load(film_path()).film;
    EXPECT_EQ(film.passes(), 3u);
    const json& statistics = finished["statistics"];
    EXPECT_EQ(statistics["pixel_hash"], film.pixel_hash());
    EXPECT_EQ(statistics["counts"]["passes"], 3);
    EXPECT_EQ(statistics["pass_ranges"], json({{0, 3}}));
    EXPECT_GE(statistics["counts"]["rays"]["camera"], 3 * 24 * 16);
    const json& memory = statistics["memory"];
    EXPECT_EQ(memory["structures"]["film"], film.bytes());
    uint64_t sum = 0;
    for (const auto& [name, bytes] : memory["structures"].items()) sum += bytes.get<uint64_t>();
    EXPECT_EQ(memory["accounted_bytes"], sum);
    EXPECT_GE(memory["peak_resident_bytes"], memory["baseline_resident_bytes"]);
    for (const char* field : {"rates", "needs", "skipped", "device", "version", "host_cores", "threads", "seed",
                              "job_hash", "nan_count", "infinity_count", "device_shared", "error", "reference_error",
                              "reference", "estimate", "settings_hash", "resumed_passes"})
        EXPECT_TRUE(statistics.contains(field)) << field;
}

TEST_F(JobRunnerTest, StagesAreTheRendersOwnSeconds) {
    // Of begin, passes and resolve. A job of milliseconds may be kept waiting between two stages: the run that was kept
    // waiting least says how much of the clock they are.
    double most = 0;
    for (int attempt = 0; attempt < 20 && !(most > 0.5); ++attempt) {
        const json finished = run(order());
        ASSERT_EQ(finished["state"], "succeeded") << finished.dump(1);
        double in_clock = 0;
        for (const json& stage : finished["statistics"]["stages"])
            if (!test::is_off_the_clock(stage["name"])) in_clock += stage["wall_seconds"].get<double>();
        const double share = in_clock / finished["seconds"].get<double>();
        EXPECT_LE(share, 1.02);
        most = std::max(most, share);
    }
    EXPECT_GT(most, 0.5);
}

TEST_F(JobRunnerTest, TheSameBitsForAnyThreadsAndFromAWarmScene) {
    const std::string first = run(order())["statistics"]["pixel_hash"];
    json one_thread = order();
    one_thread["limits"]["threads"] = 1;
    const json warm = run(one_thread);
    EXPECT_EQ(warm["statistics"]["pixel_hash"], first);
    EXPECT_EQ(warm["statistics"]["threads"], 1);
    for (const json& stage : warm["statistics"]["stages"]) EXPECT_NE(stage["name"], "acceleration_build");
    const json other = run(order({{"seed", 2u}}));
    ASSERT_EQ(other["state"], "succeeded") << other["failure"].dump();
    EXPECT_NE(other["statistics"]["pixel_hash"], first);
}

TEST_F(JobRunnerTest, SnapshotsAndCancelling) {
    JobControl control;
    const std::filesystem::path snapshot = film_path().string() + ".snapshot";
    control.film_so_far.ask(snapshot);
    const json finished = run(order(), control);
    EXPECT_EQ(finished["state"], "succeeded");
    bool saved = false;
    for (const json& message : sent)
        if (message["type"] == "film_saved") {
            saved = true;
            EXPECT_EQ(message["path"], snapshot.string());
            EXPECT_EQ(FilmFile::load(snapshot).film.passes(), message["passes_done"].get<uint32_t>());
        }
    EXPECT_TRUE(saved);
    std::filesystem::remove(snapshot);
    std::filesystem::remove(film_path());

    JobControl cancelled;
    cancelled.cancel.cancel();
    const json ended = run(order(), cancelled);
    EXPECT_EQ(ended["state"], "cancelled");
    EXPECT_EQ(ended["passes_done"], 0);
    EXPECT_TRUE(ended["film"].is_null());
    EXPECT_FALSE(std::filesystem::exists(film_path()));
}

TEST_F(JobRunnerTest, WhatTheMethodKeepsLiesBesideTheFilm) {
    const json finished = run(photon_order());
    ASSERT_EQ(finished["state"], "succeeded") << finished.dump(1);
    EXPECT_EQ(finished["artefacts"], json::array({"photon_map.glb"}));
    const json& counts = finished["statistics"]["counts"];
    EXPECT_EQ(counts["photons_emitted"], 3 * 2000);
    // A point of 64 bytes for each photon that the last of three passes stored, and the document.
    const auto bytes = static_cast<double>(std::filesystem::file_size(photon_map_path()));
    EXPECT_NEAR(bytes, 64 * counts["photons_stored"].get<double>() / 3, 0.1 * bytes);
    EXPECT_GT(finished["statistics"]["rates"]["photon_rays_per_second"], 0);
    std::filesystem::remove(photon_map_path());

    EXPECT_EQ(run(photon_order({{"keep_photon_map", false}}))["artefacts"], json::array());
    EXPECT_FALSE(std::filesystem::exists(photon_map_path()));
    const json traced = run(order());
    EXPECT_EQ(traced["artefacts"], json::array());
    EXPECT_TRUE(traced["statistics"]["rates"]["photon_rays_per_second"].is_null());
}

TEST_F(JobRunnerTest, AJobThatIsCutShortKeepsItsPhotonsUnlessItGoesOnElsewhere) {
    for (const bool stopping : {false, true}) {
        JobControl control;
        json message = photon_order();
        message["request"]["stop"] = {{"seconds", 3600}};
        control.film_so_far.ask(film_path().string() + ".s1");  // answered after the first pass
        std::thread cancelling([&] {
            while (!std::filesystem::exists(film_path().string() + ".s1"))
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
            control.stopping = stopping;
            control.cancel.cancel();
        });
        const json finished = run(message, control);
        cancelling.join();
        std::filesystem::remove(film_path().string() + ".s1");
        EXPECT_EQ(finished["state"], "cancelled");
        EXPECT_TRUE(std::filesystem::exists(film_path()));
        EXPECT_EQ(finished["artefacts"].size(), stopping ? 0u : 1u);
        EXPECT_EQ(std::filesystem::remove(photon_map_path()), !stopping);
    }
}

TEST_F(JobRunnerTest, AJobThatFailsInTheEndLeavesNothing) {
    std::filesystem::create_directory(film_path());  // where the film should go
    const json finished = run(photon_order());
    EXPECT_EQ(finished["state"], "failed");
    EXPECT_EQ(finished["artefacts"], json::array());
    EXPECT_FALSE(std::filesystem::exists(photon_map_path()));
    EXPECT_FALSE(std::filesystem::exists(film_path().string() + ".part"));
}

TEST_F(JobRunnerTest, FailuresSayWhatAndWhere) {
    const auto failure = [&](const json& message) {
        const json finished = run(message);
        EXPECT_EQ(finished["state"], "failed");
        EXPECT_TRUE(finished["film"].is_null());
        return finished["failure"];
    };
    EXPECT_EQ(failure(order({{"camera", {{"name", "nobody"}}}}))["code"], "unknown_name");
    const json bad = failure(order({{"method", {{"parameters", {{"indirect_bounces", -1}}}}}}));
    EXPECT_EQ(bad["errors"][0]["pointer"], "/method/parameters/indirect_bounces");
    json small = order({{"image", {{"width", 8192}, {"height", 8192}}}});
    EXPECT_EQ(failure(small)["code"], "out_of_memory");
    json no_scene = order();
    no_scene["scene"] = {{"id", "x"}, {"builtin", nullptr}, {"root", "/nowhere"}, {"file", "/nowhere/x.glb"}};
    EXPECT_EQ(failure(no_scene)["code"], "bad_scene");
    json no_folder = order();
    no_folder["film"] = "/nowhere/x.film";
    EXPECT_EQ(failure(no_folder)["code"], "internal");
    json no_request = order();
    no_request.erase("request");
    EXPECT_EQ(failure(no_request)["code"], "wrong_type");
    EXPECT_EQ(run(order())["state"], "succeeded");  // and the runner goes on
}

TEST(SceneCacheTest, KeepsTheLastSceneAndEvictsByUse) {
    SceneCache cache(1);  // nothing idle fits
    Stats stats;
    MemoryBudget budget;
    const SceneSource box{"cornell-box", "cornell-box", {}, {}}, furnace{"furnace", "furnace", {}, {}};
    const auto first = cache.get(box, {}, budget, stats);
    EXPECT_EQ(cache.get(box, {}, budget, stats), first);
    SceneVariant solid;
    solid.solid_glass = true;
    EXPECT_FALSE(cache.holds(box, solid));
    (void)cache.get(furnace, {}, budget, stats);
    (void)cache.get(furnace, {}, budget, stats);
    EXPECT_TRUE(cache.holds(furnace, {}));
    EXPECT_FALSE(cache.holds(box, {}));
    MemoryBudget tiny(100);
    EXPECT_THROW((void)cache.get(box, {}, tiny, stats), Error);
    EXPECT_FALSE(cache.holds(box, {}));
}

TEST(Statistics, FlattenToAttributes) {
    const json statistics = {{"stages", {{{"name", "load"}, {"wall_seconds", 0.5}, {"gpu_seconds", nullptr}}}},
                             {"memory", {{"accounted_bytes", 7}}},
                             {"seed", 18446744073709551615ull},
                             {"device_shared", false},
                             {"skipped", {{{"what", "light tree"}}}},
                             {"version", "1"}};
    std::map<std::string, std::variant<double, std::string>> found;
    for (const ImageAttribute& attribute : statistics_attributes(statistics)) found[attribute.name] = attribute.value;
    const std::map<std::string, std::variant<double, std::string>> expected{
        {"photond:stages.load.wall_seconds", 0.5}, {"photond:memory.accounted_bytes", 7.0},
        {"photond:seed", "18446744073709551615"},  {"photond:device_shared", 0.0},
        {"photond:skipped.0.what", "light tree"},  {"photond:version", "1"}};
    EXPECT_EQ(found, expected);
    EXPECT_TRUE(statistics_attributes(nullptr).empty());
}

TEST(Statistics, TheJobHashIsOfWhatMakesThePixels) {
    JobRequest request;
    request.scene = "box", request.width = 8, request.height = 8, request.method.name = "path_tracing";
    request.stop.passes = 4;
    const std::string hash = job_hash(request, "id");
    request.priority = 5, request.labels["a"] = "b", request.scene = "another name of it";
    EXPECT_EQ(job_hash(request, "id"), hash);
    request.seed = 2;
    EXPECT_NE(job_hash(request, "id"), hash);
}

TEST(Statistics, TheJobHashOfAJobAtRestIsThatOfBeforeThereWereAnimations) {
    JobRequest request;
    request.scene = "box", request.width = 8, request.height = 8, request.method.name = "path_tracing";
    request.stop.passes = 4;
    const std::string then =
        R"({"camera":{"aperture":0.0,"focus_distance":null,"look_at":null,"name":null},"environment":null,)"
        R"("first_pass":0,"glass":"as_stored","image":{"filter":"box","height":8,"width":8},"layers":[],)"
        R"("method":{"device":"cpu","name":"path_tracing","parameters":{}},"metrics":[],"reference":null,)"
        R"("scene":"id","seed":1,"stop":{"passes":4,"seconds":null,"target":null},"time":0.0})";
    EXPECT_EQ(job_hash(request, "id"), sha256_hex(then.data(), then.size()));
    request.animation = JobAnimation{.name = "walk", .index = {}};
    const std::string moving = job_hash(request, "id");
    EXPECT_NE(moving, sha256_hex(then.data(), then.size()));
    request.shutter = 0.1;
    EXPECT_NE(job_hash(request, "id"), moving);
}

}  // namespace
}  // namespace photond::job_runner_test
