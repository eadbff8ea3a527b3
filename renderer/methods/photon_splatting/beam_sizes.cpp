#include "renderer/methods/photon_splatting/beam_sizes.h"

#include <algorithm>
#include <cstdio>
#include <numeric>

#include "renderer/photons/kd_tree.h"
#include "renderer/scene/scene.h"

namespace photond {

namespace {

constexpr uint32_t kNeighbours = 9;     // of a landing, itself among them: the farthest tells how close they lie
constexpr uint32_t kPhotonsOfCell = 4;  // of the pilot
constexpr uint32_t kMostLevels = 14;    // of splits
/// Of a pass, within a beam's disc. Measured on cornell-box-glass, 512x512, 10 CPU seconds: relative_mse and bias with
/// 1 0.018 and -0.07 %, with 4 0.012 and -0.16 %, with 16 0.012 and -0.33 %.
constexpr float kPhotonsOfDisc = 4;

/// Least GGX alpha that the material's roughness gives.
float least_alpha(const Scene& scene, const Material& material) {
    float roughness = material.roughness;
    if (material.metallic_roughness_texture.used()) {
        uint8_t least = 255;
        for (const u8vec4& texel :
             scene.textures[static_cast<size_t>(material.metallic_roughness_texture.texture)].texels)
            least = std::min(least, texel.g);
        roughness *= static_cast<float>(least) / 255;
    }
    return sqr(roughness);
}

bool sends_beams(const Scene& scene, const Material& material, float threshold) {
    if (material.unlit) return false;
    if (material.transmission > 0 && material.metallic < 1) return true;
    return (material.metallic > 0 || material.specular > 0) && least_alpha(scene, material) < threshold;
}

Bounds3 world_bounds(const Scene& scene, const Instance& instance) {
    Bounds3 bounds;
    for (const vec3& p : scene.meshes[instance.mesh].positions)
        bounds.extend(instance.identity ? p : instance.to_world * vec4(p, 1));
    return bounds;
}

}  // namespace

std::vector<float> caster_radii_m(const Scene& scene, float threshold) {
    std::vector<uint8_t> sends;
    for (const Material& material : scene.materials) sends.push_back(sends_beams(scene, material, threshold));
    std::vector<float> radii_m(scene.instances.size(), kInfinity);
    for (size_t i = 0; i < radii_m.size(); ++i) {
        const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
        if (mesh.positions.empty() || !sends[mesh.material]) continue;
        const vec3 sides = world_bounds(scene, scene.instances[i]).diagonal();
        const auto [less, more] = std::minmax(sides.x, sides.y);
        radii_m[i] = 0.5f * std::max(less, std::min(more, sides.z));
    }
    return radii_m;
}

std::string wide_beams_text(float beam_radius_m, std::span<const float> caster_radii_m) {
    size_t narrower = 0;
    float narrowest_m = kInfinity;
    for (const float radius_m : caster_radii_m) {
        narrower += radius_m < beam_radius_m;
        narrowest_m = std::min(narrowest_m, radius_m);
    }
    if (narrower == 0) return {};
    char text[300];
    std::snprintf(text, sizeof text,
                  "warning: beams are %.2g m wide, wider than %zu of the objects that cast them, of which the "
                  "narrowest has %.2g m: they glow that far about themselves; take a smaller splat_size",
                  2.0 * double{beam_radius_m}, narrower, 2.0 * double{narrowest_m});
    return text;
}

/// Cuts the landings into cells.
class BeamSizes::Builder {
public:
    Builder(BeamSizes& sizes, std::span<const vec3> landings, std::span<const float> radii_m)
        : sizes_(sizes), landings_(landings), radii_m_(radii_m), order_(landings.size()) {
        std::iota(order_.begin(), order_.end(), 0u);
    }

