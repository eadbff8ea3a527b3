// The walk at plain Lambert reflectors: what specular_walk.cpp does at any surface, for as many paths at once as the
// machine has lanes. Textures, and points on lights that have an area, are left to one at a time.

#include <optional>

#include "renderer/eye/eye_contributions.h"
#include "renderer/eye/specular_walk.h"
#include "renderer/transport/lambert_lanes.h"
#include "renderer/transport/punctual.h"

namespace photond {

namespace {

/// The light of a scene that has but one, a point or a spot: there is nothing to choose, and it is seen from a whole
/// group of points at once.
class OnlyLight {
public:
    explicit OnlyLight(const PunctualLight& light) : light_(light), cone_(light) {}

    static bool fits(const Scene& scene) {
        return scene.triangle_lights.empty() && !scene.environment && scene.punctual_lights.size() == 1 &&
               scene.punctual_lights[0].kind != PunctualLight::Kind::Directional;
    }

    /// For each lane what 1 W/sr of the light's intensity makes of a white reflector's radiance [sr^-1 m^-2], before
    /// shadow.
    void illuminate(const LambertGroup& group, LaneFloats& radiance) const {
        using lambert_lanes::kAligned;
        const Vec3Lanes to_light = broadcast(light_.position) - group.position.load();
        const FloatLanes inverse_distance = 1.0f / std::experimental::sqrt(dot(to_light, to_light));
        const Vec3Lanes wi = inverse_distance * to_light;
        const FloatLanes cosine = dot(group.normal.load(), wi);
        // At the light itself, where directions are no numbers, neither holds.
        const FloatMask lit = cosine > 0 && dot(group.geometric_normal.load(), wi) > 0;
        select(lit, kInvPi * cosine * inverse_distance * inverse_distance, 0).copy_to(radiance, kAligned);
        if (light_.kind == PunctualLight::Kind::Spot) {
            alignas(kLaneAlignment) LaneFloats from_axis;
            (-dot(broadcast(light_.direction), wi)).copy_to(from_axis, kAligned);
            for (size_t lane = 0; lane < kLanes; ++lane)
                radiance[lane] *= radiance[lane] > 0 ? cone_.falloff(from_axis[lane]) : 0.0f;
        }
        if (light_.range_m < kInfinity) {
            alignas(kLaneAlignment) LaneFloats distance_m;
            (1.0f / inverse_distance).copy_to(distance_m, kAligned);
            for (size_t lane = 0; lane < kLanes; ++lane)
                radiance[lane] *= radiance[lane] > 0 ? range_window(distance_m[lane], light_.range_m) : 0.0f;
        }
    }

    const Rgb& intensity() const { return light_.intensity; }
    Ray shadow_ray(const vec3& origin) const { return {origin, light_.position - origin, 1.0f}; }

private:
    const PunctualLight& light_;
    SpotCone cone_;
};

}  // namespace

void SpecularWalk::shade_lambert(const Pass& pass) {
    const EyeScene& shared = pass.shared;
    std::optional<OnlyLight> only_light;
    if (!pass.settings.guide && OnlyLight::fits(shared.scene)) only_light.emplace(shared.scene.punctual_lights[0]);
    LambertGroup group;
    alignas(kLaneAlignment) LaneFloats lit;
    for (size_t first = 0; first < batch_.lambert.size(); first += kLanes) {
        const size_t lanes = batch_.gather_lambert(shared, first, group, [](size_t, uint32_t) {});
        group.find_surface();
        if (only_light) only_light->illuminate(group, lit);

        for (size_t lane = 0; lane < lanes; ++lane) {
            const uint32_t i = batch_.lambert[first + lane];
            const EyePath& path = batch_.paths[i];
            const vec3 normal = group.normal.get(lane);
            const Rgb reflectance = group.reflectance.get(lane);
            if (vertex_ == 0)
                store_first_hit(pass.image, shared, path.pixel, group.position.get(lane), normal,
                                group.geometric_normal.get(lane));
            if (shared.shading[batch_.hits[i].instance].emits)
                add_emission(pass.image, shared, path, batch_.hits[i], group.front[lane] != 0,
                             batch_.rays[i].direction);
            if (path.scatterings >= shared.max_scatterings) continue;
            const bool camera_walk = path.scatterings == 0;
            if (camera_walk && pass.image.layers.has(Layer::Albedo) &&
                is_black(pass.image.of<Layer::Albedo>()[path.pixel]))
                pass.image.of<Layer::Albedo>()[path.pixel] = reflectance;
            // Nothing is scattered to an eye below the horizon of the normal that shades.
            if (is_black(reflectance) || !(glm::dot(normal, batch_.rays[i].direction) < 0)) continue;

            const Rgb weight = path.throughput * reflectance;
            if (!only_light) {
                light_lambert(pass, group, lane, i, weight);
            } else if (lit[lane] > 0) {
                shadows_.add(only_light->shadow_ray(group.start.get(lane)),
                             {lit[lane] * weight * only_light->intensity(), path.pixel, !camera_walk});
            }
            if (path.scatterings + 2 <= shared.max_scatterings)
                lambert_points_.push_back({group.position.get(lane), group.geometric_normal.get(lane), normal, weight,
                                           path.pixel, path.scatterings, reflectance, i});
        }
    }
}

/// Draws light samples at a lane's point; they compete with rays that the method will draw, as nothing else is
/// followed.
void SpecularWalk::light_lambert(const Pass& pass, const LambertGroup& group, size_t lane, uint32_t i,
                                 const Rgb& weight) {
    const EyePath& path = batch_.paths[i];
    const WalkVertex decided = decide(pass, path, path.scatterings + 2 <= pass.shared.max_scatterings);
    const auto samples = static_cast<float>(decided.light_samples), rays = static_cast<float>(decided.competing_rays);
    const vec3 normal = group.normal.get(lane);
    LitPoint point{group.position.get(lane), group.geometric_normal.get(lane), normal, i, path.pixel,
                   path.scatterings > 0};
    for (uint32_t s = 0; s < decided.light_samples; ++s) {
        LightSample light;
        if (!draw_light(pass, point, s, light)) continue;
        const float cos_light = glm::dot(normal, light.wi);
        if (!(cos_light > 0 && glm::dot(point.geometric_normal, light.wi) > 0)) continue;
        const float pdf_sa = cos_light * kInvPi;
        const float share = light.delta ? 1.0f : power_heuristic(samples * light.pdf_sa, rays * pdf_sa);
        add_light(pass, point, light, group.start.get(lane),
                  (share * pdf_sa / samples) * weight * light.radiance_over_pdf);
    }
}

}  // namespace photond
