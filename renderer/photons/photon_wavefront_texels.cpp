// What the texels of the lights' map see: the first vertices of their light paths, before any is dropped.

#include "renderer/photons/photon_wavefront.h"
#include "renderer/transport/hit_prefetch.h"

namespace photond {

std::span<const SeenTexel> PhotonWavefront::see(const PhotonTracingScene& shared, const SequenceSampler& sampler,
                                                const PhotonBatch& batch, Counts& counts) {
    seen_.clear();
    start_paths(shared, sampler, batch, counts);
    find_hits(shared, 0, counts);
    keep_some(shared, 0, Record::Everything);
    scatter_lambert(shared, [&](const Kept& kept, const LambertGroup& group, size_t lane) {
        const uint32_t path = order_[kept.place];
        const Rgb reflected_w = paths_[path].power_w * kept.reflectance;
        if (is_black(reflected_w) || !is_sound(reflected_w, counts)) return;
        const vec3 normal = group.geometric_normal.get(lane);
        seen_.push_back({elements_[path],
                         {.position = group.position.get(lane),
                          .power_w = reflected_w,
                          .normal = normal,
                          .direction = normal,
                          .smooth_normal = Octahedral<16>::encode(group.smooth_normal.get(lane)),
                          .scatterings_and_spread = ReflectedPhoton::pack(1, ReflectedPhoton::Spread::Lambert)},
                         max_component(reflected_w)});
    });
    const std::span<const uint32_t> others = std::span<const uint32_t>(order_).subspan(lambert_count_);
    for (size_t k = 0; k < others.size(); ++k) {
        prefetch_ahead(shared.scene, hits_, others, k);
        see_parted(shared, others[k]);
    }
    return seen_;
}

void PhotonWavefront::see_parted(const PhotonTracingScene& shared, uint32_t path) {
    using Spread = ReflectedPhoton::Spread;
    PartedHit parted;
    if (!part_hit(shared, path, parted)) return;
    const Rgb& power_w = paths_[path].power_w;
    const bool stays = parted.rough.scatters() && !parted.rough.has_non_delta_transmission();
    const vec3& normal = parted.point.geometric_normal;
    SeenTexel seen{elements_[path],
                   {.position = parted.point.position,
                    .normal = normal,
                    .direction = normal,
                    .smooth_normal = Octahedral<16>::encode(parted.point.smooth_normal),
                    .scatterings_and_spread = ReflectedPhoton::pack(1, Spread::Beam)},
                   0};
    if (stays) {
        const Rgb albedo = parted.rough.albedo();
        seen.photon.power_w = power_w * albedo;
        seen.photon.scatterings_and_spread =
            ReflectedPhoton::pack(1, parted.rough.is_lambert() ? Spread::Lambert : Spread::Rough);
        seen.flux_w = flux_to_keep_by(power_w, albedo);
    }
    if (shared.tracing.most_scatterings > 1) {
        if (parted.specular.scatters()) seen.flux_w += flux_to_keep_by(power_w, parted.specular.albedo());
        if (parted.rough.scatters() && !stays) seen.flux_w += flux_to_keep_by(power_w, parted.rough.albedo());
    }
    if (seen.flux_w > 0) seen_.push_back(seen);
}

}  // namespace photond
