#include "renderer/progressive/point_radii.h"

#include <algorithm>
#include <cstring>
#include <vector>

#include "protocol/error.h"
#include "renderer/core/parallel.h"
#include "renderer/scene/scene.h"

namespace photond {

namespace {

constexpr size_t kGrain = 4096;
constexpr float kFirstTest = 16;        // photons since the last change after which curved light is first looked for
constexpr float kHalved = 0.70710678f;  // the radius, where its square is halved

// What is known of a pixel's discs in one map: 4-byte numbers alone, as they are saved. `radius_m` 0: never asked for.
// The same record sums what one pass gathers.

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
    float next_test = kFirstTest;

    static constexpr bool kWantsMoments = true;
    void take(const Point& pass, float) {
        if (pass.photons == 0) return;
        auto& self = static_cast<Point&>(*this);
        photons += pass.photons, w_sq += pass.w_sq;
        self.add(pass);
        if (photons < next_test) return;
        while (photons >= next_test) next_test *= 2;
        if (!self.is_curved()) return;
        const float halved_m = kHalved * radius_m;
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
    bool is_curved() const {
        constexpr float kCurved = 2.5f;
        return 3 * sqr(w_t) > sqr(kCurved) * w_sq;
    }
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
        constexpr float kCurved = 18.0f;
        float mean = 0, squares = 0;
        for (const float w : sectors) mean += w / static_cast<float>(sectors.size());
        for (const float w : sectors) squares += sqr(w - mean);
        return static_cast<float>(sectors.size()) * squares > kCurved * w_sq;
    }
};

/// Before the points in a saved state.
struct StateHeader {
    uint32_t version = 1;
    uint32_t point_bytes = 0;
    uint32_t sets = 0;
    uint32_t reserved = 0;
    uint64_t pixels = 0;
    PerMap<uint64_t> points{};

    bool operator==(const StateHeader&) const = default;
};

template <class Point>
class PointRadii final : public DiscRadii {
public:
    PointRadii(const DiscRadiiInputs& inputs, Stats& stats);

    void begin_pass(uint32_t pass) override;
    float radius_m(PhotonMapKind kind, const DiscPlace& place, Neighbours& scratch) override;
    bool wants_moments() const override { return Point::kWantsMoments; }
    void gathered(PhotonMapKind kind, const DiscPlace& place, const RadianceEstimate& estimate,
                  const DiscMoments& moments) override {
        pass_[index_of(kind)][place.pixel].gather(estimate, moments);
    }
    void end_pass() override;
    std::string state() const override;
    uint64_t bytes() const override;

private:
    Point& of(std::vector<Point>& points, uint32_t pixel) { return points[set_ * pixels_ + pixel]; }
    StateHeader header() const;
    void restore(const std::string& state);

