// Photon mapping on a GPU against its CPU twin: the same photons and eye paths, but for rounding; and what a method
// promises beside.

#include <gtest/gtest.h>

#include <algorithm>

#include "protocol/error.h"
#include "renderer/methods/photon_mapping/photon_mapping_gpu.h"
#include "renderer/photons/hash_grid_gpu.h"
#include "renderer/photons/photon_guides.h"
#include "renderer/photons/radiance_estimate_shared.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/gpu_render.h"
#include "tests/support/photons.h"
#include "tests/support/pipeline_layers.h"
#include "tests/support/scene_parts.h"

namespace photond::gpu_photon_mapping_test {
namespace {

/// The pass's photons as the device appends them.
std::vector<Photon> trace_on_device(const gpu::DeviceScene& scene, const PhotonTracing& tracing, uint32_t pass,
                                    Counts& counts) {
    constexpr uint32_t kRoom = 100'000;
    gpu::Device& device = test::gpu_device();
    PhotonTracerGpu tracer(scene, tracing);
    UnsortedPhotons photons(device, kRoom);
    gpu::CommandList commands(device);
    tracer.record_start(commands);
    const uint32_t half = tracing.photons / 2;  // in two pieces
    tracer.record_paths(commands, 1, pass, 0, half, photons, kRoom);
    tracer.record_paths(commands, 1, pass, half, tracing.photons, photons, kRoom);
    commands.submit();
    commands.wait();
    const std::vector<uint32_t> state = gpu::read_back<uint32_t>(device, tracer.state(), PHOTON_STATE_WORDS);
    tracer.add_to(counts, state);
    const uint32_t stored = state[PHOTONS_STORED_WORD];
    const auto places = gpu::read_back<gpu::PhotonPlace>(device, photons.places, stored);
    const auto powers = gpu::read_back<gpu::PhotonPower>(device, photons.powers, stored);
    std::vector<Photon> all(stored);
    for (uint32_t i = 0; i < stored; ++i)
        all[i] = {places[i].position, {powers[i].power_w, powers[i].direction, places[i].normal_and_path}};
    return all;
}

/// Photons of `a` that have no like in `b`: as many scatterings and the same kind of them, a place within 1e-4 of the
/// scene's radius, a power within 1e-3 of itself, directions within a milliradian.
size_t without_like(const std::vector<Photon>& a, std::vector<Photon> b, float radius_m) {
    const auto by_x = [](const Photon& p, const Photon& q) { return p.position.x < q.position.x; };
    std::sort(b.begin(), b.end(), by_x);
    std::vector<bool> taken(b.size());
    const float apart_m = 1e-4f * radius_m;
    size_t alone = 0;
    for (const Photon& photon : a) {
        Photon from = photon;
        from.position.x -= apart_m;
        bool found = false;
        for (size_t i = static_cast<size_t>(std::lower_bound(b.begin(), b.end(), from, by_x) - b.begin());
             i < b.size() && b[i].position.x <= photon.position.x + apart_m && !found; ++i) {
            const PhotonPayload &p = photon.payload, &q = b[i].payload;
            found = !taken[i] && glm::length(b[i].position - photon.position) < apart_m &&
                    p.scatterings() == q.scatterings() && p.all_delta() == q.all_delta() && p.marked() == q.marked() &&
                    glm::length(p.power_w - q.power_w) < 1e-3f * glm::length(q.power_w) &&
                    glm::length(p.wi_world() - q.wi_world()) < 1e-3f && glm::length(p.normal() - q.normal()) < 1e-2f;
            if (found) taken[i] = true;
        }
        alone += !found;
    }
    return alone;
}

class GpuPhotonTracer : public testing::TestWithParam<const char*> {};

// Rounding now and then sends a path elsewhere (a hit on the other side of an edge, another lobe), and with it all
// photons that follow: at most one in a hundred is without its like.
TEST_P(GpuPhotonTracer, StoresTheCpusPhotons) {
    const test::PhotonScene host(test::turned(make_builtin_scene(GetParam())));
    const gpu::DeviceScene device_scene(test::gpu_device(), host.scene);
    for (const PhotonMapKind kind : {PhotonMapKind::Global, PhotonMapKind::Caustic}) {
        PhotonTracing tracing = test::photon_tracing(kind, 5000);
        tracing.most_scatterings = 6;
        const ProjectionMap guide(host.scene, *host.intersector, host.emission, target_of(kind),
                                  tracing.glossy_threshold, 1);
        if (guide.helps()) tracing.guide = &guide;
        const TracedPhotons cpu = host.trace(tracing, 1, 3);
        Counts counts;
        const std::vector<Photon> gpu = trace_on_device(device_scene, tracing, 3, counts);
        EXPECT_EQ(counts.photons_emitted, cpu.counts.photons_emitted);
        EXPECT_EQ(counts.photons_stored, gpu.size());
        const double tolerance = 0.01 * double(cpu.photons.size()) + 2;
        EXPECT_NEAR(double(gpu.size()), double(cpu.photons.size()), tolerance);
        EXPECT_NEAR(double(counts.photon_rays), double(cpu.counts.photon_rays), 0.01 * double(cpu.counts.photon_rays));
        const float radius_m = host.scene.bounds.radius();
        EXPECT_LE(double(without_like(gpu, cpu.photons, radius_m)), tolerance) << gpu.size() << " photons";
        EXPECT_LE(double(without_like(cpu.photons, gpu, radius_m)), tolerance) << gpu.size() << " photons";
    }
}
INSTANTIATE_TEST_SUITE_P(BuiltinScenes, GpuPhotonTracer,
                         testing::Values("cornell-box", "cornell-box-spot", "cornell-box-glossy", "cornell-box-glass",
                                         "interior"),
                         [](const auto& info) { return test::test_name(info.param, info.index); });

/// Photons in random places, then some thirty all in one; `word` counts them.
std::vector<gpu::PhotonPlace> random_places(uint32_t count) {
    RandomStream random(1, RandomDomain::Test, 0, 0);
    std::vector<gpu::PhotonPlace> places(count);
    for (uint32_t i = 0; i < count; ++i) {
        const vec3 p(random.next(), 2 * random.next(), 0.5f * random.next());
        places[i] = {i + 30 < count ? p : vec3(0.5f, 1, 0.25f), i + 1};
    }
    return places;
}

/// As grid_distance_sq() rounds it.
float distance_sq(const vec3& p, const vec3& q) {
    const vec3 d = q - p;
    const volatile float x = d.x * d.x, y = d.y * d.y, z = d.z * d.z, xy = x + y;
    return xy + z;
}

struct PhotonsFound {
    float radius_m;
    uint32_t photons, sum;
};

/// By looking at all. Of those as far as the k-th any may be left out: `sum` is 0 where there are several.
PhotonsFound find_by_brute_force(const std::vector<gpu::PhotonPlace>& places, const vec3& p, float radius_m,
                                 uint32_t k) {
    std::vector<std::pair<float, uint32_t>> near;
    for (const gpu::PhotonPlace& place : places)
        if (const float d = distance_sq(p, place.position); d < radius_m * radius_m)
            near.emplace_back(d, place.normal_and_path);
    std::sort(near.begin(), near.end());
    PhotonsFound found{radius_m, 0, 0};
    bool several = false;
    if (k > 0 && near.size() >= k) {
        found.radius_m = std::sqrt(near[k - 1].first);
        several = near[k - 2].first == near[k - 1].first;
        near.resize(k - 1);
    }
    found.photons = static_cast<uint32_t>(near.size());
    for (const auto& [d, word] : near) found.sum += word;
    if (several) found.sum = 0;
    return found;
}

struct Search {
    float radius_m;
    uint32_t nearest;       // 0: all within the radius
    float cell_m;           // of the grid
    uint32_t laid_out_for;  // points: few make a table in which rows meet
};

class GpuPhotonSearch : public testing::TestWithParam<Search> {};

// Few enough candidates each: lavapipe (Mesa 22) leaves a shader's loops after 65535 turns in all.
TEST_P(GpuPhotonSearch, FindsWhatBruteForceFinds) {
    const Search& search = GetParam();
    constexpr uint32_t kPhotons = 3000, kQueries = 400;
    gpu::Device& device = test::gpu_device();
    const std::vector<gpu::PhotonPlace> places = random_places(kPhotons);
    Bounds3 bounds;
    bounds.extend(vec3(0));
    bounds.extend(vec3(1, 2, 0.5f));
    gpu::EstimateConstants constants{};
    gpu::HashGridConstants& grid = constants.maps[0].grid;
    grid = lay_out_grid(bounds, search.cell_m, search.laid_out_for);
    grid.first_start = 3, grid.first_point = 7, grid.capacity = kPhotons;  // as of the second grid of two
    constants.maps[0].radius_m = search.radius_m;
    constants.maps[0].nearest = search.nearest;

    UnsortedPhotons photons(device, kPhotons);
    std::vector<uint32_t> paths(kPhotons), order(kPhotons);
    for (uint32_t i = 0; i < kPhotons; ++i) paths[i] = i * 7919 % kPhotons, order[i] = i;
    gpu::upload(device, photons.places, std::as_bytes(std::span(places)));
    gpu::upload(device, photons.paths, std::as_bytes(std::span(paths)));
    gpu::upload(device, photons.order, std::as_bytes(std::span(order)));
    std::vector<uint32_t> state(PHOTON_STATE_WORDS);
    state[PHOTONS_STORED_WORD] = kPhotons;
    gpu::Buffer tracer_state = gpu::make_buffer(device, "state", std::span<const uint32_t>(state));
    GridPhotons in_order(device, grid.first_start + grid.slots + 1, grid.first_point + kPhotons);
    HashGridGpu builder(device);
    gpu::CommandList commands(device);
    builder.record(commands, grid, tracer_state, kPhotons, photons, in_order);
    commands.submit();
    commands.wait();
    const auto starts = gpu::read_back<uint32_t>(device, in_order.starts, grid.first_start + grid.slots + 1);
    const auto map_places = gpu::read_back<gpu::PhotonPlace>(device, in_order.places, grid.first_point + kPhotons);
    const auto map_powers = gpu::read_back<gpu::PhotonPower>(device, in_order.powers, grid.first_point + kPhotons);

    std::vector<vec3> queries(kQueries);
    RandomStream random(2, RandomDomain::Test, 0, 0);
    for (vec3& p : queries)  // beside the box, too
        p = vec3(1.2f * random.next() - 0.1f, 2.4f * random.next() - 0.2f, 0.6f * random.next() - 0.05f);
    queries[0] = vec3(0.5f, 1, 0.25f);
    queries[1] = vec3(1e6f, 0, 0);
    const test::PartOfScene no_scene({});
    const test::Twin twin("tests/gpu/photon_search.comp", &no_scene.set());
    const auto found =
        twin.run<PhotonsFound>(kQueries, {{"grid_starts", starts},
                                          {"grid_places", map_places},
                                          {"map_powers", map_powers},
                                          {"constants", std::span<const gpu::EstimateConstants>(&constants, 1)},
                                          {"queries", queries}});
    uint64_t all = 0;
    for (uint32_t i = 0; i < kQueries; ++i) {
        const PhotonsFound wanted = find_by_brute_force(places, queries[i], search.radius_m, search.nearest);
        EXPECT_FLOAT_EQ(found[i].radius_m, wanted.radius_m) << i;
        EXPECT_EQ(found[i].photons, wanted.photons) << i;
        if (wanted.sum != 0) {
            EXPECT_EQ(found[i].sum, wanted.sum) << i;
        }
        all += found[i].photons;
    }
    EXPECT_GT(all, kQueries) << "searches in empty space show nothing";
}
INSTANTIATE_TEST_SUITE_P(Searches, GpuPhotonSearch,
                         testing::Values(Search{0.1f, 0, 0.1f, 3000}, Search{0.1f, 0, 0.1f, 1},
                                         Search{0.2f, 0, 0.05f, 1000}, Search{0.3f, 50, 0.1f, 100'000},
                                         Search{0.3f, 5, 0.03f, 3000}, Search{5, 1000, 0.3f, 3000},
                                         Search{0.08f, 20, 0.05f, 3000}, Search{5, 4000, 0.5f, 3000}),
                         [](const auto& info) { return test::test_name("search", info.index); });

struct Choice {
    const char* scene;
    Gather gather;
    PhotonSearch::Kind search;
    KernelShape kernel = KernelShape::Constant;
    bool soft_disc = false;
    std::optional<float> disc_thickness_m{};
    DiscBoundary boundary = DiscBoundary::None;  // clipped discs take long where a processor plays the device
    bool precomputed = false;
};

template <class M>
test::RenderSettingsOf<M> settings_for(const Choice& choice) {
    test::RenderSettingsOf<M> settings;
    settings.size = {28, 20};  // tiles cut at both edges
    settings.passes = 2;
    settings.layers = test::photon_mapping_layers();
    settings.params.photons = 4000;
    settings.params.indirect_bounces = 6;
    settings.params.gather = choice.gather;
    settings.params.gather_rays = 5;
    settings.params.light_samples = 2;
    settings.params.search = choice.search;
    settings.params.nearest_photons = 20;
    settings.params.caustic_nearest_photons = 40;
    settings.params.kernel = choice.kernel;
    settings.params.soft_disc = choice.soft_disc;
    settings.params.disc_thickness_m = choice.disc_thickness_m;
    settings.params.boundary = choice.boundary;
    settings.params.precompute_irradiance = choice.precomputed;
    return settings;
}

/// For what is to be the same to the bit, however few photons there are.
test::RenderSettingsOf<PhotonMappingGpu> few_photons(const Choice& choice) {
    auto settings = settings_for<PhotonMappingGpu>(choice);
    settings.params.photons = 1000;
    return settings;
}

class GpuPhotonMapping : public testing::TestWithParam<Choice> {};

// A photon that rounding sends elsewhere shows in all pixels whose discs it was in, by about 1/20 of their light: what
// is bounded is the mean difference, and how many pixels differ by as much as a photon is worth.
TEST_P(GpuPhotonMapping, LooksLikeTheCpus) {
    const Choice& choice = GetParam();
    const Scene scene = test::turned(make_builtin_scene(choice.scene));
    Stats cpu_stats, gpu_stats;
    const Film cpu = test::render(scene, settings_for<PhotonMapping>(choice), &cpu_stats);
    const Film gpu = test::render(test::SceneOnDevice(scene), settings_for<PhotonMappingGpu>(choice), &gpu_stats);
    for (const Layer layer :
         {Layer::Emitted, Layer::Direct, Layer::Albedo, Layer::Normal, Layer::Position, Layer::Depth})
        EXPECT_LT(test::share_apart(cpu.resolve(layer), gpu.resolve(layer), 1e-3), 0.02) << layer_info(layer).name;
    for (const Layer layer : {Layer::Indirect, Layer::Caustic, Layer::PhotonCount}) {
        EXPECT_LT(test::share_apart(cpu.resolve(layer), gpu.resolve(layer), 0.02), 0.05) << layer_info(layer).name;
        EXPECT_NEAR(test::mean_of(cpu.resolve(layer)), test::mean_of(gpu.resolve(layer)),
                    0.02 * test::mean_of(cpu.resolve(layer)))
            << layer_info(layer).name;
    }
    const Counts &a = cpu_stats.counts, &b = gpu_stats.counts;
    EXPECT_EQ(a.camera_rays, b.camera_rays);
    EXPECT_EQ(a.photons_emitted, b.photons_emitted);
    const auto about = [](uint64_t x, uint64_t y) { return std::fabs(double(x) - double(y)) <= 0.01 * double(x) + 10; };
    EXPECT_TRUE(about(a.bounce_rays, b.bounce_rays)) << a.bounce_rays << ", " << b.bounce_rays;
    EXPECT_TRUE(about(a.shadow_rays, b.shadow_rays)) << a.shadow_rays << ", " << b.shadow_rays;
    EXPECT_TRUE(about(a.photon_rays, b.photon_rays)) << a.photon_rays << ", " << b.photon_rays;
    EXPECT_TRUE(about(a.photons_stored, b.photons_stored)) << a.photons_stored << ", " << b.photons_stored;
    EXPECT_EQ(gpu.nan_count() + gpu.infinity_count(), 0u);
}
constexpr PhotonSearch::Kind kNearest = PhotonSearch::Kind::Nearest, kRadius = PhotonSearch::Kind::Radius;
// Choices that several tests make, so that their pipelines are compiled once.
constexpr Choice kClippedBox{
    .scene = "cornell-box", .gather = Gather::Direct, .search = kRadius, .boundary = DiscBoundary::Clip};
constexpr Choice kPrecomputedBox{.scene = "cornell-box",
                                 .gather = Gather::Final,
                                 .search = kNearest,
                                 .boundary = DiscBoundary::Clip,
                                 .precomputed = true};
constexpr Choice kGlass{"cornell-box-glass", Gather::Direct, kNearest, KernelShape::Epanechnikov};
constexpr Choice kGatheringGlass{"cornell-box-glass", Gather::Final, kRadius, KernelShape::Gaussian};
template <class Info>
std::string name_of(const Info& info) {
    return test::test_name(info.param.scene, info.index);
}
INSTANTIATE_TEST_SUITE_P(Choices, GpuPhotonMapping,
                         testing::Values(kClippedBox, kPrecomputedBox,
                                         Choice{.scene = "cornell-box-spot",
                                                .gather = Gather::Direct,
                                                .search = kNearest,
                                                .kernel = KernelShape::Cone,
                                                .boundary = DiscBoundary::Clip},
                                         kGatheringGlass, kGlass,
                                         Choice{"cornell-box-glossy", Gather::Direct, kRadius, KernelShape::Constant,
                                                true}),
                         name_of<testing::TestParamInfo<Choice>>);
INSTANTIATE_TEST_SUITE_P(
    LongChoices, GpuPhotonMapping,
    testing::Values(
        Choice{"cornell-box-glossy", Gather::Final, kNearest, KernelShape::Constant, false, 0.01f},
        Choice{"cornell-box", Gather::Final, kNearest},
        Choice{.scene = "cornell-box-glossy", .gather = Gather::Final, .search = kRadius, .precomputed = true}),
    name_of<testing::TestParamInfo<Choice>>);

TEST(GpuPhotonMapping, SameDeviceSameBits) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    const test::SceneOnDevice where(scene);
    const auto settings = few_photons(kGlass);
    EXPECT_EQ(test::render(where, settings).pixel_hash(), test::render(where, settings).pixel_hash());
}

TEST(GpuPhotonMapping, GathersTheSameBits) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    const test::SceneOnDevice where(scene);
    const auto settings = few_photons(kGatheringGlass);
    EXPECT_EQ(test::render(where, settings).pixel_hash(), test::render(where, settings).pixel_hash());
}

TEST(GpuPhotonMapping, APassIsAPureFunctionOfItsIndex) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    auto whole = few_photons(kClippedBox), first = whole, rest = whole;
    whole.passes = 3;
    first.passes = 1;
    rest.passes = 2;
    rest.first_pass = 1;
    Film merged = test::render(where, first);
    merged.merge(test::render(where, rest));
    EXPECT_EQ(merged, test::render(where, whole));
}

