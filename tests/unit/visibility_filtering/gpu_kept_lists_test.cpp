// Rays that go the same ways in all frames, and lists of frames before: of the same places, the same bits whoever
// renders a frame, and of the rays that they stand for.

#include <gtest/gtest.h>

#include <array>
#include <map>
#include <set>

#include "protocol/error.h"
#include "renderer/methods/visibility_filtering/visibility_filtering_gpu.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/camera_projection.h"
#include "renderer/scene/past_pose.h"
#include "renderer/scene/pose.h"
#include "tests/support/aged_frames.h"
#include "tests/support/open_scene.h"

namespace photond::gpu_kept_lists_test {
namespace {

using test::FrameOf;
using Settings = test::RenderSettingsOf<VisibilityFilteringGpu>;

Settings settings_of(uint32_t kept_lists) {
    Settings settings;
    settings.size = {64, 48};
    settings.params.proxies = 2000;
    settings.params.voxels = 6;
    settings.params.rays = 16;
    settings.params.kept_lists = kept_lists;
    return settings;
}

FrameOf frame_of(const test::SceneOnDevice& where, const Settings& settings, const std::string& before = {},
                 const std::string& state = {}, std::shared_ptr<const PastPose> pose = nullptr) {
    MemoryBudget budget;
    const RenderContext context{where.scene, &where.intersector, test::view_of(where.scene, settings), settings.seed,
                                budget,      &where.device_scene};
    VisibilityFilteringGpu method(settings.params);
    return test::frame_after(method, context, settings, before, state, std::move(pose));
}

LeftLists lists_of(const FrameOf& frame, const Settings& settings) {
    return LeftLists::decode(frame.left, KeptLayout(settings.size, settings.params));
}

Scene box_from(float moved_m) {
    Scene scene = make_builtin_scene("cornell-box");
    scene.cameras.front().position.x += moved_m;
    return scene;
}

/// A cell of the world, and the plane's normal.
using Place = std::array<int, 6>;
Place place_of(const gpu::KeptPoint& point, float cell_m) {
    const vec3 cell = glm::floor(point.position / cell_m + 0.381966f * point.normal);
    const vec3 normal = glm::round(1000.0f * point.normal);
    return {int(cell.x), int(cell.y), int(cell.z), int(normal.x), int(normal.y), int(normal.z)};
}

struct Ways {
    size_t same = 0, all = 0;
    double share() const { return double(same) / double(all); }
};
/// Of rays of the same numbers, from the same places of two frames, those that go the same way; rays that meet what is
/// near tell little of where they went.
Ways ways_in_common(const LeftLists& a, const LeftLists& b, float cell_m) {
    constexpr float kNear_m = 0.8f, kSame = 0.995f;  // a cosine: 5.7 degrees, for voxels are met, not points
    std::map<Place, size_t> first;
    for (size_t i = 0; i < a.points.size(); ++i)
        if (a.points[i].lists > 0) first.emplace(place_of(a.points[i], cell_m), i);
    const size_t rays = a.layout.rays;
    Ways ways;
    for (size_t j = 0; j < b.points.size(); ++j) {
        const auto found = first.find(place_of(b.points[j], cell_m));
        if (b.points[j].lists == 0 || found == first.end()) continue;
        const size_t i = found->second;
        for (size_t ray = 0; ray < rays; ++ray) {
            const vec3 u = a.places[i * a.layout.most_lists * rays + ray] - a.points[i].position,
                       v = b.places[j * b.layout.most_lists * rays + ray] - b.points[j].position;
            if (!(glm::length(u) < 1e6f && glm::length(v) < 1e6f) || glm::length(u) < kNear_m ||
                glm::length(v) < kNear_m)
                continue;
            ++ways.all, ways.same += glm::dot(glm::normalize(u), glm::normalize(v)) > kSame;
        }
    }
    EXPECT_GT(ways.all, 300u);
    return ways;
}

TEST(GpuKeptLists, RaysOfTheWorldGoTheSameWaysWhateverCameraAndSeed) {
    const Scene here = box_from(0), there = box_from(0.11f);
    const vec3 size_m = here.bounds.diagonal();
    const float longest_m = std::max({size_m.x, size_m.y, size_m.z});
    for (const bool world : {true, false}) {
        Settings settings = settings_of(1);
        settings.params.visibility = ProxyVisibility::Svo;
        settings.params.voxel_resolution = 64;
        settings.params.subsampling = settings.params.march_subsampling = 1;
        settings.size = {32, 24};
        settings.params.world_rays = world;
        const float cell_m = std::exp2(std::round(std::log2(longest_m / float(4 * settings.params.voxels))));
        const LeftLists a = lists_of(frame_of(test::SceneOnDevice(here), settings), settings);
        settings.seed = 77;
        const LeftLists b = lists_of(frame_of(test::SceneOnDevice(there), settings), settings);
        const Ways ways = ways_in_common(a, b, cell_m);
        std::printf("rays that go the same way: %.4f, tied to the %s\n", ways.share(), world ? "world" : "pixel");
        if (world)
            EXPECT_EQ(ways.same, ways.all);
        else
            EXPECT_LT(ways.share(), 0.05);
        // In another pass, and where lists are kept in the next frame, they go elsewhere.
        if (!world) continue;
        settings.first_pass = 1;
        const test::SceneOnDevice again(there);
        const FrameOf other_pass = frame_of(again, settings);
        EXPECT_LT(ways_in_common(b, lists_of(other_pass, settings), cell_m).share(), 0.05);
        const LeftLists next = lists_of(frame_of(again, settings, other_pass.left), settings);
        EXPECT_LT(ways_in_common(lists_of(other_pass, settings), next, cell_m).share(), 0.05);
    }
}

constexpr uint32_t kColumns = 4, kRows = 3;
/// Mean indirect light of blocks of pixels, and of the image, over independent images.
struct BlockMeans {
    std::vector<test::RunningMean> of = std::vector<test::RunningMean>(kColumns * kRows + 1);

