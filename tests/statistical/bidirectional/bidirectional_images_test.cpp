// Bidirectional path tracing makes the image that path tracing makes, and vertex connection and merging where its
// radius is small: block by block of pixels, with lights and cameras of every kind, gloss, rough glass, sheets, leaning
// normals, and bounces cut short; and where blocks of pixels have techniques of their own.

#include <gtest/gtest.h>

#include <cstdio>

#include "renderer/bidirectional/eye_paths.h"
#include "renderer/core/thread_local.h"
#include "renderer/methods/bidirectional_path_tracing/bidirectional_path_tracing.h"
#include "renderer/methods/vertex_connection_and_merging/vertex_connection_and_merging.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/lit_rooms.h"
#include "tests/support/path_render.h"
#include "tests/support/statistics.h"

namespace photond::bidirectional_images_test {
namespace {

constexpr Size2 kSize{24, 24};
constexpr uint32_t kBlock = 8;
constexpr double kFalseAlarm = 1e-7;  // of a scene's blocks together

/// A room that is open to the front, with three objects of those materials under a lamp.
Scene room(const std::vector<Material>& materials) {
    Scene scene;
    MeshBuilder walls;
    walls.quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2});
    walls.quad({-2, 0, -2}, {2, 0, -2}, {2, 3, -2}, {-2, 3, -2});
    walls.quad({-2, 0, 2}, {-2, 0, -2}, {-2, 3, -2}, {-2, 3, 2});
    test::add(scene, walls.build(0), test::lambert(0.6f));
    float x = -1.1f;
    for (const Material& material : materials) {
        // Coarse and smooth: the shading normals lean.
        test::add(scene, MeshBuilder().sphere({x, 0.7f, 0}, 0.5f, 12).build(0), material);
        x += 1.1f;
    }
    scene.cameras.push_back(look_at_camera({0, 1.6f, 5}, {0, 1, 0}, {0, 1, 0}, 0.7f));
    return scene;
}

/// The same room, and in it two boards that face each other like the covers of a book hardly opened: towards its spine
/// vertices of both nearly touch, and what a connection carries before it is weighed knows no bound.
Scene nearly_touching() {
    Scene scene = room({});
    MeshBuilder boards;
    for (const float side : {-1.0f, 1.0f}) {
        const vec3 spine(0, 0.4f, -0.9f), opening(side * 0.06f, 0.4f, 0.9f), up(0, 1.6f, 0);
        if (side < 0)
            boards.quad(spine, opening, opening + up, spine + up);
        else
            boards.quad(opening, spine, spine + up, opening + up);
    }
    test::add(scene, boards.build(0), test::lambert(0.8f));
    scene.cameras[0] = look_at_camera({0, 1.2f, 2.6f}, {0, 1.2f, -0.9f}, {0, 1, 0}, 0.25f);
    return scene;
}

Material rough(float metallic, float roughness, float transmission, bool solid) {
    Material material;
    material.base_color = {0.8f, 0.7f, 0.6f};
    material.metallic = metallic, material.roughness = roughness;
    material.transmission = transmission, material.solid = solid;
    if (solid) material.attenuation_color = {0.5f, 0.8f, 0.6f}, material.attenuation_distance = 0.7f;
    return material;
}

Scene gloss() { return room({rough(0, 0.5f, 0, false), rough(1, 0.45f, 0, false), rough(0, 0.4f, 0.7f, false)}); }
Scene rough_glass() { return room({rough(0, 0.5f, 1, true), rough(0.5f, 0.6f, 0.6f, true), test::lambert(0.5f)}); }

