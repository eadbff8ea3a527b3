#include "renderer/photons/radiance_estimate.h"

#include "renderer/photons/disc_photons.h"

namespace photond {

namespace {

/// Calls take(payload, weight, side, spot) for each of the photons found that lies on the disc; `weight` is K r^2, and
/// the spot's sector is told where moments are asked for. Returns how many there were.
template <class Structure, class Take>
uint32_t take_photons(const Structure& structure, const PhotonMap& map, const EstimateSettings& settings,
                      const Disc& disc, const DiscTest& test, float thickness_m, const Neighbours& found,
                      const Take& take) {
    const float inverse_radius_sq = 1 / sqr(found.radius_m);
    const bool tells_sectors = disc.query.moments != nullptr;
    const Frame frame(disc.normal);
    uint32_t taken = 0;
    // Payloads lie where no search has been yet: waiting for them one by one would take longer than all the rest.
    for (const Neighbours::Found& f : found.found) __builtin_prefetch(&map.payload(f.index).normal_and_path);
    for (const Neighbours::Found& f : found.found) {
        const PhotonPayload& payload = map.payload(f.index);
        const float height_m = test.height_m(structure.position(f.index));
        const float side = test.side(payload, height_m);
        if (side == 0) continue;
        DiscSpot spot{f.distance_sq_m2 * inverse_radius_sq, 0};
        if (tells_sectors) spot.sector = sector_of(frame, structure.position(f.index) - disc.position);
        float weight = settings.kernel(spot.q_sq);
        if (settings.soft_disc) weight *= std::fabs(side) * (thickness_m > 0 ? 1 - height_m / thickness_m : 1.0f);
        take(payload, weight, side, spot);
        ++taken;
    }
    return taken;
}

/// Takes the photons out that the clipped disc hides and returns one over its mass; 0 where no photon is left.
float clip(const PhotonMap& map, const EstimateSettings& settings, const Disc& disc, const DiscTest& test,
           float thickness_m, Neighbours& found) {
    // Rays cost the most by far: what the disc refuses without one goes first, and a disc without photons has no need
    // of its mass.
    std::vector<Neighbours::Found>& photons = found.found;
    std::erase_if(photons, [&](const Neighbours::Found& f) {
        return test.side(map.payload(f.index), test.height_m(map.position(f.index))) == 0;
    });
    if (photons.empty()) return 0;
    const CoverageDisc surface{disc.position, disc.normal, found.radius_m, thickness_m};
    const DiscProbe probe(*settings.coverage, settings.kernel, surface, disc.query.turn, disc.query.care);
    return probe.clip(photons, [&](const Neighbours::Found& f) { return map.position(f.index); });
}

/// What sums of weight x power are to be multiplied by, and what was found.
struct DiscSum {
    float scale_per_m2 = 0;
    uint32_t photons = 0;
    float radius_m = 0;
};

template <class Take>
DiscSum sum_over_disc(const PhotonMap& map, const EstimateSettings& settings, const Disc& disc, Neighbours& scratch,
                      const Take& take) {
    if (disc.query.radius_m)
        map.find_within(disc.position, *disc.query.radius_m, scratch);
    else
        map.find(disc.position, scratch);
    DiscSum sum;
    sum.radius_m = scratch.radius_m;
    if (scratch.radius_m > disc.query.most_radius_m) return sum;
    // As many photons as are looked for in one place leave no disc to spread them over: no density, and of that place
    // without area no light. Nor is there one where a disc is without end.
    const float area = sqr(scratch.radius_m);
    if (scratch.found.empty() || !(area >= std::numeric_limits<float>::min() && area < kInfinity)) return sum;
    const float thickness_m = disc_thickness_m(settings, scratch.radius_m);
    const DiscTest test(settings, disc, thickness_m);
    float inverse_mass = 1;
    if (settings.coverage != nullptr && settings.coverage->may_be_cut(disc.position, scratch.radius_m))
        inverse_mass = clip(map, settings, disc, test, thickness_m, scratch);
    if (inverse_mass == 0) return sum;
    if (const KdTree* tree = map.kd_tree()) {
        sum.photons = take_photons(*tree, map, settings, disc, test, thickness_m, scratch, take);
    } else {
        sum.photons = take_photons(*map.hash_grid(), map, settings, disc, test, thickness_m, scratch, take);
    }
    if (sum.photons == 0) return sum;
    sum.scale_per_m2 = inverse_mass / area;
    return sum;
}

}  // namespace

RadianceEstimate estimate_radiance(const PhotonMap& map, const EstimateSettings& settings, const ShadingPoint& point,
                                   const Bsdf& bsdf, const vec3& wo, uint32_t most_scatterings, Neighbours& scratch,
                                   const DiscQuery& query) {
    RadianceEstimate estimate;
    if (!bsdf.has_non_delta()) return estimate;
    const vec3 normal = point.geometric_normal;
    const Disc disc{point.position, normal, bsdf.has_non_delta_transmission(), most_scatterings, query};
    Rgb factor(1);
    DiscSum sum;
    if (bsdf.is_lambert() && point.shading.normal == normal) {
        // The same share of every photon; that it arrived at this side its normal says.
        if (wo.z <= 0) return estimate;
        factor = bsdf.f_cos(wo, vec3(0, 0, 1));
        const auto add = [&](const PhotonPayload& photon, float weight) {
            const Rgb reflected = weight * photon.power_w;
            estimate.radiance += reflected;
            estimate.delta_radiance += photon.all_delta() ? reflected : Rgb(0);
        };
        if (query.moments == nullptr) {
            sum = sum_over_disc(
                map, settings, disc, scratch,
                [&](const PhotonPayload& photon, float weight, float, const DiscSpot&) { add(photon, weight); });
        } else {
            const Rgb per_power = factor * query.moments->channels;
            sum = sum_over_disc(map, settings, disc, scratch,
                                [&](const PhotonPayload& photon, float weight, float, const DiscSpot& spot) {
                                    add(photon, weight);
                                    add_moments(*query.moments, double{glm::dot(per_power, photon.power_w)}, spot);
                                });
        }
        estimate.scattered = sum.photons;
    } else {
        std::optional<ScatteredSum> scattered;  // most discs of a sparse map hold nothing
        sum = sum_over_disc(map, settings, disc, scratch,
                            [&](const PhotonPayload& photon, float weight, float side, const DiscSpot& spot) {
                                if (!scattered) scattered.emplace(point, bsdf, wo, query.moments);
                                scattered->add(photon, weight, side, spot);
                            });
        if (scattered) scattered->finish(estimate);
    }
    estimate.radiance *= factor * sum.scale_per_m2;
    estimate.delta_radiance *= factor * sum.scale_per_m2;
    estimate.photons = sum.photons;
    estimate.radius_m = sum.radius_m;
    return estimate;
}

Rgb estimate_irradiance(const PhotonMap& map, const EstimateSettings& settings, const vec3& position,
                        const vec3& normal, uint32_t most_scatterings, Neighbours& scratch, const DiscQuery& query) {
    const Disc disc{position, normal, false, most_scatterings, query};
    Rgb irradiance(0);
    const DiscSum sum = sum_over_disc(map, settings, disc, scratch,
                                      [&](const PhotonPayload& photon, float weight, float, const DiscSpot&) {
                                          irradiance += weight * photon.power_w;
                                      });
    return irradiance * sum.scale_per_m2;
}

}  // namespace photond
