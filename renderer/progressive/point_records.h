#pragma once
// What is known of the discs of one pixel in one map (point_radii.h): records of 4-byte numbers alone, as they are
// saved with the film and as shaders have them (point_radii.glsl).

#include <array>
#include <cmath>
#include <span>
#include <string>

#include "renderer/photons/radiance_estimate.h"
#include "renderer/progressive/point_radii_shared.h"
#include "renderer/progressive/progressive_photons.h"

namespace photond {

// `radius_m` 0: never asked for. The same record sums what one pass gathers.

struct LocalPoint {
    float radius_m = 0;
    float photons = 0;  // N

    static constexpr bool kWantsMoments = false;
    void gather(const RadianceEstimate& found, const DiscMoments&) { photons += static_cast<float>(found.scattered); }
    void take(const LocalPoint& pass, float alpha) {
        if (pass.photons == 0) return;
        const float kept = photons + alpha * pass.photons;
        radius_m *= std::sqrt(kept / (photons + pass.photons));
        photons = kept;
    }
};

/// What both tests have in common; sums are since the last change.
template <class Point>
struct TestedPoint {
    float radius_m = 0;
    float photons = 0;
    float w_sq = 0;
    float next_test = POINT_FIRST_TEST;

    static constexpr bool kWantsMoments = true;
    void take(const Point& pass, float) {
        if (pass.photons == 0) return;
        auto& self = static_cast<Point&>(*this);
        photons += pass.photons, w_sq += pass.w_sq;
        self.add(pass);
        if (photons < next_test) return;
        while (photons >= next_test) next_test *= 2;
        if (!self.is_curved()) return;
        const float halved_m = POINT_HALVED * radius_m;
        self = Point();
        radius_m = halved_m;
    }

protected:
    void gather_common(const RadianceEstimate& found, const DiscMoments& moments) {
        photons += static_cast<float>(found.scattered);
        w_sq += static_cast<float>(moments.w_sq);
    }
};

struct RadialPoint : TestedPoint<RadialPoint> {
    float w_t = 0;

    void gather(const RadianceEstimate& found, const DiscMoments& moments) {
        gather_common(found, moments);
        w_t += static_cast<float>(moments.w_t);
    }
    void add(const RadialPoint& pass) { w_t += pass.w_t; }
    /// By z = sqrt(3) w_t / sqrt(w_sq), which even light makes standard normal: chance does it once in 80 times.
    bool is_curved() const { return 3 * sqr(w_t) > sqr(POINT_RADIAL_CURVED) * w_sq; }
};

struct SectorPoint : TestedPoint<SectorPoint> {
    std::array<float, DiscMoments::kSectors> sectors{};

    void gather(const RadianceEstimate& found, const DiscMoments& moments) {
        gather_common(found, moments);
        for (size_t s = 0; s < sectors.size(); ++s) sectors[s] += static_cast<float>(moments.sectors[s]);
    }
    void add(const SectorPoint& pass) {
        for (size_t s = 0; s < sectors.size(); ++s) sectors[s] += pass.sectors[s];
    }
    /// By chi-squared of seven degrees of freedom, as seldom by chance as the radial test.
    bool is_curved() const {
        float mean = 0, squares = 0;
        for (const float w : sectors) mean += w / static_cast<float>(sectors.size());
        for (const float w : sectors) squares += sqr(w - mean);
        return static_cast<float>(sectors.size()) * squares > POINT_SECTOR_CURVED * w_sq;
    }
};

/// Calls function(point) with a record of the rule's kind.
template <class Function>
auto with_point_of(const ProgressiveParams& params, const Function& function) {
    if (params.radius_rule == RadiusRule::Local) return function(LocalPoint());
    if (params.test == CurvatureTest::Radial) return function(RadialPoint());
    return function(SectorPoint());
}

/// Of the rule's record.
inline uint64_t bytes_of_point(const ProgressiveParams& params) {
    return with_point_of(params, [](const auto& point) { return uint64_t{sizeof point}; });
}

/// What a saved state is of.
struct SavedPoints {
    uint64_t point_bytes, sets, pixels;  // sets of hit points

    static constexpr uint64_t kHeaderBytes = 40;
};
/// `points`: those of each map, set by set.
std::string save_points(const SavedPoints& kind, const PerMap<std::span<const std::byte>>& points);
/// Fills them again. Throws ErrorCode::Conflict for a state that is not of that kind and size.
void restore_points(const std::string& state, const SavedPoints& kind, const PerMap<std::span<std::byte>>& points);
/// Throws ErrorCode::Conflict where there is a state and the rule has none, or the other way round.
void check_points_to_go_on_from(const ProgressiveParams& params, const std::string& state);
/// The state of a render that needs no photons.
inline constexpr const char* kNoPoints = "no photons";

}  // namespace photond