Scene with_lamp(Scene scene) {
    Material lamp = test::lambert(0);
    lamp.emission = Rgb(6, 5, 4);
    test::add(
        scene,
        MeshBuilder().quad({-0.6f, 2.9f, -0.6f}, {0.6f, 2.9f, -0.6f}, {0.6f, 2.9f, 0.6f}, {-0.6f, 2.9f, 0.6f}).build(0),
        lamp);
    finish_scene(scene);
    return scene;
}
Scene with_punctual_lights(Scene scene) {
    scene.punctual_lights = {test::point_light({0.4f, 2.2f, 0.8f}),
                             test::spot_light({1.6f, 2.6f, 1.7f}, {-1, -1.1f, -1}, 50), test::sun({0.4f, -1, -0.8f})};
    scene.punctual_lights[0].intensity = Rgb(3);
    scene.punctual_lights[0].range_m = 3;
    scene.punctual_lights[1].intensity = Rgb(5, 4, 3);
    finish_scene(scene);
    return scene;
}
Scene with_sky(Scene scene) {
    Environment sky;
    sky.map = {{8, 4}, std::vector<Rgb>(32, Rgb(0.3f, 0.4f, 0.6f))};
    sky.map.radiance[10] = Rgb(12, 10, 7);
    scene.environment = std::move(sky);
    finish_scene(scene);
    return scene;
}
Scene with_all_lights(Scene scene) { return with_sky(with_punctual_lights(with_lamp(std::move(scene)))); }
Scene orthographic(Scene scene) {
    scene.cameras[0].orthographic = true;
    scene.cameras[0].ymag = 1.7f;
    return scene;
}
Scene with_lens(Scene scene) {
    scene.cameras[0].aperture_radius_m = 0.15f;
    scene.cameras[0].focus_distance_m = 4;
    return scene;
}

/// The lamp is placed by a transform that mirrors, so that its front is where its corners run clockwise.
Scene mirrored_lamp(Scene scene) {
    Instance& lamp = scene.instances.back();
    lamp.identity = false;
    lamp.to_world = mat4x3(vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1), vec3(0.3f, 0, 0));
    lamp.normal_to_world = mat3(vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1));
    lamp.flips_orientation = true;
    finish_scene(scene);
    return scene;
}
Scene from_afar(Scene scene) {
    scene.cameras[0] = look_at_camera({0, 3, 25}, {0, 1, 0}, {0, 1, 0}, 0.14f);
    return scene;
}

constexpr uint32_t kColumns = kSize.width / kBlock;
constexpr size_t kBlocks = size_t{kColumns} * (kSize.height / kBlock);

/// The sums of a pass's blocks, to their means.
void add_pass(const Film& film, std::vector<test::RunningMean>& means) {
    EXPECT_EQ(film.nan_count() + film.infinity_count(), 0u);
    // Without the lamps as they are seen, whose edges pixels cut.
    std::vector<float> light = film.resolve(Layer::Direct);
    const std::vector<float> indirect = film.resolve(Layer::Indirect);
    for (size_t i = 0; i < light.size(); ++i) light[i] += indirect[i];
    std::vector<double> sums(means.size());
    for (uint32_t y = 0; y < kSize.height; ++y)
        for (uint32_t x = 0; x < kSize.width; ++x)
            for (uint32_t c = 0; c < 3; ++c)
                sums[(y / kBlock) * kColumns + x / kBlock] += double{light[3 * (y * kSize.width + x) + c]};
    for (size_t i = 0; i < sums.size(); ++i) means[i].add(sums[i]);
}

/// The means of a method's blocks over its first passes, of which more can be added.
template <class M>
class GrowingMeans {
public:
    /// `settings.passes` is the largest number of passes. The scene is borrowed.
    GrowingMeans(const Scene& scene, test::RenderSettingsOf<M> settings)
        : scene_(scene), settings_(settings), most_(settings.passes), means_(kBlocks) {
        settings_.size = kSize;
        settings_.params.sampler = SamplerKind::Random;
    }

    /// Renders what is missing of that share of the passes. Passes do not depend on earlier ones here.
    const std::vector<test::RunningMean>& grow_to(double share) {
        const auto wanted = static_cast<uint32_t>(std::lround(share * most_));
        if (wanted <= settings_.first_pass) return means_;
        settings_.passes = wanted - settings_.first_pass;
        test::run_passes(scene_, settings_, [&](M& method, uint32_t pass) {
            Film film(settings_.size, settings_.layers, pass);
            method.resolve(film);
            add_pass(film, means_);
        });
        settings_.first_pass = wanted;
        return means_;
    }

private:
    const Scene& scene_;
    test::RenderSettingsOf<M> settings_;
    const uint32_t most_;
    std::vector<test::RunningMean> means_;
};

