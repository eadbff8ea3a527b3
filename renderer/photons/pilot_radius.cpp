#include "renderer/photons/pilot_radius.h"

#include <algorithm>
#include <cmath>

namespace photond {

namespace {

constexpr size_t kPlaces = 2048;  // at most, where density is measured

}  // namespace

float radius_of_pilot(const PhotonMap& pilot, const PilotRadius& wanted) {
    const PhotonSearch& search = pilot.search();
    if (pilot.size() < search.nearest) return search.radius_m;
    struct Place {
        float radius_m, power_w;
    };
    std::vector<Place> places;
    double total_w = 0;
    Neighbours found;
    const size_t step = std::max<size_t>(pilot.size() / kPlaces, 1);
    for (size_t i = 0; i < pilot.size(); i += step) {
        const auto index = static_cast<uint32_t>(i);
        pilot.find(pilot.position(index), found);
        places.push_back({found.radius_m, max_component(pilot.payload(index).power_w)});
        total_w += double{places.back().power_w};
    }
    std::ranges::sort(places, {}, &Place::radius_m);
    double below_w = 0;
    float radius_m = search.radius_m;
    for (const Place& place : places) {
        radius_m = place.radius_m;
        below_w += double{place.power_w};
        if (below_w >= wanted.bright_share * total_w) break;
    }
    // k - 1 of the k nearest lie within the k-th's distance.
    const double photons_within = (search.nearest - 1) * wanted.paths_over_pilot;
    return static_cast<float>(double{radius_m} * std::sqrt(wanted.photons_in_radius / photons_within));
}

}  // namespace photond
