#include "renderer/progressive/point_radii.h"

#include <algorithm>
#include <vector>

#include "renderer/core/parallel.h"
#include "renderer/progressive/point_records.h"
#include "renderer/scene/scene.h"

namespace photond {

namespace {

constexpr size_t kGrain = 4096;

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
    SavedPoints kind_of_points() const { return {sizeof(Point), sets_, pixels_}; }

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
    if (!inputs.state.empty()) {
        PerMap<std::span<std::byte>> saved;
        for (size_t map = 0; map < saved.size(); ++map) saved[map] = std::as_writable_bytes(std::span(points_[map]));
        restore_points(inputs.state, kind_of_points(), saved);
    }
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
std::string PointRadii<Point>::state() const {
    PerMap<std::span<const std::byte>> points;
    for (size_t map = 0; map < points.size(); ++map) points[map] = std::as_bytes(std::span(points_[map]));
    return save_points(kind_of_points(), points);
}

template <class Point>
uint64_t PointRadii<Point>::bytes() const {
    uint64_t bytes = 0;
    for (size_t map = 0; map < points_.size(); ++map)
        bytes += (points_[map].capacity() + pass_[map].capacity()) * sizeof(Point) + pilots_[map].bytes();
    return bytes;
}

}  // namespace

std::unique_ptr<DiscRadii> make_point_radii(const DiscRadiiInputs& inputs, Stats& stats) {
    return with_point_of(inputs.params, [&](const auto& point) -> std::unique_ptr<DiscRadii> {
        return std::make_unique<PointRadii<std::decay_t<decltype(point)>>>(inputs, stats);
    });
}

DiscRadiiBytes point_radii_bytes(const ProgressiveParams& params, uint32_t hit_point_sets, const Workload& workload) {
    const uint64_t points_of_set = workload.film_size.pixels() * bytes_of_point(params);
    DiscRadiiBytes bytes{.state = SavedPoints::kHeaderBytes};
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