template <class M>
std::vector<test::RunningMean> block_means(const Scene& scene, const test::RenderSettingsOf<M>& settings) {
    return GrowingMeans<M>(scene, settings).grow_to(1);
}

/// A scene rendered by techniques that no choice would make.
class JoinedRender {
public:
    static constexpr float kRadius = 0.02f;  // of merging

    JoinedRender(const Scene& scene, PixelFilter filter, std::optional<uint32_t> bounces, LayerSet layers)
        : layers_(layers),
          intersector_(make_embree_intersector(scene, budget_, stats_)),
          shared_({scene, intersector_.get(), View{find_camera(scene, ""), kSize, filter, layers}, kSeed, budget_},
                  params(bounces)),
          coverage_(scene, *intersector_, kRadius),
          tracer_(shared_) {
        techniques.light_paths = static_cast<uint32_t>(kSize.pixels());
        techniques.coverage = &coverage_;
    }

    PassTechniques techniques;

    double vertices_per_path() {
        return static_cast<double>(tracer_.trace(7, 0, techniques, counts_, never_).vertices.size()) /
               techniques.light_paths;
    }
    /// Of the passes' blocks; all passes are added to `film`, where there is one.
    std::vector<test::RunningMean> means(uint32_t passes, Film* film = nullptr) {
        std::vector<test::RunningMean> means(kBlocks);
        for (uint32_t pass = 0; pass < passes; ++pass) {
            PassImage image(kSize, layers_);
            render(pass, image);
            Film of_pass(kSize, layers_, pass);
            of_pass.add_pass(image);
            add_pass(of_pass, means);
            if (film != nullptr) film->add_pass(image);
        }
        return means;
    }

private:
    static constexpr uint64_t kSeed = 6;

    static VertexConnectionAndMergingParams params(std::optional<uint32_t> bounces) {
        VertexConnectionAndMergingParams params;
        params.sampler = SamplerKind::Random;
        params.indirect_bounces = bounces;
        return params;
    }
    void render(uint32_t pass, PassImage& image) {
        const LightPaths& light = tracer_.trace(kSeed, pass, techniques, counts_, never_);
        std::vector<uint32_t> order(light.vertices.size());
        const HashGrid grid = light.grid(kRadius, order);
        const PassSampler sampler(SamplerKind::Random, kSeed, RandomDomain::Camera, pass);
        const JoinedPass joined{.techniques = techniques,
                                .light = light,
                                .grid = &grid,
                                .in_grid_order = order,
                                .sampler = sampler,
                                .join_salt = pass};
        parallel_over_tiles(kSize, EyePathTracer::kTileSide, never_, [&](const Tile& tile) {
            Counts rays;
            EyeSeconds seconds;
            eyes_.local().trace_tile(shared_, joined, tile, image, rays, seconds);
        });
        light.add_splats(shared_.filter, techniques.blocks, image);
    }

    const LayerSet layers_;
    MemoryBudget budget_;
    Stats stats_;
    const std::unique_ptr<Intersector> intersector_;
    const BidirectionalScene shared_;
    const DiscCoverage coverage_;
    LightPathTracer tracer_;
    ThreadLocal<EyePathTracer> eyes_;
    Counts counts_;
    const CancelToken never_;
};

/// Of passes whose blocks of 16 pixels have techniques of their own: none but what is always there, connections,
/// merging, and both.
std::vector<test::RunningMean> means_by_blocks(const Scene& scene, MergeWeights weights, PixelFilter filter,
                                               uint32_t passes) {
    JoinedRender render(scene, filter, std::nullopt, LayerSet());
    PassTechniques& techniques = render.techniques;
    const double vertices = render.vertices_per_path();
    std::vector<BlockTechniques> of_blocks;
    for (const auto& [connections, merges] : {std::pair{0u, false}, {2u, false}, {0u, true}, {1u, true}})
        of_blocks.push_back({connections,
                             {.light_paths = static_cast<float>(techniques.light_paths),
                              .connections = static_cast<float>(connections / vertices),
                              .merges = merges}});
    const TechniqueBlocks blocks(kSize, EyePathTracer::kTileSide, of_blocks);
    techniques.blocks = &blocks;
    techniques.merge_radius_m = techniques.edge_radius_m = JoinedRender::kRadius;
    techniques.correlated = weights == MergeWeights::CorrelationAware;
    return render.means(passes);
}