    const float alpha_;
    const uint32_t sets_;
    const size_t pixels_;
    const RadiusLimits limits_;
    const std::optional<float> first_m_;
    PerMap<PhotonMap> pilots_;           // where the first radius is not given
    uint32_t set_ = 0;                   // of the pass
    PerMap<std::vector<Point>> points_;  // set by set
    PerMap<std::vector<Point>> pass_;    // gathered by the pass begun
};

template <class Point>
PointRadii<Point>::PointRadii(const DiscRadiiInputs& inputs, Stats& stats)
    : alpha_(inputs.params.alpha),
      sets_(inputs.hit_point_sets),
      pixels_(inputs.context.view.film_size.pixels()),
      limits_(inputs.context.scene.bounds.radius()),
      first_m_(inputs.params.first_radius_m(inputs.context.scene.bounds.radius())) {
    for (const PhotonMapKind kind : kPhotonMapKinds) {
        if (!inputs.photons.wanted(kind)) continue;
        points_[index_of(kind)].resize(sets_ * pixels_);
        pass_[index_of(kind)].resize(pixels_);
        if (first_m_) continue;
        std::vector<Photon> pilot = inputs.photons.trace_pilot(kind, 1, stats);
        const StageTimer timer(stats, "photon_map_build");
        pilots_[index_of(kind)] =
            PhotonMap(std::move(pilot), {PhotonSearch::Kind::Nearest, inputs.params.nearest_photons, limits_.most_m});
    }
    if (!inputs.state.empty()) restore(inputs.state);
}

template <class Point>
void PointRadii<Point>::begin_pass(uint32_t pass) {
    set_ = pass % sets_;
    for (std::vector<Point>& points : pass_) std::ranges::fill(points, Point{});
}

template <class Point>
float PointRadii<Point>::radius_m(PhotonMapKind kind, const DiscPlace& place, Neighbours& scratch) {
    if (const float known_m = of(points_[index_of(kind)], place.pixel).radius_m; known_m > 0) return known_m;
    float& first_m = pass_[index_of(kind)][place.pixel].radius_m;
    if (first_m > 0) return first_m;
    if (first_m_) return first_m = *first_m_;
    pilots_[index_of(kind)].find(place.position, scratch);
    return first_m = std::clamp(scratch.radius_m, limits_.least_m, limits_.most_m);
}

template <class Point>
void PointRadii<Point>::end_pass() {
    for (const PhotonMapKind kind : kPhotonMapKinds) {
        const std::vector<Point>& gathered = pass_[index_of(kind)];
        std::vector<Point>& points = points_[index_of(kind)];
        parallel_for(gathered.size(), kGrain, [&](size_t pixel) {
            Point& point = of(points, static_cast<uint32_t>(pixel));
            if (point.radius_m == 0) point.radius_m = gathered[pixel].radius_m;
            point.take(gathered[pixel], alpha_);
        });
    }
}

template <class Point>
StateHeader PointRadii<Point>::header() const {
    StateHeader header{.point_bytes = sizeof(Point), .sets = sets_, .pixels = pixels_};
    for (size_t map = 0; map < points_.size(); ++map) header.points[map] = points_[map].size();
    return header;
}

template <class Point>
std::string PointRadii<Point>::state() const {
    const StateHeader own = header();
    std::string state(reinterpret_cast<const char*>(&own), sizeof own);
    for (const std::vector<Point>& points : points_)
        state.append(reinterpret_cast<const char*>(points.data()), points.size() * sizeof(Point));
    return state;
}

template <class Point>
void PointRadii<Point>::restore(const std::string& state) {
    size_t bytes = sizeof(StateHeader);
    for (const std::vector<Point>& points : points_) bytes += points.size() * sizeof(Point);
    StateHeader saved;
    if (state.size() >= sizeof saved) std::memcpy(&saved, state.data(), sizeof saved);
    if (state.size() != bytes || !(saved == header()))
        throw Error(ErrorCode::Conflict, "the radii kept with the film are not of this job");
    size_t at = sizeof saved;
    for (std::vector<Point>& points : points_) {
        const size_t size = points.size() * sizeof(Point);
        if (size > 0) std::memcpy(points.data(), state.data() + at, size);
        at += size;
    }
}

template <class Point>
uint64_t PointRadii<Point>::bytes() const {
    uint64_t bytes = 0;
    for (size_t map = 0; map < points_.size(); ++map)
        bytes += (points_[map].capacity() + pass_[map].capacity()) * sizeof(Point) + pilots_[map].bytes();
    return bytes;
}

/// Calls function(point) with a record of the rule's kind.
template <class Function>
auto with_point_of(const ProgressiveParams& params, const Function& function) {
    if (params.radius_rule == RadiusRule::Local) return function(LocalPoint());
    if (params.test == CurvatureTest::Radial) return function(RadialPoint());
    return function(SectorPoint());
}

}  // namespace

std::unique_ptr<DiscRadii> make_point_radii(const DiscRadiiInputs& inputs, Stats& stats) {
    return with_point_of(inputs.params, [&](const auto& point) -> std::unique_ptr<DiscRadii> {
        return std::make_unique<PointRadii<std::decay_t<decltype(point)>>>(inputs, stats);
    });
}

DiscRadiiBytes point_radii_bytes(const ProgressiveParams& params, uint32_t hit_point_sets, const Workload& workload) {
    const uint64_t point_bytes = with_point_of(params, [](const auto& point) { return uint64_t{sizeof point}; });
    const uint64_t points_of_set = workload.film_size.pixels() * point_bytes;
    DiscRadiiBytes bytes{.state = sizeof(StateHeader)};
    for (const PhotonMapKind kind : kPhotonMapKinds) {
        const uint64_t photons = ProgressivePhotons::expected_photons(kind, params, workload);
        if (photons == 0) continue;
        bytes.state += hit_point_sets * points_of_set;
        bytes.kept +=
            (hit_point_sets + 1) * points_of_set + photons * sizeof(PhotonPayload) + KdTree::bytes_for(photons);
    }
    return bytes;
}

}  // namespace photond
