// Lights placed by what their paths bring to the picture: they send as much light as those placed by flux, and where
// the picture sees it they are more; a pass depends on nothing but its index, and has no more paths than it may.

#include "renderer/many_lights/path_selection.h"

#include <gtest/gtest.h>

#include <array>
#include <cstring>

#include "renderer/error/student_t.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/pose.h"
#include "tests/support/photons.h"
#include "tests/support/render.h"
#include "tests/support/statistics.h"
#include "tests/support/threads.h"

namespace photond::path_selection_test {
namespace {

using test::PhotonScene;
constexpr uint32_t kVpls = 96;
constexpr float kClampSqM2 = 0.02f;

/// A room whose light comes through a door: most paths bring the picture nothing.
struct Rooms {
    explicit Rooms(VplPlacement where, Scene scene = make_builtin_scene("doors/ajar"))
        : placement(where),
          lit(std::move(scene)),
          tracer(
              lit.scene, *lit.intersector, *lit.intersector, lit.emission,
              {.vpls = kVpls, .map_side = 32, .bounces = 3, .independent_paths = where == VplPlacement::Metropolis}) {
        if (!selects_paths(placement)) return;
        Stats stats;
        pilot.emplace(find_path_pilot(placement, tracer, seen_by(0), *lit.intersector, kVpls, 1, stats));
    }

    /// Points that are others from pass to pass, as a G-buffer's are.
    CameraImportance seen_by(uint32_t pass) const {
        return {lit.scene, *lit.intersector, {find_camera(lit.scene, ""), {32, 24}, {}, {}}, kClampSqM2, 1000 + pass};
    }
    TracedReflections trace(uint32_t pass, Stats& stats) const {
        if (!pilot) return tracer.trace(1, pass, {}, stats, CancelToken{});
        return trace_by_worth(placement, *pilot, tracer, seen_by(pass), *lit.intersector, kVpls, 1, pass, stats,
                              CancelToken{});
    }