constexpr double kMustNotice = 0.1;  // relative, of the noisiest block

/// Expects the two to have one mean in each block. The variances of their passes say how far apart the means may lie.
/// Returns the smallest relative difference that every block would notice.
double difference_noticed(const std::vector<test::RunningMean>& a, const std::vector<test::RunningMean>& b,
                          double false_alarm) {
    const double limit = test::two_sided_z(test::share_of_false_alarm(false_alarm, a.size()));
    double noticed = 0, farthest = 0;
    for (size_t i = 0; i < a.size(); ++i) {
        const double deviation = std::hypot(a[i].standard_error(), b[i].standard_error());
        const double z = (b[i].mean() - a[i].mean()) / deviation;
        farthest = std::max(farthest, std::fabs(z));
        noticed = std::max(noticed, limit * deviation / a[i].mean());
        EXPECT_LE(std::fabs(z), limit) << "block " << i << ": " << b[i].mean() << " instead of " << a[i].mean();
    }
    std::printf("%zu blocks, |z| up to %.2f of %.2f; a block that differs by %.1f %% is noticed\n", a.size(), farthest,
                limit, 100 * noticed);
    return noticed;
}

void expect_one_mean(const std::vector<test::RunningMean>& a, const std::vector<test::RunningMean>& b) {
    EXPECT_LT(difference_noticed(a, b, kFalseAlarm), kMustNotice);
}

/// expect_one_mean() that renders no more passes than it needs to notice what it must. The reference serves several
/// comparisons and may have more passes than the look asks for: each pair of looks of the two has an equal part of the
/// false-alarm rate (Bonferroni).
template <class A, class B>
void expect_one_mean_when_sharp(GrowingMeans<A>& reference, GrowingMeans<B> found) {
    constexpr double kLooks[] = {0.45, 0.7, 1};  // shares of the passes
    constexpr size_t kPairs = 6;                 // the reference is at the look's share or at a later one
    double noticed = 0;
    for (const double look : kLooks) {
        noticed = difference_noticed(reference.grow_to(look), found.grow_to(look), kFalseAlarm / kPairs);
        if (noticed < kMustNotice) break;
    }
    EXPECT_LT(noticed, kMustNotice);
}

struct Case {
    const char* name;
    Scene scene;
    std::optional<uint32_t> bounces = std::nullopt;
    PixelFilter filter = PixelFilter::Box;
};

std::vector<Case> cases() {
    std::vector<Case> list;
    list.push_back({"gloss under a lamp", with_lamp(gloss())});
    list.push_back({"a mirrored lamp, from afar", from_afar(mirrored_lamp(with_lamp(gloss()))), 1});
    list.push_back({"gloss under points, spots and suns", with_punctual_lights(gloss())});
    list.push_back({"gloss under a sky", with_sky(gloss())});
    list.push_back({"rough glass under all lights", with_all_lights(rough_glass()), 3});
    list.push_back({"orthographic", orthographic(with_all_lights(gloss())), 1});
    list.push_back({"boards that nearly touch", with_lamp(nearly_touching())});
    list.push_back({"a lens", with_lens(with_lamp(gloss())), 0, PixelFilter::BlackmanHarris});
    return list;
}