    void add(const std::vector<double>& blocks) {
        for (size_t i = 0; i < blocks.size(); ++i) of[i].add(blocks[i]);
    }
    static std::vector<double> blocks_of(const Film& film) {
        const std::vector<float> light = film.resolve(Layer::Indirect);
        const Size2 size = film.size();
        std::vector<double> sums(kColumns * kRows);
        for (uint32_t y = 0; y < size.height; ++y)
            for (uint32_t x = 0; x < size.width; ++x)
                for (uint32_t c = 0; c < 3; ++c)
                    sums[y * kRows / size.height * kColumns + x * kColumns / size.width] +=
                        double{light[3 * (size_t{y} * size.width + x) + c]} * kColumns * kRows / double(light.size());
        sums.push_back(test::mean_of(light));
        return sums;
    }
    /// The greatest mean over what may be by chance where all are 0, 1e-6 for all blocks: Student's t.
    double apart_from_nothing() const {
        double most = 0;
        for (const test::RunningMean& block : of) {
            const double t = test::two_sided_t(test::share_of_false_alarm(1e-6, of.size()), double(block.count()) - 1);
            most = std::max(most, std::fabs(block.mean()) / (t * block.standard_error()));
        }
        return most;
    }
    double image() const { return of.back().mean(); }
};

/// The greatest difference of a block's means over what may be by chance, 1e-6 for all blocks: Welch's t, with the
/// fewer degrees of freedom of the two, which is the wider.
double apart(const BlockMeans& a, const BlockMeans& b) {
    double most = 0;
    for (size_t i = 0; i < a.of.size(); ++i) {
        const auto degrees = static_cast<double>(std::min(a.of[i].count(), b.of[i].count()) - 1);
        const double t = test::two_sided_t(test::share_of_false_alarm(1e-6, a.of.size()), degrees);
        const double doubt = t * std::hypot(a.of[i].standard_error(), b.of[i].standard_error());
        most = std::max(most, std::fabs(a.of[i].mean() - b.of[i].mean()) / doubt);
    }
    return most;
}

// By blocks of pixels and by the whole image, of 64 passes each: what ties the rays brings no light and takes none.
TEST(GpuKeptLists, RaysOfTheWorldBringTheSameLight) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    Settings settings = settings_of(0);
    settings.size = {32, 24};
    settings.passes = 64;
    settings.params.sampler = SamplerKind::Random;
    settings.params.rays = 32;
    BlockMeans world, pixel;
    for (const bool is_world : {true, false}) {
        settings.params.world_rays = is_world;
        settings.seed = is_world ? 5 : 6;
        test::run_passes(where, settings, [&](VisibilityFilteringGpu& method, uint32_t pass) {
            Film film(settings.size, settings.layers, pass);
            method.resolve(film);
            (is_world ? world : pixel).add(BlockMeans::blocks_of(film));
        });
    }
    std::printf("light of rays of the world over that of rays of pixels: %.4f\n", world.image() / pixel.image());
    EXPECT_LT(apart(world, pixel), 1);
    EXPECT_LT(world.of.back().standard_error() + pixel.of.back().standard_error(), 0.03 * pixel.image())
        << "too noisy to notice a defect";
}

TEST(GpuKeptLists, AreThoseOfTheSamePlaces) {
    const Scene here = box_from(0), there = box_from(0.4f);
    const Settings settings = settings_of(2);
    const CameraRays seen_by(here.cameras.front(), settings.size);
    const FrameOf first = frame_of(test::SceneOnDevice(here), settings);
    const FrameOf second = frame_of(test::SceneOnDevice(there), settings, first.left);
    const LeftLists a = lists_of(first, settings), b = lists_of(second, settings);
    const size_t rays = a.layout.rays, of_point = rays * a.layout.most_lists;
    const auto list = [&](const LeftLists& left, size_t point, size_t which) {
        std::vector<float> values;
        for (size_t ray = 0; ray < rays; ++ray) {
            const vec3& place = left.places[point * of_point + which * rays + ray];
            values.insert(values.end(), {place.x, place.y, place.z});
        }
        return values;
    };
    std::map<std::vector<float>, size_t> of_first;
    for (size_t i = 0; i < a.points.size(); ++i)
        if (a.points[i].lists > 0) of_first[list(a, i, 0)] = i;
    size_t lit = 0, kept = 0;
    for (size_t j = 0; j < b.points.size(); ++j) {
        const gpu::KeptPoint& point = b.points[j];
        if (point.lists == 0) continue;
        ++lit;
        if (point.lists < 2) continue;
        ++kept;
        const auto found = of_first.find(list(b, j, 1));
        ASSERT_NE(found, of_first.end()) << "it is nobody's list";
        const gpu::KeptPoint& was = a.points[found->second];
        EXPECT_EQ(point.instance, was.instance);
        EXPECT_GE(glm::dot(point.normal, was.normal), settings.params.filter_normal);
        EXPECT_LT(std::fabs(glm::dot(point.position - was.position, point.normal)), 0.05f);
        // In the image in which both lists were looked for, within the four about the place, or what is seen there.
        const vec2 apart = *project(seen_by, point.position) - *project(seen_by, was.position);
        EXPECT_LT(std::max(std::fabs(apart.x), std::fabs(apart.y)), 2 * float(settings.params.march_subsampling));
    }
    std::printf("%zu of %zu points take over a list\n", kept, lit);
    EXPECT_GT(kept, lit / 2);
    EXPECT_LT(kept, lit) << "some places were not seen";
}

// Frames of a still scene by the same numbers: once as many are there as are kept, own rays and those of the frames
// before are the same set, in whatever turn.
TEST(GpuKeptLists, StandStillWhereRaysAreTiedToTheWorld) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    Settings settings = settings_of(2);
    settings.params.world_rays = true;
    settings.params.lists = ListKind::Bits;
    std::vector<std::string> hashes;
    std::vector<double> light;
    std::string left;
    for (int frame = 0; frame < 5; ++frame) {
        const FrameOf now = frame_of(where, settings, left);
        left = now.left;
        hashes.push_back(now.film.pixel_hash());
        light.push_back(test::mean_of_layer(now.film, Layer::Indirect));
    }
    EXPECT_GT(light[1], light[0]) << "more rays, more voxels";
    EXPECT_GT(light[2], light[1]);
    EXPECT_EQ(hashes[3], hashes[2]);
    EXPECT_EQ(hashes[4], hashes[2]);
}

