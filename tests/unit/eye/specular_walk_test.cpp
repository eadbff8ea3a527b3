// The walk from the eye through what is specular: where it leaves visible points and with which weights, and that the
// light it finds on the way is the right one.

#include "renderer/eye/specular_walk.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <mutex>
#include <tuple>

#include "renderer/core/thread_local.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/mesh_builder.h"
#include "tests/support/path_render.h"
#include "tests/support/scene_parts.h"
#include "tests/support/statistics.h"
#include "tests/support/threads.h"

namespace photond::specular_walk_test {
namespace {

/// A visible point of either kind.
struct Left {
    uint32_t pixel, vertex;
    bool lambert;
    vec3 position;
    Rgb weight;  // Lambert: with the reflectance, else the throughput
    uint32_t scatterings;
    Rgb throughput;  // as the path tells
    auto operator<=>(const Left& other) const {
        return std::tie(pixel, vertex) <=> std::tie(other.pixel, other.vertex);
    }
    bool operator==(const Left&) const = default;
};

class Collector final : public VisiblePointSink {
public:
    Collector(const SpecularWalk& walk, std::vector<Left>& points, std::mutex& mutex)
        : walk_(walk), points_(points), mutex_(mutex) {}

    void take(std::span<const LambertVisiblePoint> lambert, std::span<const VisiblePoint> others) override {
        EXPECT_FALSE(lambert.empty() && others.empty());
        const std::lock_guard lock(mutex_);
        for (const LambertVisiblePoint& p : lambert)
            points_.push_back(
                {p.pixel, walk_.vertex(), true, p.position, p.weight, p.scatterings, walk_.path(p).throughput});
        for (const VisiblePoint& p : others) {
            EXPECT_EQ(p.vertex, walk_.vertex());
            EXPECT_TRUE(p.rough.scatters());
            points_.push_back(
                {p.pixel, p.vertex, false, p.surface.position, p.throughput, p.scatterings, p.throughput});
        }
    }

private:
    const SpecularWalk& walk_;
    std::vector<Left>& points_;
    std::mutex& mutex_;
};

/// What the defaults say, asked for vertex by vertex.
class DefaultGuide final : public WalkGuide {
public:
    WalkVertex decide(const Rgb&, float, bool) const override { return {}; }
    LightSeen light_seen(const vec3&, const vec3&, uint32_t) override { return LightSeen::Unknown; }
};

struct WalkOptions {
    Size2 size{40, 35};  // tiles cut at both edges
    uint32_t max_scatterings = UINT32_MAX;
    uint32_t passes = 1;
    uint64_t seed = 1;
    uint32_t tile_side = 16;
    float glossy_threshold = 0.05f;
    bool guided = false;  // by DefaultGuide
    LayerSet layers;
};

struct Walked {
    std::vector<Left> points;  // in the order of pixels and vertices; of the last pass
    Film film{{1, 1}, {}};
    Counts counts;
};

Walked walk(const Scene& scene, const WalkOptions& options) {
    MemoryBudget budget;
    Stats stats;
    const std::unique_ptr<Intersector> intersector = make_embree_intersector(scene, budget, stats);
    const RenderContext context{scene, intersector.get(),
                                View{find_camera(scene, ""), options.size, PixelFilter::Box, options.layers},
                                options.seed, budget};
    const EyeScene shared(context, SamplerKind::Sobol, options.max_scatterings);
    ThreadLocal<SpecularWalk> walks([&] { return SpecularWalk(options.tile_side); });
    PassImage image(options.size, options.layers);
    Walked result;
    result.film = Film(options.size, options.layers);
    std::mutex mutex;
    for (uint32_t pass = 0; pass < options.passes; ++pass) {
        result.points.clear();
        const PassSampler sampler(SamplerKind::Sobol, options.seed, RandomDomain::Camera, pass);
        parallel_over_tiles(options.size, options.tile_side, CancelToken{}, [&](const Tile& tile) {
            SpecularWalk& mine = walks.local();
            Collector collector(mine, result.points, mutex);
            DefaultGuide guide;
            Counts counts;
            EyeSeconds seconds;
            mine.trace_tile(shared, {options.glossy_threshold, options.guided ? &guide : nullptr},
                            {sampler, {&sampler, 1}}, tile, image, counts, seconds, CancelToken{}, collector);
            const std::lock_guard lock(mutex);
            result.counts += counts;
        });
        result.film.add_pass(image);
    }
    std::sort(result.points.begin(), result.points.end());
    return result;
}

// One metre of each surface from left to right, at z = 0, seen from z = 5 along -z in parallel; a wall of 0.25 behind
// them at z = -2, one of 0.8 behind the eye at z = 10.
enum Column : uint32_t { kMirror, kSheet, kGlossy, kRoughMetal, kLambert, kCoated, kSolid, kColumns };
constexpr uint32_t kPixelsPerColumn = 5;
constexpr Size2 kColumnsSize{kColumns * kPixelsPerColumn, 5};

Scene columns() {
    Scene scene;
    const auto quad = [](float x0, float x1, float half_height, float z) {
        return MeshBuilder()
            .quad({x0, -half_height, z}, {x1, -half_height, z}, {x1, half_height, z}, {x0, half_height, z})
            .build(0);
    };
    const auto add_column = [&](Column column, const Material& material) {
        test::add(scene, quad(float(column), float(column) + 1, 1, 0), material);
    };
    Material metal;
    metal.base_color = Rgb(0.9f);
    metal.roughness = 0;
    add_column(kMirror, metal);
    metal.roughness = 0.15f;  // alpha 0.0225: specular
    add_column(kGlossy, metal);
    metal.roughness = 0.5f;  // alpha 0.25: rough
    add_column(kRoughMetal, metal);
    Material sheet;
    sheet.base_color = Rgb(0.7f);
    sheet.metallic = sheet.roughness = sheet.specular = 0;
    sheet.transmission = 1;
    add_column(kSheet, sheet);
    add_column(kLambert, test::lambert(0.5f));
    Material coated;
    coated.base_color = Rgb(0.5f);
    coated.metallic = coated.roughness = 0;  // F0 = 0.04
    add_column(kCoated, coated);
    Material solid = sheet;
    solid.base_color = Rgb(1);
    solid.specular = 1;
    solid.solid = true;
    solid.attenuation_color = Rgb(0.5f);
    solid.attenuation_distance = 1;
    // A slab of a metre: what is reflected within it meets the wall behind the eye, what passes the one behind.
    test::add(scene, MeshBuilder().box({kSolid, -1, -1}, {kSolid + 1, 1, 0}).build(0), solid);
    test::add(scene, quad(-100, 100, 100, -2), test::lambert(0.25f));
    test::add(scene, quad(-100, 100, 100, 10), test::lambert(0.8f));
    Camera camera;
    camera.orthographic = true;
    camera.ymag = 0.5f;
    camera.position = {0.5f * float(kColumns), 0, 5};
    scene.cameras.push_back(camera);
    finish_scene(scene);
    return scene;
}

Column column_of(uint32_t pixel) { return Column(pixel % kColumnsSize.width / kPixelsPerColumn); }

/// Rays start a little off their surface, which the slab absorbs by.
void expect_near(const Rgb& value, float expected, const char* what) {
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(value[c], expected, 1e-4f * expected) << what;
}

TEST(SpecularWalk, LeavesAPointWhereARoughPartIsMet) {
    WalkOptions options;
    options.size = kColumnsSize;
    const Walked walked = walk(columns(), options);
    std::vector<uint32_t> lambert(kColumns), others(kColumns);
    for (const Left& p : walked.points) {
        const Column column = column_of(p.pixel);
        ++(p.lambert ? lambert : others)[column];
        switch (column) {
            case kMirror:
                EXPECT_EQ(p.vertex, 1u);
                EXPECT_NEAR(p.position.z, 10, 1e-4f);
                EXPECT_EQ(p.scatterings, 0u) << "a mirror is the camera's";
                expect_near(p.weight, 0.9f * 0.8f, "mirror");
                break;
            case kSheet:
                EXPECT_EQ(p.vertex, 1u);
                EXPECT_NEAR(p.position.z, -2, 1e-4f);
                EXPECT_EQ(p.scatterings, 0u);
                expect_near(p.weight, 0.7f * 0.25f, "sheet");
                break;
            case kGlossy:
                EXPECT_EQ(p.vertex, 1u);
                EXPECT_NEAR(p.position.z, 10, 1e-4f);
                EXPECT_EQ(p.scatterings, 1u) << "a glossy lobe scatters";
                EXPECT_GT(p.weight.x, 0.8f * 0.8f) << "what single scattering and Fresnel leave of 0.9";
                EXPECT_LT(p.weight.x, 0.9f * 0.8f * 1.001f);
                break;
            case kRoughMetal:
                EXPECT_EQ(p.vertex, 0u);
                EXPECT_EQ(p.scatterings, 0u);
                EXPECT_EQ(p.weight, Rgb(1)) << "the lobe itself is left to wait";
                break;
            case kLambert:
                EXPECT_EQ(p.vertex, 0u);
                EXPECT_EQ(p.scatterings, 0u);
                EXPECT_EQ(p.throughput, Rgb(1));
                EXPECT_EQ(p.weight, Rgb(0.5f));
                break;
            case kCoated:  // the diffuse lobe waits, the coat's reflection is followed
                EXPECT_EQ(p.vertex, p.lambert ? 1u : 0u);
                EXPECT_EQ(p.scatterings, 0u);
                expect_near(p.weight, p.lambert ? 0.04f * 0.8f : 1.0f, "coat");
                break;
            default:  // the slab: in front of it, behind it or, after reflections within, either
                EXPECT_TRUE(p.lambert);
                EXPECT_EQ(p.scatterings, 0u);
                const bool behind = p.position.z < 0;
                EXPECT_NEAR(p.position.z, behind ? -2 : 10, 1e-4f);
                // Each metre within leaves a half; interfaces are chosen in proportion to what they reflect. After the
                // fourth vertex Russian roulette makes up for the paths it ends.
                if (p.vertex > 3) break;
                const uint32_t metres = p.vertex - 1;
                expect_near(p.weight, std::ldexp(behind ? 0.25f : 0.8f, -int(metres)), "slab");
        }
    }
    const uint32_t pixels = kPixelsPerColumn * kColumnsSize.height;
    for (const Column column : {kMirror, kSheet, kLambert}) {
        EXPECT_EQ(lambert[column], pixels) << column;
        EXPECT_EQ(others[column], 0u) << column;
    }
    EXPECT_EQ(lambert[kGlossy], pixels);
    EXPECT_EQ(others[kGlossy], 0u) << "alpha is below the threshold: nothing waits at the metal";
    EXPECT_EQ(others[kRoughMetal], pixels);
    EXPECT_EQ(lambert[kRoughMetal], 0u) << "nothing specular to follow";
    EXPECT_EQ(others[kCoated], pixels);
    EXPECT_EQ(lambert[kCoated], pixels);
    EXPECT_EQ(others[kSolid], 0u);
    EXPECT_GT(lambert[kSolid], pixels * 3 / 4);
}

TEST(SpecularWalk, ThresholdAndScatteringsDecideWhatIsLeft) {
    const Scene scene = columns();
    WalkOptions options;
    options.size = kColumnsSize;
    const auto count = [&](Column column) {
        const Walked walked = walk(scene, options);
        return std::count_if(walked.points.begin(), walked.points.end(),
                             [&](const Left& p) { return column_of(p.pixel) == column; });
    };
    const ptrdiff_t pixels = kPixelsPerColumn * kColumnsSize.height;
    options.max_scatterings = 2;  // what waits scatters, and so did its light once
    EXPECT_EQ(count(kLambert), pixels);
    EXPECT_EQ(count(kGlossy), 0) << "the wall seen in it would be the second of three";
    options.max_scatterings = 3;
    EXPECT_EQ(count(kGlossy), pixels);
    options.max_scatterings = 1;
    EXPECT_EQ(count(kLambert), 0);
    EXPECT_EQ(count(kMirror), 0);
    options.max_scatterings = 2;
    options.glossy_threshold = 0.3f;  // all the metals are specular
    EXPECT_EQ(count(kRoughMetal), 0);
    options.glossy_threshold = 0;  // delta lobes alone are
    EXPECT_EQ(count(kGlossy), pixels);
    EXPECT_EQ(count(kMirror), pixels);
}

TEST(SpecularWalk, StoresTheFirstHitOfEveryKindOfSurface) {
    WalkOptions options;
    options.size = kColumnsSize;
    options.layers = LayerSet::all();
    options.layers.remove(Layer::StandardError);
    const Film film = walk(columns(), options).film;
    const std::vector<float> depth = film.resolve(Layer::Depth), normal = film.resolve(Layer::Normal),
                             geometric_normal = film.resolve(Layer::GeometricNormal),
                             position = film.resolve(Layer::Position), albedo = film.resolve(Layer::Albedo);
    for (uint32_t pixel = 0; pixel < kColumnsSize.pixels(); ++pixel) {
        EXPECT_NEAR(depth[pixel], 5, 1e-5f);
        EXPECT_EQ(normal[3 * pixel + 2], 1.0f);
        EXPECT_EQ(geometric_normal[3 * pixel + 2], 1.0f);
        EXPECT_NEAR(position[3 * pixel], float(pixel % kColumnsSize.width) / kPixelsPerColumn + 0.1f, 0.1001f);
        if (column_of(pixel) == kLambert) {
            EXPECT_EQ(albedo[3 * pixel], 0.5f);
        }
        if (column_of(pixel) == kMirror) {
            EXPECT_EQ(albedo[3 * pixel], 0.8f) << "of the wall seen in it";
        }
    }
}

TEST(SpecularWalk, IsTheSameForAnyNumberOfThreadsAndSideOfTiles) {
    for (const char* name : {"cornell-box-spot", "cornell-box-glass", "cornell-box-glossy"}) {
        const Scene scene = make_builtin_scene(name);
        WalkOptions options;
        const auto on = [&](int threads) { return test::on_threads(threads, [&] { return walk(scene, options); }); };
        const Walked one = on(1);
        EXPECT_FALSE(one.points.empty());
        for (const uint32_t tile_side : {16u, 32u}) {
            options.tile_side = tile_side;
            const Walked many = on(8);
            EXPECT_EQ(one.film, many.film) << name << " " << tile_side;
            EXPECT_EQ(one.points, many.points) << name << " " << tile_side;
            EXPECT_EQ(one.counts.shadow_rays, many.counts.shadow_rays) << name << " " << tile_side;
        }
    }
}

// A scene's only point or spot light is seen from groups of points at once; with a guide, from each of them by the
// light sampler.
TEST(SpecularWalk, AnOnlyLightIsThatOfTheLightSampler) {
    PunctualLight point;
    point.kind = PunctualLight::Kind::Point;
    point.intensity = Rgb(3, 2, 1);
    point.position = vec3(0.3f, 4, 0.2f);
    PunctualLight near_point = point;
    near_point.range_m = 3;
    const PunctualLight spot = make_builtin_scene("cornell-box-spot").punctual_lights.at(0);
    PunctualLight near_spot = spot;
    near_spot.range_m = 5;
    for (const PunctualLight& light : {point, near_point, spot, near_spot}) {
        Scene scene = make_builtin_scene("cornell-box-spot");
        scene.punctual_lights = {light};
        finish_scene(scene);
        WalkOptions options;
        options.size = {64, 64};
        const Walked alone = walk(scene, options);
        options.guided = true;
        const Walked guided = walk(scene, options);
        const std::vector<float> a = alone.film.resolve(Layer::Direct), b = guided.film.resolve(Layer::Direct);
        ASSERT_GT(test::mean_of(b), 0);
        // Rounding may let a shadow's border fall on the other side of a sample.
        size_t unlike = 0;
        for (size_t i = 0; i < a.size(); ++i) unlike += std::abs(a[i] - b[i]) > 1e-4f * std::max(a[i], b[i]) + 1e-7f;
        EXPECT_LE(unlike, a.size() / 1000);
        EXPECT_EQ(alone.points, guided.points);
    }
}

// Direct light of a point, a spot and an area light, on Lambert, glossy and transparent surfaces: path tracing's in the
// mean. Camera rays are the same, so that part of the noise is common.
TEST(SpecularWalk, DirectLightIsThatOfPathTracing) {
    constexpr double kFalseAlarm = 1e-6, kMustDetect = 0.001;
    Scene bulb = make_builtin_scene("cornell-box-spot");
    bulb.punctual_lights[0].kind = PunctualLight::Kind::Point;
    finish_scene(bulb);
    const Scene scenes[] = {bulb, make_builtin_scene("cornell-box-spot"), make_builtin_scene("cornell-box"),
                            make_builtin_scene("cornell-box-glossy")};
    for (const Scene& scene : scenes) {
        std::vector<double> differences;
        for (uint64_t seed = 1; seed <= 32; ++seed) {
            WalkOptions options;
            options.max_scatterings = 1;
            options.passes = 16;
            options.seed = seed;
            test::RenderSettings traced;
            traced.size = options.size;
            traced.passes = options.passes;
            traced.params.indirect_bounces = 0;
            traced.seed = seed;
            differences.push_back(test::mean_of(walk(scene, options).film.resolve(Layer::Direct)) /
                                      test::mean_of(test::render(scene, traced).resolve(Layer::Direct)) -
                                  1);
        }
        const test::Interval interval = test::mean_interval(differences, kFalseAlarm, std::size(scenes));
        // Where both find the very same light only rounding is between them.
        EXPECT_LE(std::abs(interval.mean), interval.half_width + 1e-5) << scene.name;
        EXPECT_LE(interval.half_width, kMustDetect) << scene.name << ": too noisy to notice a defect";
        std::printf("%s: relative difference %.5f +- %.5f\n", scene.name.c_str(), interval.mean, interval.half_width);
    }
}

}  // namespace
}  // namespace photond::specular_walk_test
