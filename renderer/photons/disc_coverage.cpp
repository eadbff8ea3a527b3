#include "renderer/photons/disc_coverage.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "renderer/photons/disc_coverage_shared.h"
#include "renderer/photons/surface_edges.h"
#include "renderer/scene/intersector.h"
#include "renderer/scene/scene.h"

namespace photond {

namespace {

/// From above the disc to just above a point of a surface.
Ray ray_between(const vec3& eye, const vec3& point, const vec3& normal, float radius_m) {
    const vec3 to = point + DISC_ABOVE_POINT * radius_m * normal - eye;
    const float length_m = glm::length(to);
    return {eye, length_m > 0 ? to / length_m : normal, length_m};
}

}  // namespace

DiscCoverage::DiscCoverage(const Scene& scene, const Intersector& intersector, float radius_m)
    : scene_(scene), intersector_(intersector), edges_(find_surface_edges(scene, radius_m)) {}

bool PlaceProbe::sees(const vec3& photon) {
    const float distance_m = glm::length(photon - place_);
    if (!coverage_.may_be_cut(place_, distance_m)) return true;
    const Intersector& intersector = coverage_.intersector();
    if (!most_lift_m_) {
        const Hit above = intersector.closest_hit({offset_ray_origin(place_, normal_), normal_, 2 * radius_m_});
        most_lift_m_ = above.valid() ? 0.5f * above.t : radius_m_;
    }
    const vec3 eye = place_ + std::min(*most_lift_m_, distance_m) * normal_;
    return !intersector.occluded(ray_between(eye, photon, normal_, distance_m));
}

/// A place of the disc, and what is known of it.
struct DiscProbe::Place {
    vec3 offset{0};        // from the centre, in the plane [m]
    float u_sq_m2 = 0;     // its square
    float height_m = 0;    // of the surface that was found, over the plane
    float area = 0;        // of the surface that was found over the place's own; 0: none
    bool covered = false;  // found, and seen from above the centre
};

DiscProbe::DiscProbe(const DiscCoverage& coverage, const Kernel& kernel, const CoverageDisc& disc, uint32_t turn,
                     DiscCare care)
    : scene_(coverage.scene()),
      intersector_(coverage.intersector()),
      kernel_(kernel),
      disc_(disc),
      frame_(disc.normal),
      turn_(turn),
      batch_(care == DiscCare::Fine ? DISC_FINE_BATCH : DISC_COARSE_BATCH) {
    const float wanted = std::max(disc.thickness_m, DISC_LEAST_LIFT * disc.radius_m);
    const Hit above = intersector_.closest_hit({offset_ray_origin(disc.centre, disc.normal), disc.normal, wanted});
    lift_m_ = above.valid() ? 0.5f * above.t : wanted;
    eye_ = disc.centre + lift_m_ * disc.normal;
}

bool DiscProbe::sees(const vec3& photon) const {
    return !intersector_.occluded(ray_between(eye_, photon, disc_.normal, disc_.radius_m));
}

DiscProbe::Mass DiscProbe::mass() const {
    Mass mass;
    std::array<Place, kMostInBatch> places;
    size_t looked_up = 0, covered = 0;
    float area = 0, product = 1;
    while (looked_up < kMostPlaces && std::fabs(product) > DISC_NOTHING_LOST &&
           (looked_up < 2 * batch_ || covered < batch_)) {
        float of_batch = 0;
        for (const Place& place : look_up(static_cast<uint32_t>(looked_up / batch_), places)) {
            if (place.covered) ++covered, of_batch += place.area;
            mass.hides = mass.hides || (place.area > 0 && !place.covered);
        }
        looked_up += batch_;
        area += of_batch;
        product *= 1 - of_batch / static_cast<float>(batch_);
        mass.inverse += product;
    }
    mass.inverse += product * (static_cast<float>(looked_up) - area) / std::max(area, 1.0f);
    mass.inverse = std::min(mass.inverse, 1 / DiscCoverage::kLeastMass);
    return mass;
}

/// The places of that batch.
std::span<DiscProbe::Place> DiscProbe::look_up(uint32_t batch, std::array<Place, kMostInBatch>& all) const {
    const std::span<Place> places = std::span(all).first(batch_);
    for (size_t i = 0; i < places.size(); ++i) places[i] = place(batch, i);
    look_slanted(places);
    if (std::any_of(places.begin(), places.end(), [](const Place& p) { return !p.covered; })) look_down(places);
    return places;
}

DiscProbe::Place DiscProbe::place(uint32_t batch, size_t number) const {
    const auto turned = [&](uint32_t axis, float step) {
        const float x = to_unit_float(hash32(turn_ + 3 * batch + axis)) + static_cast<float>(number) * step;
        return x - std::floor(x);
    };
    const float disc = kernel_.sample_disc(turned(0, DISC_STEP_X));
    const float angle = 2 * kPi * turned(1, DISC_STEP_Y), share = turned(2, DISC_STEP_Z);
    const float u_m = disc * std::sqrt(share) * disc_.radius_m;
    Place place;
    place.offset = u_m * (std::cos(angle) * frame_.tangent + std::sin(angle) * frame_.bitangent);
    place.u_sq_m2 = sqr(u_m);
    return place;
}

/// Rays from above the centre: what they meet in the disc's plane is surface that light can reach from there.
void DiscProbe::look_slanted(std::span<Place> places) const {
    std::array<Ray, kMostInBatch> rays;
    std::array<Hit, kMostInBatch> hits;
    std::array<float, kMostInBatch> lengths_m;
    for (size_t i = 0; i < places.size(); ++i) {
        const vec3 to = places[i].offset - lift_m_ * disc_.normal;
        lengths_m[i] = std::sqrt(places[i].u_sq_m2 + sqr(lift_m_));
        rays[i] = {eye_, to / lengths_m[i], (1 + DISC_SAME_PLANE) * lengths_m[i]};
    }
    intersector_.closest_hits(std::span(rays).first(places.size()), std::span(hits).first(places.size()),
                              Coherence::Incoherent);
    for (size_t i = 0; i < places.size(); ++i) {
        Place& place = places[i];
        place.height_m = hits[i].valid() ? lift_m_ * (1 - hits[i].t / lengths_m[i]) : -kInfinity;
        if (std::fabs(place.height_m) <= std::min(DISC_SAME_PLANE * disc_.radius_m, 0.5f * lift_m_))
            place.area = area_over(hits[i]);
        place.covered = place.area > 0;
    }
}

/// Rays along the normal, from as high above the places that are left as the eye is.
void DiscProbe::look_down(std::span<Place> places) const {
    std::array<Ray, kMostInBatch> rays;
    std::array<Hit, kMostInBatch> hits;
    std::array<uint8_t, kMostInBatch> hidden;
    for (size_t i = 0; i < places.size(); ++i)
        rays[i] = {eye_ + places[i].offset, -disc_.normal, places[i].covered ? 0 : lift_m_ + disc_.thickness_m};
    intersector_.closest_hits(std::span(rays).first(places.size()), std::span(hits).first(places.size()),
                              Coherence::Incoherent);
    for (size_t i = 0; i < places.size(); ++i) {
        Place& place = places[i];
        if (place.covered) continue;
        place.height_m = lift_m_ - hits[i].t;
        const bool in_disc = std::fabs(place.height_m) <= disc_.thickness_m &&
                             place.u_sq_m2 + sqr(place.height_m) <= sqr(disc_.radius_m);
        place.area = in_disc ? area_over(hits[i]) : 0;
        const vec3 point = disc_.centre + place.offset + place.height_m * disc_.normal;
        rays[i] = ray_between(eye_, point, disc_.normal, disc_.radius_m);
        if (place.area == 0) rays[i].t_max = 0;
    }
    if (std::none_of(places.begin(), places.end(), [](const Place& p) { return p.area > 0 && !p.covered; })) return;
    for (size_t i = 0; i < places.size(); ++i)
        if (places[i].covered) rays[i].t_max = 0;
    intersector_.occluded(std::span(rays).first(places.size()), std::span(hidden).first(places.size()),
                          Coherence::Incoherent);
    for (size_t i = 0; i < places.size(); ++i)
        if (places[i].area > 0) places[i].covered = hidden[i] == 0;
}

/// Area of the surface that was hit over that of its projection to the disc: one over the cosine. 0 where there is
/// none that makes at most 60 degrees with the disc.
float DiscProbe::area_over(const Hit& hit) const {
    if (!hit.valid()) return 0;
    const TriangleCorners t = world_triangle(scene_, hit.instance, hit.triangle);
    const vec3 across = glm::cross(t.p[1] - t.p[0], t.p[2] - t.p[0]);
    const float cosine = std::fabs(glm::dot(across, disc_.normal)) / glm::length(across);
    return cosine >= kDiscCosine ? 1 / cosine : 0;
}

}  // namespace photond