/// Frames of a scene in which all moves.
struct MovingBox {
    explicit MovingBox(uint32_t frames) {
        for (uint32_t i = 0; i < frames; ++i) {
            scenes.push_back(std::make_unique<Scene>(make_builtin_scene("moving/cornell-box")));
            pose_scene(*scenes.back(), {0, 0.25 + 0.25 * i});
            // Flat, so that the pipelines are those of the box that stands still.
            for (Mesh& mesh : scenes.back()->meshes) mesh.normals.clear();
            on_device.push_back(std::make_unique<test::SceneOnDevice>(*scenes.back()));
        }
    }
    std::vector<std::unique_ptr<Scene>> scenes;
    std::vector<std::unique_ptr<test::SceneOnDevice>> on_device;
};

/// Of the rays of lists in that place of their points, how many stop beyond what stands in their way in the scene.
double share_beyond(const LeftLists& left, size_t list, const Scene& scene) {
    MemoryBudget budget;
    Stats stats;
    const std::unique_ptr<Intersector> intersector = make_embree_intersector(scene, budget, stats);
    constexpr float kOff_m = 1e-3f, kShort_m = 0.4f;  // more than a disc's radius
    size_t beyond = 0, all = 0;
    for (size_t i = 0; i < left.points.size(); ++i) {
        if (left.points[i].lists <= list) continue;
        const vec3 from = left.points[i].position + kOff_m * left.points[i].normal;
        for (size_t ray = 0; ray < left.layout.rays; ++ray) {
            const vec3 way = left.places[(i * left.layout.most_lists + list) * left.layout.rays + ray] - from;
            const float length_m = glm::length(way);
            if (!(length_m > 2 * kShort_m) || length_m > 1e6f) continue;
            ++all, beyond += intersector->occluded({from, way / length_m, length_m - kShort_m});
        }
    }
    EXPECT_GT(all, 1000u);
    return double(beyond) / double(all);
}