// In a white room a path leaves a photon at nearly each of up to 60 scatterings: many times as many as there is room
// for.
TEST(GpuPhotonMapping, LosesNoPhotonWhereThereAreMoreThanExpected) {
    Scene scene = test::turned(make_builtin_scene("cornell-box"));
    for (Material& material : scene.materials) material.base_color = Rgb(0.97f);
    auto settings = settings_for<PhotonMapping>(kClippedBox);
    auto on_gpu = settings_for<PhotonMappingGpu>(kClippedBox);
    settings.params.indirect_bounces = on_gpu.params.indirect_bounces = 20;
    Stats cpu_stats, gpu_stats;
    const Film cpu = test::render(scene, settings, &cpu_stats);
    const Film gpu = test::render(test::SceneOnDevice(scene), on_gpu, &gpu_stats);
    EXPECT_GT(cpu_stats.counts.photons_stored, 3 * cpu_stats.counts.photons_emitted);
    EXPECT_NEAR(double(gpu_stats.counts.photons_stored), double(cpu_stats.counts.photons_stored),
                0.01 * double(cpu_stats.counts.photons_stored));
    EXPECT_EQ(gpu_stats.counts.photons_emitted, cpu_stats.counts.photons_emitted);
    EXPECT_NEAR(test::mean_of(gpu.resolve(Layer::Indirect)), test::mean_of(cpu.resolve(Layer::Indirect)),
                0.01 * test::mean_of(cpu.resolve(Layer::Indirect)));
}