    const VplPlacement placement;
    const PhotonScene lit;
    const VplTracer tracer;
    std::optional<PathPilot> pilot;
};

/// What a pass's lights come to: flux that is left after one scattering, two and three, and what is near two places.
constexpr size_t kSums = 5;
std::array<double, kSums> sums_of(const TracedReflections& lights) {
    std::array<double, kSums> sums{};
    for (const ReflectedPhoton& light : lights.photons) {
        const double flux = double{light.power_w.y};
        sums[std::min(light.scatterings(), 3u) - 1] += flux;
        const vec3 low(0.4f, -0.6f, 0.4f), high(-0.6f, 0.6f, -0.4f);
        sums[3] += flux / (1 + 4 * double{glm::dot(light.position - low, light.position - low)});
        sums[4] += flux / (1 + 4 * double{glm::dot(light.position - high, light.position - high)});
    }
    return sums;
}

/// How many runs a mean is of, and the relative error that the means must be good enough to notice.
struct Plan {
    uint32_t by_flux, of_chains;
    double must_notice;
};
/// Compares the means of each placement with those of flux.
void expect_the_means_of_flux(const Scene& scene, const Plan& plan, size_t tests) {
    constexpr double kFalseAlarm = 1e-6;  // of all means together, whatever the seed
    const auto means_of = [&](VplPlacement placement, uint32_t passes) {
        const Rooms rooms(placement, scene);
        std::array<test::RunningMean, kSums> means;
        Stats stats;
        for (uint32_t pass = 0; pass < passes; ++pass) {
            const std::array<double, kSums> sums = sums_of(rooms.trace(pass, stats));
            for (size_t i = 0; i < kSums; ++i) means[i].add(sums[i]);
        }
        return means;
    };
    const auto by_flux = means_of(VplPlacement::Flux, plan.by_flux);
    for (const VplPlacement placement : {VplPlacement::Acceptance, VplPlacement::Metropolis}) {
        const auto means = means_of(placement, placement == VplPlacement::Metropolis ? plan.of_chains : plan.by_flux);
        for (size_t i = 0; i < kSums; ++i) {
            // Welch's, with the fewer degrees of freedom.
            const double error = std::hypot(means[i].standard_error(), by_flux[i].standard_error());
            const double width =
                error *
                two_sided_student_t(1 - test::share_of_false_alarm(kFalseAlarm, 2 * kSums * tests), plan.by_flux - 1);
            EXPECT_NEAR(means[i].mean(), by_flux[i].mean(), width) << int(placement) << ", sum " << i;
            EXPECT_LT(2 * width, plan.must_notice * by_flux[i].mean()) << int(placement) << ", sum " << i;
        }
    }
}

TEST(PathSelection, LeavesTheMeanOfFluxWhereItIs) {
    expect_the_means_of_flux(make_builtin_scene("cornell-box"), {500, 2500, 0.15}, 1);
}

// Every fourth frame of an animation, 64 runs each.
TEST(PathSelection, LeavesTheMeanOfFluxWhereItIsWhateverMoves) {
    Scene scene = make_builtin_scene("moving/cornell-box");
    constexpr double kFrames_per_second = 8;
    for (const int frame : {0, 4, 8, 12}) {
        SCOPED_TRACE(frame);
        pose_scene(scene, {0, frame / kFrames_per_second});
        expect_the_means_of_flux(scene, {64, 64, 1.2}, 4);
    }
}

// Whatever passes come before, and however many threads there are.
TEST(PathSelection, IsAPureFunctionOfThePass) {
    for (const VplPlacement placement : {VplPlacement::Acceptance, VplPlacement::Metropolis}) {
        const auto bits_of = [](const TracedReflections& lights) {
            std::string bits(lights.photons.size() * sizeof(ReflectedPhoton), '\0');
            if (!bits.empty()) std::memcpy(bits.data(), lights.photons.data(), bits.size());
            return bits;
        };
        Stats stats;
        const Rooms rooms(placement);
        const std::string third = bits_of(rooms.trace(2, stats));
        EXPECT_NE(bits_of(rooms.trace(1, stats)), third);
        EXPECT_EQ(bits_of(rooms.trace(2, stats)), third);
        for (const int threads : {1, 4}) {
            const auto again = test::on_threads(threads, [&] { return bits_of(Rooms(placement).trace(2, stats)); });
            EXPECT_EQ(again, third) << threads;
        }
    }
}

TEST(PathSelection, HasAboutAsManyPathsAsItMayAndPrefersWhatIsSeen) {
    const auto share_in_room = [](const TracedReflections& lights) {
        double in_room = 0;
        for (const ReflectedPhoton& light : lights.photons) in_room += light.position.z > -1.6f ? 1 : 0;
        return in_room / double(lights.photons.size());
    };
    Stats by_flux;
    const double plain = share_in_room(Rooms(VplPlacement::Flux).trace(0, by_flux));
    EXPECT_EQ(by_flux.counts.vpls_offered + by_flux.counts.vpls_accepted, 0u);
    for (const VplPlacement placement : {VplPlacement::Acceptance, VplPlacement::Metropolis}) {
        const Rooms rooms(placement);
        Stats stats;
        double share = 0, paths = 0;
        uint64_t accepted = 0, offered = 0;
        for (uint32_t pass = 0; pass < 8; ++pass) {
            const TracedReflections lights = rooms.trace(pass, stats);
            share += share_in_room(lights) / 8;
            paths += double(lights.paths) / 8;
            EXPECT_LE(lights.paths, kVpls);
            accepted += lights.counts.vpls_accepted, offered += lights.counts.vpls_offered;
        }
        EXPECT_GT(share, 1.5 * plain) << int(placement);
        EXPECT_GT(paths, 0.7 * kVpls) << int(placement);
        EXPECT_GT(accepted, 0u) << int(placement);
        EXPECT_LT(accepted, offered) << int(placement);
    }
}

// Where nothing that the eye sees is lit, all paths are alike.
TEST(PathPilot, TakesAllPathsWhereNoneIsWorthMore) {
    const std::vector<float> nothing(64, 0.0f);
    const PathPilot pilot(VplPlacement::Acceptance, nothing, 100);
    EXPECT_EQ(pilot.candidates, 100u);
    EXPECT_EQ(pilot.target(0), 1);
    EXPECT_EQ(pilot.target(7), 1);
    // One in four has it all: it is kept for certain, the others by the least chance.
    std::vector<float> few(64, 0.0f);
    for (size_t i = 0; i < few.size(); i += 4) few[i] = 2;
    const PathPilot led(VplPlacement::Acceptance, few, 100);
    EXPECT_FLOAT_EQ(led.mean_worth, 0.5f);
    EXPECT_EQ(led.candidates, static_cast<uint32_t>(std::ceil(100 / (0.25 + 0.75 * double{PATH_LEAST_TARGET}))));
    EXPECT_EQ(led.target(std::numeric_limits<float>::quiet_NaN()), PATH_LEAST_TARGET);
}

}  // namespace
}  // namespace photond::path_selection_test