// What stands in their way now stops rays that are kept as it stops rays of the frame, where it is known what has
// moved.
TEST(GpuKeptLists, AreShotAgainWhereThingsMove) {
    const MovingBox box(2);
    Settings settings = settings_of(2);
    settings.params.proxies = 6000;
    settings.params.subsampling = settings.params.march_subsampling = 2;
    const FrameOf first = frame_of(*box.on_device[0], settings);
    const auto share = [&](size_t list, size_t pose) {
        const FrameOf second =
            frame_of(*box.on_device[1], settings, first.left, {}, std::make_shared<const PastPose>(*box.scenes[pose]));
        return share_beyond(lists_of(second, settings), list, *box.scenes[1]);
    };
    const double own = share(0, 0), kept = share(1, 0), stale = share(1, 1);
    std::printf("rays that stop beyond what stands in their way: %.4f, kept %.4f, %.4f where nothing has moved\n", own,
                kept, stale);
    EXPECT_LT(kept, 1.5 * own + 0.005);
    EXPECT_GT(stale, 2 * kept) << "it would not be noticed";
}

// Though light and what stands in its way have moved: with the same numbers, so that the difference of two images has
// the rays' noise alone.
TEST(GpuKeptLists, TellWhatRaysOfTheFrameDo) {
    constexpr uint32_t kSeeds = 10;
    const MovingBox box(2);
    const auto last_frame = [&](Settings settings, uint64_t seed, const FrameOf* first) {
        settings.seed = 2 * seed + 1;
        return frame_of(*box.on_device[1], settings, first ? first->left : "", {},
                        std::make_shared<const PastPose>(*box.scenes[0]))
            .film;
    };
    Settings settings = settings_of(1), twice = settings_of(0);
    for (Settings* each : {&settings, &twice}) {
        each->size = {48, 36};
        each->params.proxies = 4000;
    }
    twice.params.rays = 2 * settings.params.rays;
    BlockMeans shot, differences;
    for (uint64_t seed = 0; seed < kSeeds; ++seed) {
        settings.seed = 2 * seed;
        const FrameOf first = frame_of(*box.on_device[0], settings);
        const std::vector<double> by_shot = BlockMeans::blocks_of(last_frame(twice, seed, nullptr));
        std::vector<double> by_kept = BlockMeans::blocks_of(last_frame(settings, seed, &first));
        shot.add(by_shot);
        for (size_t i = 0; i < by_kept.size(); ++i) by_kept[i] -= by_shot[i];
        differences.add(by_kept);
    }
    const test::RunningMean& of_image = differences.of.back();
    const double doubt = test::two_sided_t(1e-6, kSeeds - 1) * of_image.standard_error() / shot.image();
    std::printf("light of kept lists over that of as many rays: %.3f, %.3f in doubt; a block's by %.2f of its doubt\n",
                1 + of_image.mean() / shot.image(), doubt, differences.apart_from_nothing());
    EXPECT_LT(differences.apart_from_nothing(), 1);
    EXPECT_LT(doubt, 0.2) << "too noisy to notice a defect";
}

