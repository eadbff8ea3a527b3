// What photon splatting promises beside the right light: bits that do not depend on threads or on how passes are cut,
// layers, counts, parameters, memory; and that it stays finite in scenes that leave it nothing to work with.

#include "renderer/methods/photon_splatting/photon_splatting.h"

#include <gtest/gtest.h>

#include "protocol/error.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/hard_scenes.h"
#include "tests/support/render.h"
#include "tests/support/threads.h"

namespace photond::photon_splatting_test {
namespace {

using Params = PhotonSplattingParams;
using Settings = test::RenderSettingsOf<PhotonSplatting>;

Settings small(uint32_t passes = 1, uint32_t photons = 400) {
    Settings settings;
    settings.size = {40, 35};  // tiles cut at both edges
    settings.passes = passes;
    settings.params.photons = photons;
    settings.layers.add(Layer::Overlap);
    return settings;
}

struct Mode {
    const char* name;
    void (*set)(Params& params);
};
/// Every way through the code.
constexpr Mode kModes[] = {
    {"connect", [](Params&) {}},
    {"connect, three bounces", [](Params& p) { p.bounces = 3, p.filter = SplatFilter::Tent; }},
    {"connect without visibility", [](Params& p) { p.visibility = false, p.repay = false; }},
    {"kernel", [](Params& p) { p.estimator = SplatEstimator::Kernel, p.bounces = 2; }},
    {"kernel without visibility",
     [](Params& p) { p.estimator = SplatEstimator::Kernel, p.visibility = p.shrink = false; }},
    {"normalised",
     [](Params& p) {
         p.weighting = SplatWeighting::Normalised, p.filter = SplatFilter::Gaussian, p.indirect_exposure = 0.5f;
     }},
    {"stratified",
     [](Params& p) { p.stratify = true, p.grid_cells = 16, p.splats_per_cell = 2, p.filter = SplatFilter::Gaussian; }},
    {"normalised and stratified",
     [](Params& p) {
         p.weighting = SplatWeighting::Normalised, p.stratify = true;
         p.representative = Representative::DominantDirection;
     }},
    {"reflective shadow map", [](Params& p) { p.injection = PhotonInjection::ReflectiveShadowMap; }},
    {"several rays", [](Params& p) { p.rays_per_photon = 4, p.estimator = SplatEstimator::Kernel; }},
    {"several rays that connect", [](Params& p) { p.rays_per_photon = 4, p.sampler = SamplerKind::Random; }},
    {"blur", [](Params& p) { p.blur = BlurWidth::Five, p.blur_edges = true, p.ambient = 0.1f; }},
};
Settings in_mode(const Mode& mode, uint32_t passes = 1, uint32_t photons = 400) {
    Settings settings = small(passes, photons);
    mode.set(settings.params);
    return settings;
}

double sum_of(const std::vector<float>& values) { return test::mean_of(values) * double(values.size()); }

void expect_sane(const Film& film) {
    EXPECT_EQ(film.nan_count(), 0u);
    EXPECT_EQ(film.infinity_count(), 0u);
    for (const Layer layer : {Layer::Emitted, Layer::Direct, Layer::Indirect, Layer::Overlap})
        for (const float value : film.resolve(layer)) {
            EXPECT_TRUE(std::isfinite(value));
            EXPECT_GE(value, 0);
        }
}

TEST(PhotonSplatting, PixelHashIsTheSameForAnyNumberOfThreads) {
    for (const char* name : {"cornell-box-glossy", "cornell-box-glass", "interior"}) {
        const Scene scene = make_builtin_scene(name);
        for (const Mode& mode : kModes) {
            // All modes in the scene that has all kinds of photons and receivers, but for glass.
            const size_t index = static_cast<size_t>(&mode - kModes);
            if (std::string_view(name) != "cornell-box-glossy" && index != 1 && index != 3 && index != 6) continue;
            const Settings settings = in_mode(mode, 2);
            std::vector<std::string> hashes;
            for (const int threads : {1, 2, 4})
                hashes.push_back(test::on_threads(threads, [&] { return test::render(scene, settings).pixel_hash(); }));
            EXPECT_EQ(hashes[0], hashes[1]) << name << ", " << mode.name;
            EXPECT_EQ(hashes[0], hashes[2]) << name << ", " << mode.name;
        }
    }
}

// More sources than a batch takes.
TEST(PhotonSplatting, SeveralBatchesAreTheSameForAnyNumberOfThreads) {
    const Scene scene = make_builtin_scene("cornell-box");
    Settings settings = small(1, 80'000);
    settings.size = {16, 16};
    Stats stats;
    const std::string one = test::on_threads(1, [&] { return test::render(scene, settings, &stats).pixel_hash(); });
    EXPECT_GT(stats.counts.splats, 32768u);
    EXPECT_EQ(one, test::on_threads(3, [&] { return test::render(scene, settings).pixel_hash(); }));
}

TEST(PhotonSplatting, RangesOfPassesMergeToTheSameBits) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    for (const Mode& mode : {kModes[0], kModes[3], kModes[6], kModes[11]}) {
        Settings settings = in_mode(mode, 4);
        const Film whole = test::render(scene, settings);
        settings.passes = 2;
        Film first = test::render(scene, settings);
        settings.first_pass = 2;
        const Film second = test::render(scene, settings);
        EXPECT_NE(first.pixel_hash(), second.pixel_hash()) << mode.name;
        first.merge(second);
        EXPECT_EQ(first, whole) << mode.name;
        settings.seed = 2;
        EXPECT_NE(test::render(scene, settings).pixel_hash(), second.pixel_hash()) << mode.name;
    }
}

TEST(PhotonSplatting, NoBouncesLeaveTheLayerBlackAndTraceNoPhotons) {
    for (const Mode& mode : kModes) {
        Settings settings = in_mode(mode);
        settings.params.bounces = 0;
        settings.params.ambient = 0;
        Stats stats;
        const Film film = test::render(make_builtin_scene("cornell-box-glass"), settings, &stats);
        EXPECT_EQ(sum_of(film.resolve(Layer::Indirect)), 0) << mode.name;
        EXPECT_EQ(sum_of(film.resolve(Layer::Overlap)), 0) << mode.name;
        EXPECT_GT(sum_of(film.resolve(Layer::Direct)), 0) << mode.name;
        EXPECT_EQ(stats.counts.photons_emitted, 0u);
        EXPECT_EQ(stats.counts.splats, 0u);
    }
}

TEST(PhotonSplatting, StaysFiniteInEveryBuiltinScene) {
    for (const std::string_view name : builtin_scene_names()) {
        const Scene scene = make_builtin_scene(name);
        for (const Mode& mode : kModes) {
            // A furnished room has many triangles: building its structures takes most of the time.
            const size_t index = static_cast<size_t>(&mode - kModes);
            if (name == "interior" && index != 1 && index != 3 && index != 6) continue;
            Settings settings = in_mode(mode, 1, 200);
            settings.size = {24, 16};
            SCOPED_TRACE(testing::Message() << name << ", " << mode.name);
            expect_sane(test::render(scene, settings));
        }
    }
}

TEST(PhotonSplatting, StaysFiniteWhereThereIsNothingToWorkWith) {
    for (const test::HardScene& hard : test::hard_scenes())
        for (const Mode& mode : kModes)
            for (const uint32_t photons : {1u, 300u}) {
                Settings settings = in_mode(mode, 2, photons);
                settings.size = {16, 16};
                settings.params.ambient = 0;
                SCOPED_TRACE(testing::Message() << hard.name << ", " << photons << " photons, " << mode.name);
                const Film film = test::render(hard.scene, settings);
                expect_sane(film);
                EXPECT_EQ(sum_of(film.resolve_beauty()) == 0, hard.dark);
            }
}

TEST(PhotonSplatting, SplatsOfAnySizeStayFinite) {
    const Scene scene = make_builtin_scene("cornell-box-glossy");
    for (const float size_m : {1e-9f, 1e-4f, 0.01f, 100.0f, 1e9f})
        for (const size_t mode : {0u, 3u, 5u}) {
            Settings settings = in_mode(kModes[mode], 2, 100);
            settings.size = {16, 16};
            settings.params.splat_size_m = size_m;
            SCOPED_TRACE(testing::Message() << size_m << " m, " << kModes[mode].name);
            expect_sane(test::render(scene, settings));
        }
}

// --- layers and counts

TEST(PhotonSplatting, CountsStagesAndMemoryAreReported) {
    const Scene scene = make_builtin_scene("cornell-box");
    const Settings settings = small(2, 2000);
    Stats stats;
    MemoryBudget budget;
    const Film film = test::render(scene, settings, &stats, &budget);
    const uint64_t pixels = settings.size.pixels();
    EXPECT_EQ(stats.counts.camera_rays, 2 * pixels);
    // A light path leaves 1.3 photons in the box, with all their bounces.
    EXPECT_GT(stats.counts.splats, 4000u);
    EXPECT_LE(stats.counts.splats, 6500u);
    Stats one_more;
    Settings longer = settings;
    longer.passes = 3;
    test::render(scene, longer, &one_more);
    EXPECT_EQ(one_more.counts.photons_emitted - stats.counts.photons_emitted, 2000u);
    EXPECT_GE(stats.counts.photons_emitted, 2 * 2000u);
    EXPECT_GT(stats.counts.splat_contributions, stats.counts.splats);
    // Shafts spare most shadow rays of connections; the rest of them are direct light's and the repayment's.
    EXPECT_LT(stats.counts.shadow_rays, stats.counts.splat_contributions + 4 * pixels);
    EXPECT_LE(stats.counts.bounce_rays, 2 * pixels);
    for (const char* stage : {"photon_emission", "photon_tracing", "g_buffer", "direct", "splat", "splat_find",
                              "shaft_build", "repay", "combine"})
        EXPECT_GT(stats.stage(stage).cpu_seconds, 0) << stage;
    for (const char* structure : {"pass_image", "wavefronts", "light_sampler", "emission_sampler", "photon_tracer",
                                  "photons", "visible_points", "splat_batch", "splat_accumulators", "shaft_visibility"})
        EXPECT_GT(budget.structures().at(structure), 0u) << structure;
    for (const char* structure : {"stratification"}) EXPECT_EQ(budget.structures().count(structure), 0u);
}

// The layer counts lit splats: no more than splats, and none where none was seen to reach. It adds up to the
// contributions that no shadow ray took.
TEST(PhotonSplatting, OverlapCountsTheSplatsOverAPixel) {
    const Scene scene = make_builtin_scene("cornell-box");
    for (const size_t mode : {0u, 2u, 4u, 5u}) {
        Settings settings = in_mode(kModes[mode], 1, 1000);
        // Over such a size almost all photons light almost all points.
        settings.params.splat_size_m = 0.3f;
        Stats stats;
        const Film film = test::render(scene, settings, &stats);
        const std::vector<float> overlap = film.resolve(Layer::Overlap), indirect = film.resolve(Layer::Indirect);
        double most = 0;
        for (size_t i = 0; i < overlap.size(); ++i) {
            EXPECT_EQ(overlap[i], std::floor(overlap[i])) << kModes[mode].name;
            most = std::max(most, double{overlap[i]});
            const double light = double{indirect[3 * i]} + indirect[3 * i + 1] + indirect[3 * i + 2];
            // The repayment finds light where splats do not.
            if (!settings.params.repay && overlap[i] == 0) {
                EXPECT_EQ(light, 0) << kModes[mode].name;
            }
            if (overlap[i] > 0) {
                EXPECT_GT(light, 0) << kModes[mode].name;
            }
        }
        EXPECT_LE(most, double(stats.counts.splats));
        EXPECT_GT(most, 0);
        const double sum = sum_of(overlap), contributions = double(stats.counts.splat_contributions);
        EXPECT_LE(sum, contributions) << kModes[mode].name;
        if (!settings.params.visibility) {
            EXPECT_EQ(sum, contributions) << kModes[mode].name;
        }
        EXPECT_GT(sum, 0.2 * contributions) << kModes[mode].name;
    }
}

TEST(PhotonSplatting, AmbientLightsOnlyWhatNoSplatReached) {
    const Scene scene = make_builtin_scene("cornell-box");
    Settings settings = small(1, 200);
    settings.params.adaptive_size = false;
    settings.params.splat_size_m = 0.2f;
    settings.params.repay = false;
    const Film without = test::render(scene, settings);
    settings.params.ambient = 0.25f;
    settings.layers.add(Layer::Albedo);
    const Film with = test::render(scene, settings);
    const std::vector<float> dark = without.resolve(Layer::Indirect), lit = with.resolve(Layer::Indirect),
                             overlap = with.resolve(Layer::Overlap), albedo = with.resolve(Layer::Albedo);
    size_t filled = 0, reached = 0;
    for (size_t i = 0; i < overlap.size(); ++i)
        for (size_t c = 3 * i; c < 3 * i + 3; ++c) {
            if (overlap[i] > 0) {
                EXPECT_EQ(lit[c], dark[c]);
                ++reached;
            } else {
                // Radiance from all around, reflected by a Lambert surface. Lamps have no visible point.
                EXPECT_EQ(dark[c], 0);
                if (lit[c] > 0) {
                    EXPECT_NEAR(lit[c], 0.25f * albedo[c], 1e-5f);
                }
                filled += lit[c] > 0;
            }
        }
    EXPECT_GT(filled, 500u);
    EXPECT_GT(reached, 20u);
}

TEST(PhotonSplatting, IndirectExposureScalesTheLayer) {
    const Scene scene = make_builtin_scene("cornell-box-glossy");
    Settings settings = in_mode(kModes[5]);
    settings.params.indirect_exposure = 1;
    const Film one = test::render(scene, settings);
    settings.params.indirect_exposure = 0.25f;
    const Film quarter = test::render(scene, settings);
    settings.params.indirect_exposure = 0;
    const Film none = test::render(scene, settings);
    EXPECT_EQ(one.resolve(Layer::Direct), quarter.resolve(Layer::Direct));
    // What specular parts of the walk carry is no splat's, and not scaled.
    const std::vector<float> a = one.resolve(Layer::Indirect), b = quarter.resolve(Layer::Indirect),
                             rest = none.resolve(Layer::Indirect);
    for (size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(b[i] - rest[i], 0.25f * (a[i] - rest[i]), 1e-5f * a[i]);
    EXPECT_GT(sum_of(a), sum_of(b));
}

// Colour over weight is a mean of colours, however many photons a splat stands for: a weight on one side alone would
// show as a factor of dozens, which is how many photons a cell holds here.
TEST(PhotonSplatting, NormalisedSplatsOfCellsAreAsBrightAsThoseOfPhotons) {
    const Scene scene = make_builtin_scene("cornell-box-spot");
    Settings settings = small(4, 4000);
    settings.params.weighting = SplatWeighting::Normalised;
    Stats of_photons, of_cells;
    const double alone = sum_of(test::render(scene, settings, &of_photons).resolve(Layer::Indirect));
    settings.params.stratify = true;
    settings.params.grid_cells = 4;
    const double together = sum_of(test::render(scene, settings, &of_cells).resolve(Layer::Indirect));
    ASSERT_GT(of_photons.counts.splats, 20 * of_cells.counts.splats);
    // Between them is which splats meet, and how obliquely: a factor that has no closed form, but is of order one.
    EXPECT_GT(together, alone / 3);
    EXPECT_LT(together, alone * 3);
}

TEST(PhotonSplatting, BlurKeepsTheMean) {
    const Scene scene = make_builtin_scene("cornell-box");
    Settings settings = small(1, 300);
    const Film sharp = test::render(scene, settings);
    settings.params.blur = BlurWidth::Nine;
    const Film blurred = test::render(scene, settings);
    EXPECT_EQ(sharp.resolve(Layer::Direct), blurred.resolve(Layer::Direct));
    const std::vector<float> a = sharp.resolve(Layer::Indirect), b = blurred.resolve(Layer::Indirect);
    // The border's pixels weigh less: the image of a closed room is as bright there.
    EXPECT_NEAR(sum_of(b) / sum_of(a), 1, 0.05);
    const auto differences = [&](const std::vector<float>& values) {
        double sum = 0;
        for (size_t i = 3; i < values.size(); ++i) sum += double{std::fabs(values[i] - values[i - 3])};
        return sum;
    };
    EXPECT_LT(differences(b), 0.5 * differences(a));
}

TEST(PhotonSplatting, ConvergesWithAnyNumberOfRaysPerPhoton) {
    // Same photons, their power over n rays: the light of the layer stays about the same.
    const Scene scene = make_builtin_scene("cornell-box");
    std::vector<double> means;
    for (const uint32_t rays : {1u, 4u}) {
        Settings settings = small(4, 2000);
        settings.params.rays_per_photon = rays;
        Stats stats;
        means.push_back(test::mean_of(test::render(scene, settings, &stats).resolve(Layer::Indirect)));
        EXPECT_EQ(stats.counts.splats % rays, 0u);
    }
    EXPECT_NEAR(means[1] / means[0], 1, 0.1);
}

// --- parameters

void expect_conflict(const Params& params, const char* pointer) {
    try {
        params.check();
        FAIL() << "accepted, though " << pointer << " contradicts";
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::Conflict);
        ASSERT_EQ(error.faults.size(), 1u);
        EXPECT_EQ(error.faults[0].pointer, pointer);
    }
}

TEST(PhotonSplatting, ParametersThatExcludeEachOtherAreRefused) {
    EXPECT_NO_THROW(Params().check());
    Params sizes;
    sizes.splat_size_m = 0.1f;
    EXPECT_NO_THROW(sizes.check());
    sizes.splat_size_relative = 0.1f;
    expect_conflict(sizes, "/splat_size_relative");

    Params bounces;
    bounces.injection = PhotonInjection::ReflectiveShadowMap;
    EXPECT_NO_THROW(bounces.check());  // by default as many as there can be
    bounces.bounces = 1;
    EXPECT_NO_THROW(bounces.check());
    bounces.bounces = 2;
    expect_conflict(bounces, "/bounces");

    Params exposure;
    exposure.indirect_exposure = 0.5f;
    expect_conflict(exposure, "/indirect_exposure");
    exposure.weighting = SplatWeighting::Normalised;
    EXPECT_NO_THROW(exposure.check());
}

TEST(PhotonSplatting, ACancelledPassLeavesNothing) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    MemoryBudget budget;
    Stats stats;
    const auto intersector = make_embree_intersector(scene, budget, stats);
    PhotonSplattingParams params;
    params.photons = 500;
    const RenderContext context{scene, intersector.get(), View{find_camera(scene, ""), {40, 35}}, 1, budget};
    PhotonSplatting method(params);
    method.begin(context, stats);
    Film film({40, 35}, {});
    CancelToken cancel;
    cancel.cancel();
    method.run_pass(0, stats, cancel);
    method.resolve(film);
    EXPECT_EQ(film.passes(), 0u);
    method.run_pass(0, stats, CancelToken{});
    method.resolve(film);
    EXPECT_EQ(film.passes(), 1u);
    method.run_pass(1, stats, cancel);
    method.resolve(film);
    EXPECT_EQ(film.passes(), 1u);
    // What was left unfinished does not show in the pass that follows.
    method.run_pass(1, stats, CancelToken{});
    method.resolve(film);
    PhotonSplatting undisturbed(params);
    undisturbed.begin(context, stats);
    Film other({40, 35}, {});
    for (const uint32_t pass : {0u, 1u}) {
        undisturbed.run_pass(pass, stats, CancelToken{});
        undisturbed.resolve(other);
    }
    EXPECT_EQ(film, other);
}

// --- memory

TEST(PhotonSplatting, MemoryIsEstimatedToAFactorOfTwo) {
    constexpr double kWithin = 2;  // open scenes have fewer pairs of splats and clusters than closed rooms
    for (const std::string_view name : builtin_scene_names()) {
        const Scene scene = make_builtin_scene(name);
        for (const bool stratify : {false, true}) {
            Settings settings;
            settings.size = {128, 96};
            settings.params.stratify = stratify;
            MemoryBudget budget;
            test::render(scene, settings, nullptr, &budget);
            const auto estimate =
                double(PhotonSplatting::estimate_bytes(settings.params, test::workload_of(scene, settings)));
            const double ratio = estimate / double(budget.accounted_bytes());
            std::printf("%-20s %-10s estimated %6.2f MB, %.2f of what was counted\n", std::string(name).c_str(),
                        stratify ? "stratified" : "default", estimate / 1e6, ratio);
            EXPECT_LT(ratio, kWithin) << name;
            EXPECT_GT(ratio, 1 / kWithin) << name;
        }
    }
}

TEST(PhotonSplatting, RefusesWhatDoesNotFit) {
    Settings settings = small();
    settings.params.photons = 10'000'000;
    MemoryBudget budget(32 << 20);
    EXPECT_THROW(test::render(make_builtin_scene("cornell-box"), settings, nullptr, &budget), Error);
}

}  // namespace
}  // namespace photond::photon_splatting_test