    void cut(uint32_t node, uint32_t level, size_t first, size_t last) {
        const auto begin = order_.begin() + static_cast<std::ptrdiff_t>(first);
        const auto end = order_.begin() + static_cast<std::ptrdiff_t>(last);
        const auto middle = begin + (end - begin) / 2;
        if (level == sizes_.levels_) {
            std::nth_element(begin, middle, end, [&](uint32_t a, uint32_t b) { return radii_m_[a] < radii_m_[b]; });
            sizes_.cells_[node] = {radii_m_[*middle], 0};
            return;
        }
        Bounds3 bounds;
        for (auto at = begin; at != end; ++at) bounds.extend(landings_[*at]);
        const vec3 sides = bounds.diagonal();
        const int axis = sides.x >= sides.y && sides.x >= sides.z ? 0 : sides.y >= sides.z ? 1 : 2;
        std::nth_element(begin, middle, end,
                         [&](uint32_t a, uint32_t b) { return landings_[a][axis] < landings_[b][axis]; });
        sizes_.cells_[node] = {landings_[*middle][axis], static_cast<uint32_t>(axis)};
        const auto half = static_cast<size_t>(middle - order_.begin());
        cut(2 * node, level + 1, first, half);
        cut(2 * node + 1, level + 1, half, last);
    }

private:
    BeamSizes& sizes_;
    std::span<const vec3> landings_;
    std::span<const float> radii_m_;
    std::vector<uint32_t> order_;
};

BeamSizes::BeamSizes(float most_m, uint32_t paths, std::vector<float> caster_radii_m, const TracedReflections& pilot,
                     const Intersector& intersector, Counts& counts)
    : most_m_(most_m), casters_m_(std::move(caster_radii_m)) {
    std::vector<Ray> rays;
    for (const ReflectedPhoton& photon : pilot.photons) {
        if (photon.spread() != ReflectedPhoton::Spread::Beam) continue;
        const float side = glm::dot(photon.normal, photon.direction) < 0 ? -1.0f : 1.0f;
        rays.push_back({offset_ray_origin(photon.position, side * photon.normal), photon.direction, kInfinity});
    }
    std::vector<Hit> hits(rays.size());
    intersector.closest_hits(rays, hits, Coherence::Incoherent);
    counts.photon_rays += rays.size();
    std::vector<vec3> landings;
    for (size_t i = 0; i < rays.size(); ++i)
        if (hits[i].valid()) landings.push_back(rays[i].origin + hits[i].t * rays[i].direction);
    if (landings.size() < kNeighbours) return;

    std::vector<uint32_t> order(landings.size());
    const KdTree tree(landings, order);
    // k - 1 landings on the disc of the k-th: the pilot's density, of which a pass's is its share of paths.
    const float of_disc = kPhotonsOfDisc * static_cast<float>(pilot.paths) / static_cast<float>(paths);
    const float scale = std::sqrt(of_disc / static_cast<float>(kNeighbours - 1));
    std::vector<float> radii_m;
    Neighbours found;
    for (const vec3& landing : landings) {
        tree.find_nearest(landing, kNeighbours, kInfinity, found);
        radii_m.push_back(std::clamp(scale * found.radius_m, BEAM_LEAST_SHARE * most_m, most_m));
    }
    while (levels_ < kMostLevels && landings.size() >> (levels_ + 1) >= kPhotonsOfCell) ++levels_;
    cells_.resize(size_t{2} << levels_);
    Builder(*this, landings, radii_m).cut(1, 0, 0, landings.size());
}

float BeamSizes::radius_m(const BeamLanding& landing, float photons) const {
    float radius_m = most_m_;
    if (!cells_.empty()) {
        uint32_t node = 1;
        for (uint32_t level = 0; level < levels_; ++level) {
            const gpu::BeamCell& cell = cells_[node];
            node = 2 * node + (landing.position[static_cast<int>(cell.axis)] < cell.split_or_radius ? 0 : 1);
        }
        radius_m = cells_[node].split_or_radius;
    }
    radius_m *= std::sqrt(photons);
    if (casters_m_.empty()) return radius_m;
    if (landing.caster < casters_m_.size()) radius_m = std::min(radius_m, casters_m_[landing.caster]);
    return std::min(radius_m, std::max(BEAM_WAY_SHARE * landing.distance_m, BEAM_LEAST_SHARE * most_m_));
}

}  // namespace photond