TEST(GpuKeptLists, FramesAreTheSameWhoeverRendersThem) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    Settings settings = settings_of(2);
    settings.size = {32, 24};
    settings.passes = 3;
    const FrameOf first = frame_of(where, settings);
    settings.seed = 2;
    const FrameOf second = frame_of(where, settings, first.left);
    EXPECT_NE(second.film.pixel_hash(), frame_of(where, settings).film.pixel_hash()) << "it follows";
    const FrameOf again = frame_of(where, settings, first.left);
    EXPECT_EQ(again.film.pixel_hash(), second.film.pixel_hash());
    EXPECT_EQ(again.left, second.left);
    // Another worker goes on with the last pass.
    Settings part = settings;
    part.passes = 2;
    FrameOf begun = frame_of(where, part, first.left);
    part.first_pass = 2, part.passes = 1;
    const FrameOf ended = frame_of(where, part, first.left, begun.state);
    begun.film.merge(ended.film);
    EXPECT_EQ(begun.film.pixel_hash(), second.film.pixel_hash());
    EXPECT_EQ(ended.left, second.left);
    EXPECT_THROW(frame_of(where, part, second.left, begun.state), Error);
}

TEST(GpuKeptLists, RefuseWhatIsNotTheirs) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    Settings settings = settings_of(1);
    settings.size = {16, 12};
    const FrameOf frame = frame_of(where, settings);
    const auto expect_conflict = [&](const Settings& other, const std::string& left, const char* what) {
        try {
            frame_of(where, other, left);
            ADD_FAILURE() << what;
        } catch (const Error& error) {
            EXPECT_EQ(error.code, ErrorCode::Conflict) << what;
        }
    };
    Settings other = settings;
    other.size = {16, 16};
    expect_conflict(other, frame.left, "another image");
    other = settings, other.params.rays = 8;
    expect_conflict(other, frame.left, "other rays");
    other = settings, other.params.kept_lists = 2;
    expect_conflict(other, frame.left, "more lists");
    other = settings, other.params.kept_lists = 0;
    expect_conflict(other, frame.left, "its frames stand alone");
    expect_conflict(settings, frame.left + "x", "too long");
    expect_conflict(settings, "no lists", "nothing of the kind");
    LeftLists wrong = lists_of(frame, settings);
    wrong.points.front().lists = 9;
    expect_conflict(settings, wrong.encode(), "more lists than there are");
    EXPECT_NO_THROW(settings.params.check());
    settings.params.visibility = ProxyVisibility::Rays;
    EXPECT_THROW(settings.params.check(), Error) << "there are no lists";
}

}  // namespace
}  // namespace photond::gpu_kept_lists_test