TEST(GpuPhotonMapping, ACancelledPassIsNoPass) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    auto settings = few_photons(kClippedBox);
    settings.passes = 1;
    MemoryBudget budget;
    Stats stats;
    const RenderContext context{scene,  &where.intersector, test::view_of(scene, settings), 1,
                                budget, &where.device_scene};
    PhotonMappingGpu method(settings.params);
    method.begin(context, stats);
    CancelToken cancel;
    cancel.cancel();
    method.run_pass(0, stats, cancel);
    Film film(settings.size, settings.layers);
    method.resolve(film);
    EXPECT_EQ(film.passes(), 0u);
    method.run_pass(0, stats, CancelToken{});
    method.resolve(film);
    EXPECT_EQ(film, test::render(where, settings));
}

TEST(GpuPhotonMapping, TakesTheMemoryItSays) {
    for (const Choice& choice : {kPrecomputedBox, kGatheringGlass}) {  // the glass has a caustic map
        SCOPED_TRACE(choice.scene);
        const Scene scene = make_builtin_scene(choice.scene);
        auto settings = settings_for<PhotonMappingGpu>(choice);
        settings.params.photons = 200'000;
        settings.params.gather_rays = 512;  // enough for irradiance to be precomputed
        test::expect_device_bytes_as_estimated(test::SceneOnDevice(scene), settings);
    }
}

TEST(GpuPhotonMapping, RefusesWhatOnlyTheCpuHas) {
    const auto pointer_of = [](auto change) -> std::string {
        PhotonMappingParams params;
        change(params);
        try {
            PhotonMappingGpu::check_gpu(params);
        } catch (const Error& error) {
            EXPECT_EQ(error.code, ErrorCode::Unsupported);
            return error.faults.at(0).pointer;
        }
        return "";
    };
    EXPECT_EQ(pointer_of([](PhotonMappingParams& p) { p.soft_disc = true; }), "");
    EXPECT_EQ(pointer_of([](PhotonMappingParams& p) { p.shadow_photons = true; }), "/shadow_photons");
    EXPECT_EQ(pointer_of([](PhotonMappingParams& p) { p.gather_sampling = GatherSampling::Photons; }),
              "/gather_sampling");
    EXPECT_EQ(pointer_of([](PhotonMappingParams& p) { p.keep_photon_map = true; }), "/keep_photon_map");
}

}  // namespace
}  // namespace photond::gpu_photon_mapping_test