// A light path that a smooth filter shows to pixels of several blocks is weighed for each.
TEST(BidirectionalImages, OfBlocksAreThoseOfPathTracing) {
    const Scene scene = with_lamp(gloss());
    for (const PixelFilter filter : {PixelFilter::Box, PixelFilter::BlackmanHarris}) {
        test::RenderSettings reference{.passes = 600, .seed = 3};
        reference.filter = filter;
        const auto expected = block_means(scene, reference);
        for (const MergeWeights weights : {MergeWeights::Recursive, MergeWeights::CorrelationAware})
            expect_one_mean(expected, means_by_blocks(scene, weights, filter, 300));
    }
}

// In a closed room whose walls all emit 1 and reflect a half, radiance is 2 everywhere, whatever is merged within which
// radius: weights have to know each place's own.
TEST(BidirectionalImages, TrainedRadiiKeepTheLightOfARoom) {
    Scene scene;
    Mesh walls = MeshBuilder().box({-1, -1, -1}, {1, 1, 1}).build(0);
    for (uvec3& t : walls.triangles) std::swap(t.y, t.z);
    test::add(scene, std::move(walls), test::lambert(0.5f, 1));
    scene.cameras.push_back(look_at_camera({-0.9f, -0.8f, 0.7f}, {1, 0.3f, -1}, {0, 1, 0}, 1.2f));
    finish_scene(scene);
    constexpr double kExact = 2;
    test::RunningMean merged;
    const test::Interval interval = test::interval_when_narrow(0.01 * kExact, 24, kFalseAlarm, 1, [&](uint64_t seed) {
        test::RenderSettingsOf<VertexConnectionAndMerging> settings{.size = kSize, .passes = 4, .seed = seed};
        settings.params.adapt = false;
        settings.params.merging_params.radius_rule = RadiusRule::Trained;
        settings.layers.add(Layer::Merges);
        const Film film = test::render(scene, settings);
        merged.add(test::mean_of(film.resolve(Layer::Merges)));
        return test::mean_of(film.resolve_beauty());
    });
    std::printf("radiance %.5f +- %.5f, %.3f of it merged, %zu films\n", interval.mean, interval.half_width,
                merged.mean(), merged.count());
    EXPECT_LE(std::fabs(interval.mean - kExact), interval.half_width);
    EXPECT_LE(interval.half_width, 0.01 * kExact) << "too noisy to notice a defect";
    EXPECT_GT(merged.mean(), 0.05);
}

/// A floor and a wall that keep their distance: what connects them has a bounded variance without any weight.
Scene apart() {
    Scene scene;
    test::add(scene, MeshBuilder().quad({-3, 0, 1.5f}, {3, 0, 1.5f}, {3, 0, -1.5f}, {-3, 0, -1.5f}).build(0),
              test::lambert(0.6f));
    test::add(scene, MeshBuilder().quad({-3, 1, -2.5f}, {3, 1, -2.5f}, {3, 4.5f, -2.5f}, {-3, 4.5f, -2.5f}).build(0),
              test::lambert(0.8f));
    scene.cameras.push_back(look_at_camera({0, 2, 6}, {0, 1.2f, -1}, {0, 1, 0}, 0.6f));
    return with_lamp(std::move(scene));
}

// Weights that take one technique for all but certain leave the others only the paths that it cannot make: it alone
// makes the rest of path tracing's image. Of two scatterings there is one connection, and of any number one light path
// that the camera sees.
TEST(BidirectionalImages, EachTechniqueAloneIsPathTracing) {
    const Scene scene = apart();
    constexpr float kAllButCertain = 1e9f;
    const auto pixels = static_cast<float>(kSize.pixels());
    struct Alone {
        const char* name;
        uint32_t bounces;
        BlockTechniques techniques;
        Layer layer;  // of the technique
        bool makes_direct;
    };
    const Alone techniques[] = {
        {"connections", 1, {2, {pixels, kAllButCertain, false}}, Layer::Connections, false},
        {"connections of three scatterings", 2, {2, {pixels, kAllButCertain, false}}, Layer::Connections, false},
        {"light paths that the camera sees", 2, {0, {kAllButCertain, 0, false}}, Layer::LightImage, true}};
    for (const Alone& alone : techniques) {
        SCOPED_TRACE(alone.name);
        test::RenderSettings reference{.passes = 800, .seed = 3};
        reference.params.indirect_bounces = alone.bounces;
        LayerSet layers;
        layers.add(alone.layer);
        JoinedRender render(scene, PixelFilter::Box, alone.bounces, layers);
        render.techniques.everywhere = alone.techniques;
        Film film(kSize, layers);
        expect_one_mean(block_means(scene, reference), render.means(800, &film));
        const double made = test::mean_of(film.resolve(Layer::Indirect)) +
                            (alone.makes_direct ? test::mean_of(film.resolve(Layer::Direct)) : 0);
        EXPECT_GT(test::mean_of(film.resolve(alone.layer)), 0.999 * made);
    }
}

