// Temporal reprojection: where a point was, what tells a change of the light from noise, and frames that follow.

#include <gtest/gtest.h>

#include <cmath>

#include "protocol/error.h"
#include "renderer/core/rng.h"
#include "renderer/film/film_file.h"
#include "renderer/gbuffer/light_change.h"
#include "renderer/gbuffer/reprojection.h"
#include "renderer/gbuffer/temporal_reprojection.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/camera_projection.h"
#include "renderer/scene/pose.h"
#include "tests/support/path_render.h"

namespace photond::temporal_reprojection_test {
namespace {

constexpr Size2 kSize{44, 44};  // which the room fills

/// A scene and what a method is told of it.
struct Shown {
    explicit Shown(const Scene& of, LayerSet layers = {}, Size2 size = kSize)
        : scene(of),
          rays(make_embree_intersector(scene, budget, stats)),
          context{scene, rays.get(), {find_camera(scene, ""), size, PixelFilter::Box, layers}, 1, budget} {}

    Reprojected reproject(const History* before, const PastPose* pose) const {
        return photond::reproject(scene, context.view, begin_centre_hits(context)->take(), before, pose);
    }

    const Scene& scene;
    MemoryBudget budget;
    Stats stats;
    const std::unique_ptr<Intersector> rays;
    RenderContext context;
};

// --- where a point was -----------------------------------------------------------------------------------------------

/// A history whose light is the position itself.
History positions_as_light(const Reprojected& found) {
    History history = found.now;
    for (size_t i = 0; i < history.indirect.size(); ++i) history.indirect[i] = history.position[i];
    history.frames.assign(history.frames.size(), 3);
    return history;
}

TEST(Reprojection, FindsTheSamePointsFromAnotherPlace) {
    const Scene scene = make_builtin_scene("cornell-box");
    Shown shown(scene);
    const PastPose pose(scene);
    const Reprojected first = shown.reproject(nullptr, nullptr);
    EXPECT_EQ(first.past.frames, std::vector<float>(kSize.pixels(), 0));
    const History before = positions_as_light(first);
    // From the same place: the same pixels, bit for bit.
    const Reprojected same = shown.reproject(&before, &pose);
    EXPECT_EQ(same.past.indirect, before.indirect);
    // From another: between pixels of the image before, no farther off there than these are apart.
    const CameraRays camera_before(before.camera, kSize);
    shown.context.view.camera.position += vec3(0.3f, 0.1f, 0);
    const Reprojected moved = shown.reproject(&before, &pose);
    size_t found = 0;
    for (size_t i = 0; i < kSize.pixels(); ++i) {
        if (moved.rejection[i] != Rejection::None) continue;
        ++found;
        EXPECT_NEAR(moved.past.frames[i], 3, 1e-5);
        const vec2 off =
            *project(camera_before, moved.past.indirect[i]) - *project(camera_before, moved.now.position[i]);
        EXPECT_LT(std::max(std::fabs(off.x), std::fabs(off.y)), 1.001f);
    }
    EXPECT_GT(found, kSize.pixels() * 4 / 5);
}

TEST(Reprojection, SaysWhatWasOutsideOfTheImage) {
    const Scene scene = make_builtin_scene("cornell-box");
    Shown shown(scene);
    const PastPose pose(scene);
    Camera& camera = shown.context.view.camera;
    camera.position += 6.0f * camera.forward;  // into the room
    const History before = positions_as_light(shown.reproject(nullptr, nullptr));
    camera = look_at_camera(dvec3(camera.position), dvec3(camera.position + camera.forward + 0.15f * camera.right),
                            dvec3(camera.up), camera.yfov);
    const Reprojected turned = shown.reproject(&before, &pose);
    const auto count = [&](Rejection why) { return std::count(turned.rejection.begin(), turned.rejection.end(), why); };
    EXPECT_GT(count(Rejection::Outside), 0);
    EXPECT_GT(count(Rejection::None), count(Rejection::Outside));
}

// A block that has jumped is found where it was, and what it hid there is new.
TEST(Reprojection, FollowsWhatMoves) {
    Scene scene = make_builtin_scene("moving/teleport");
    pose_scene(scene, {0, 0.4});
    History before;
    {
        Shown shown(scene);
        before = positions_as_light(shown.reproject(nullptr, nullptr));
    }
    const PastPose then(scene);
    pose_scene(scene, {0, 0.6});
    Shown shown(scene);
    const Reprojected found = shown.reproject(&before, &then);
    size_t of_block = 0, new_wall = 0;
    for (size_t i = 0; i < kSize.pixels(); ++i) {
        const uint32_t instance = found.now.instance[i];
        if (instance == kNoHit) continue;
        const bool is_block = scene.instances[instance].mesh == scene.rig->meshes.back().mesh;
        if (is_block && found.rejection[i] == Rejection::None) {
            ++of_block;
            // It jumped by 3.2 m to the right and 1.4 m back.
            const vec3 jump = found.now.position[i] - found.past.indirect[i];
            EXPECT_NEAR(jump.x, 3.2f, 0.2f);
            EXPECT_NEAR(jump.z, -1.4f, 0.2f);
        }
        if (!is_block && before.instance[i] != instance) {
            ++new_wall;
            EXPECT_EQ(found.rejection[i], Rejection::Surface);
        }
    }
    EXPECT_GT(of_block, 20u);
    EXPECT_GT(new_wall, 20u);
}

TEST(Reprojection, TakesNothingOverInMirrorsAndGlass) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    Shown shown(scene);
    const PastPose pose(scene);
    const History before = positions_as_light(shown.reproject(nullptr, nullptr));
    const Reprojected found = shown.reproject(&before, &pose);
    const std::vector<Hit> hits = [&] {
        std::vector<Ray> rays;
        for (size_t i = 0; i < kSize.pixels(); ++i)
            rays.push_back(camera_ray(shown.context.view.camera, kSize,
                                      vec2(i % kSize.width, i / kSize.width) + vec2(0.5f), vec2(0.5f)));
        std::vector<Hit> all(rays.size());
        shown.rays->closest_hits(rays, all, Coherence::Coherent);
        return all;
    }();
    size_t glass = 0;
    for (size_t i = 0; i < hits.size(); ++i) {
        if (!hits[i].valid()) continue;
        const Material& material = scene.materials[scene.meshes[scene.instances[hits[i].instance].mesh].material];
        if (!(material.transmission > 0)) continue;
        ++glass;
        EXPECT_EQ(found.rejection[i], Rejection::Surface);
    }
    EXPECT_GT(glass, 20u);
}

// --- what tells a change of the light --------------------------------------------------------------------------------

/// A grey image with a history of `frames` frames of it.
Reprojected grey_history(float light, float frames) {
    Reprojected found{History(kSize), History(kSize), std::vector<Rejection>(kSize.pixels(), Rejection::None)};
    found.past.indirect.assign(kSize.pixels(), Rgb(light));
    found.past.near_light.assign(kSize.pixels(), Rgb(light));
    found.past.frames.assign(kSize.pixels(), frames);
    found.past.age.assign(kSize.pixels(), frames);
    return found;
}

/// Light with noise of pixels that know nothing of each other: uniform from 0 to twice the light.
std::vector<Rgb> noisy_pass(float light, uint64_t seed) {
    std::vector<Rgb> pass(kSize.pixels());
    for (size_t i = 0; i < pass.size(); ++i)
        pass[i] = Rgb(2 * light * float(double(hash64(seed * 1'000'003 + i) >> 11) * 0x1p-53));
    return pass;
}

double mean_share(const LightChange& change) { return test::mean_of(change.own_share); }

TEST(LightChange, IsNotSeenInNoise) {
    for (const float frames : {1.0f, 4.0f, 15.0f}) {
        const double share = mean_share(find_light_change(grey_history(1, frames), noisy_pass(1, 7)));
        // As in a mean of so many frames and one; a window is far off by chance now and then.
        EXPECT_GT(share, 0.99 / (frames + 1));
        EXPECT_LT(share, 1.25 / (frames + 1));
    }
}

TEST(LightChange, TakesNothingOverOfALightThatIsOut) {
    const Reprojected found = grey_history(1, 15);
    EXPECT_GT(mean_share(find_light_change(found, std::vector<Rgb>(kSize.pixels(), Rgb(0)))), 0.99);
    EXPECT_GT(mean_share(find_light_change(found, noisy_pass(0.1f, 3))), 0.98);
    // And nothing of the dark, where one has come on.
    EXPECT_GT(mean_share(find_light_change(grey_history(0, 15), noisy_pass(1, 5))), 0.7);
    // Some of one that is a tenth brighter, below the noise of a pixel.
    const double share = mean_share(find_light_change(found, noisy_pass(1.1f, 11)));
    EXPECT_GT(share, 1.01 / 16);
    EXPECT_LT(share, 0.5);
}

TEST(LightChange, LeavesOutWhatIsNoNumber) {
    const Reprojected found = grey_history(1, 15);
    std::vector<Rgb> pass = noisy_pass(1, 7);
    const LightChange whole = find_light_change(found, pass);
    const size_t middle = 20 * kSize.width + 20;
    pass[middle] = Rgb(std::numeric_limits<float>::quiet_NaN());
    pass[middle + 200] = Rgb(kInfinity);
    const LightChange change = find_light_change(found, pass);
    for (size_t i = 0; i < pass.size(); ++i) {
        EXPECT_TRUE(std::isfinite(change.own_share[i]) && is_finite(change.near_light[i]) &&
                    std::isfinite(change.step_product[i]));
        // Neighbours lack one of 49 pixels.
        if (i != middle && i != middle + 200) {
            EXPECT_NEAR(change.near_light[i].x, whole.near_light[i].x, 0.1f);
        }
    }
}

TEST(LightChange, LeavesWhatHasNoHistory) {
    Reprojected found = grey_history(1, 15);
    found.rejection.assign(kSize.pixels(), Rejection::Surface);
    const LightChange change = find_light_change(found, noisy_pass(1, 2));
    EXPECT_EQ(change.own_share, std::vector<float>(kSize.pixels(), 1));
}

// --- frames ----------------------------------------------------------------------------------------------------------

struct FrameMade {
    Film film;
    std::string left;
};

struct FrameAsked {
    uint64_t seed = 1;
    uint32_t passes = 1;
    LayerSet layers = {};
    Size2 size = kSize;
};

std::unique_ptr<TemporalReprojection> paths_that_follow(uint32_t history_cap = 16) {
    PathTracingParams params;
    params.sampler = SamplerKind::Random;
    return std::make_unique<TemporalReprojection>(std::make_unique<PathTracing>(params),
                                                  TemporalParams{TemporalReuse::Reproject, history_cap});
}

FrameMade make_frame(const Scene& scene, const FrameAsked& asked, const FrameBefore& before) {
    Shown shown(scene, asked.layers, asked.size);
    shown.context.seed = asked.seed;
    const std::unique_ptr<TemporalReprojection> method = paths_that_follow();
    if (!before.left.empty()) method->follow(before);
    method->begin(shown.context, shown.stats);
    FrameMade made{Film(asked.size, asked.layers), {}};
    for (uint32_t pass = 0; pass < asked.passes; ++pass) {
        method->run_pass(pass, shown.stats, CancelToken{});
        method->resolve(made.film);
    }
    made.left = method->left_to_next();
    return made;
}

double squared_error(const std::vector<float>& image, const std::vector<float>& truth) {
    double sum = 0;
    for (size_t i = 0; i < image.size(); ++i) sum += std::pow(double(image[i]) - truth[i], 2);
    return sum / double(image.size());
}

// Of a still scene: after n frames as good as a mean of n, but for what windows are far off by chance.
TEST(TemporalReprojection, FramesOfAStillSceneAddUp) {
    const Scene scene = make_builtin_scene("cornell-box");
    test::RenderSettings settings;
    settings.size = kSize, settings.passes = 256, settings.seed = 999;
    const std::vector<float> truth = test::render(scene, settings).resolve(Layer::Indirect);
    const auto pose = std::make_shared<const PastPose>(scene);
    FrameBefore before{"", pose};
    LayerSet layers;
    for (const Layer layer : {Layer::HistoryLength, Layer::Reused, Layer::Rejected}) layers.add(layer);
    std::vector<double> errors;
    for (uint64_t seed = 1; seed <= 8; ++seed) {
        const FrameMade made = make_frame(scene, {.seed = seed, .passes = 2, .layers = layers}, before);
        errors.push_back(squared_error(made.film.resolve(Layer::Indirect), truth));
        const double frames = test::mean_of(made.film.resolve(Layer::HistoryLength));
        EXPECT_LE(frames, double(seed) + 1e-3);
        EXPECT_GT(frames, 0.6 * double(seed));
        const double reused = test::mean_of(made.film.resolve(Layer::Reused));
        EXPECT_LE(reused, 1 - 1 / double(seed) + 1e-6);
        EXPECT_GE(reused, 0.8 * (1 - 1 / double(seed)));
        before.left = made.left;
    }
    EXPECT_LT(errors.back(), errors.front() / 4);
    EXPECT_LT(errors.back(), errors[3]);
}

/// Grey light, but for a pixel that is no number.
class FaultyMethod final : public Method {
public:
    static constexpr size_t kFaulty = 20 * kSize.width + 20;