/// A sheet of smooth glass in the sun, and below it a floor that wide, as seen from straight above: by merging alone.
Scene below_a_sheet(float half_width_m) {
    Scene scene;
    const auto sheet = [](float x, float y) {
        return MeshBuilder().quad({-x, y, 0.3f}, {x, y, 0.3f}, {x, y, -0.3f}, {-x, y, -0.3f}).build(0);
    };
    test::add(scene, sheet(0.3f, 0.2f), rough(0, 0, 1, false));
    test::add(scene, sheet(half_width_m, 0), test::lambert(0.8f));
    scene.punctual_lights = {test::sun({0.1f, -1, 0.05f})};
    scene.cameras.push_back(look_at_camera({0, 1, 0}, {0, 0, 0}, {0, 0, -1}, 0.08f));
    finish_scene(scene);
    return scene;
}

// All discs hang over the edges of a strip narrower than they are, and nothing else makes the paths that merging lacks.
TEST(BidirectionalImages, MergingLacksNoLightAtEdges) {
    for (const MergeWeights weights : {MergeWeights::Recursive, MergeWeights::CorrelationAware}) {
        test::RenderSettingsOf<VertexConnectionAndMerging> settings{.passes = 400, .seed = 6};
        settings.params.indirect_bounces = 2;
        settings.params.adapt = false;
        settings.params.light_paths = 4;
        settings.params.merging_params.radius_m = 0.1f;
        settings.params.merging_params.weights = weights;
        const auto of_floor = block_means(below_a_sheet(0.3f), settings);
        settings.seed = 7;
        expect_one_mean(of_floor, block_means(below_a_sheet(0.05f), settings));
    }
}

TEST(BidirectionalImages, AreThoseOfPathTracing) {
    for (const Case& c : cases()) {
        SCOPED_TRACE(c.name);
        test::RenderSettings reference{.passes = 1200, .seed = 3};
        reference.params.indirect_bounces = c.bounces;
        reference.filter = c.filter;
        GrowingMeans<PathTracing> expected(c.scene, reference);
        for (const Connections connections : {Connections::Cache, Connections::OwnPath}) {
            test::RenderSettingsOf<BidirectionalPathTracing> settings{.passes = 300, .seed = 4};
            settings.params.indirect_bounces = c.bounces;
            settings.params.connections = connections;
            settings.params.adapt = false;
            settings.params.connections_per_vertex = 2;
            settings.params.light_paths = connections == Connections::Cache ? 0.5f : 1;
            settings.params.heuristic = connections == Connections::Cache ? MisHeuristic::Balance : MisHeuristic::Power;
            settings.filter = c.filter;
            expect_one_mean_when_sharp(expected, GrowingMeans(c.scene, settings));
        }
        for (const MergeWeights weights : {MergeWeights::Recursive, MergeWeights::CorrelationAware}) {
            test::RenderSettingsOf<VertexConnectionAndMerging> merging{.passes = 300, .seed = 5};
            merging.params.indirect_bounces = c.bounces;
            merging.params.adapt = false;
            merging.params.merging_params.radius_m = 0.02f;
            merging.params.merging_params.caustic_radius_share = 0.5f;
            merging.params.merging_params.weights = weights;
            merging.filter = c.filter;
            expect_one_mean_when_sharp(expected, GrowingMeans(c.scene, merging));
        }
    }
}

}  // namespace
}  // namespace photond::bidirectional_images_test