    void begin(const RenderContext& context, Stats&) override {
        image_ = PassImage(context.view.film_size, context.view.layers);
    }
    void run_pass(uint32_t, Stats&, const CancelToken&) override {
        std::vector<Rgb>& indirect = image_.of<Layer::Indirect>();
        indirect.assign(indirect.size(), Rgb(1));
        indirect[kFaulty] = Rgb(std::numeric_limits<float>::quiet_NaN());
    }
    PassImage* end_pass() override { return &image_; }

private:
    PassImage image_;
};

// The film drops such a pixel and counts it. It has no part in what is left, where it would spread from frame to frame.
TEST(TemporalReprojection, WhatIsNoNumberStaysInItsPixelAndItsFrame) {
    const Scene scene = make_builtin_scene("cornell-box");
    FrameBefore before{"", std::make_shared<const PastPose>(scene)};
    for (int frame = 0; frame < 3; ++frame) {
        Shown shown(scene);
        TemporalReprojection method(std::make_unique<FaultyMethod>(), {TemporalReuse::Reproject, 16});
        if (frame > 0) method.follow(before);
        method.begin(shown.context, shown.stats);
        Film film(kSize, {});
        method.run_pass(0, shown.stats, CancelToken{});
        method.resolve(film);
        EXPECT_EQ(film.nan_count(), 1u);
        const std::vector<float> indirect = film.resolve(Layer::Indirect);
        for (size_t i = 0; i < kSize.pixels(); ++i)
            EXPECT_FLOAT_EQ(indirect[3 * i], i == FaultyMethod::kFaulty ? 0.0f : 1.0f);
        before.left = method.left_to_next();
    }
}

// A cap of one frame takes nothing over, and says so in numbers.
TEST(TemporalReprojection, OneFrameIsTheFramesOwn) {
    const Scene scene = make_builtin_scene("cornell-box");
    LayerSet layers;
    for (const Layer layer : {Layer::HistoryLength, Layer::Reused, Layer::Rejected}) layers.add(layer);
    const FrameBefore before{make_frame(scene, {.layers = layers}, {}).left, std::make_shared<const PastPose>(scene)};
    Shown shown(scene, layers);
    shown.context.seed = 2;
    const std::unique_ptr<TemporalReprojection> method = paths_that_follow(1);
    method->follow(before);
    method->begin(shown.context, shown.stats);
    Film film(kSize, layers);
    method->run_pass(0, shown.stats, CancelToken{});
    method->resolve(film);
    EXPECT_EQ(film.nan_count() + film.infinity_count(), 0u);
    EXPECT_EQ(film.resolve(Layer::Reused), std::vector<float>(kSize.pixels(), 0));
    EXPECT_EQ(film.resolve(Layer::Indirect),
              make_frame(scene, {.seed = 2, .layers = layers}, {}).film.resolve(Layer::Indirect));
}

TEST(TemporalReprojection, DirectLightIsThePassesOwn) {
    const Scene scene = make_builtin_scene("cornell-box");
    const auto pose = std::make_shared<const PastPose>(scene);
    const FrameMade first = make_frame(scene, {.seed = 1}, {});
    const FrameMade second = make_frame(scene, {.seed = 2}, {first.left, pose}),
                    alone = make_frame(scene, {.seed = 2}, {});
    EXPECT_EQ(second.film.resolve(Layer::Direct), alone.film.resolve(Layer::Direct));
    EXPECT_NE(second.film.resolve(Layer::Indirect), alone.film.resolve(Layer::Indirect));
}

// A worker that is killed in the middle of a frame: another goes on, from the film, to the same bits.
TEST(TemporalReprojection, GoesOnWithinAFrameToTheSameBits) {
    const Scene scene = make_builtin_scene("cornell-box");
    const FrameBefore before{make_frame(scene, {.seed = 1}, {}).left, std::make_shared<const PastPose>(scene)};
    const FrameMade whole = make_frame(scene, {.seed = 2, .passes = 3}, before);
    Shown shown(scene);
    shown.context.seed = 2;
    Film film(kSize, {});
    std::string state;
    for (uint32_t pass = 0; pass < 3; ++pass) {
        const std::unique_ptr<TemporalReprojection> method = paths_that_follow();
        method->follow(before);
        if (pass > 0) method->go_on_from(state);
        method->begin(shown.context, shown.stats);
        method->run_pass(pass, shown.stats, CancelToken{});
        method->resolve(film);
        state = method->state();
        if (pass == 2) {
            EXPECT_EQ(method->left_to_next(), whole.left);
        }
    }
    EXPECT_EQ(film.pixel_hash(), whole.film.pixel_hash());
    // Not on from the passes of a frame that followed another one.
    const std::unique_ptr<TemporalReprojection> other = paths_that_follow();
    EXPECT_THROW(other->go_on_from(state), Error);
}

TEST(TemporalReprojection, RefusesWhatIsNoHistoryOfItsSize) {
    const Scene scene = make_builtin_scene("cornell-box");
    const std::string left = make_frame(scene, {}, {}).left;
    EXPECT_THROW(make_frame(scene, {.size = {32, 32}}, {left, nullptr}), Error);
    EXPECT_THROW(make_frame(scene, {}, {"no history", nullptr}), Error);
    EXPECT_THROW(PathTracing({}).follow({left, nullptr}), Error);
}

TEST(TemporalReprojection, AFilmKeepsWhatIsLeftToTheNextFrame) {
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "left.film";
    const FrameMade made = make_frame(make_builtin_scene("cornell-box"), {}, {});
    const FilmIdentity identity{"a scene", "settings", "a device"};
    FilmFile::save(made.film, identity, "{}", path, "origin", "state", made.left);
    const SavedFilm loaded = FilmFile::load(path);
    EXPECT_TRUE(loaded.film == made.film);
    EXPECT_EQ(loaded.state, "state");
    EXPECT_EQ(loaded.left, made.left);
    EXPECT_EQ(FilmFile::examine(path).passes, 1u);
    EXPECT_EQ(FilmFile::load_left(path, {"a scene", "other settings", "a device"}), made.left);
    EXPECT_THROW(FilmFile::load_left(path, {"another scene", "settings", "a device"}), Error);
    EXPECT_THROW(FilmFile::load_left(path, identity, made.left.size() - 1), Error);
    FilmFile::save(made.film, identity, "{}", path, "origin", "state");
    EXPECT_EQ(FilmFile::load_left(path, identity), "");
    std::filesystem::remove(path);
}

}  // namespace
}  // namespace photond::temporal_reprojection_test
