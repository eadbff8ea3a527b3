#include "renderer/photons/seen_texels.h"

namespace photond {

std::span<const SeenTexel> SeenTexels::see(PhotonWavefront& wavefront, const PhotonTracingScene& shared,
                                           const SequenceSampler& sampler, const PhotonBatch& batch, Counts& counts) {
    seen_.clear();
    wavefront.start_paths(shared, sampler, batch, counts);
    wavefront.find_hits(shared, 0, counts);
    wavefront.keep_some(shared, 0, PhotonRecord::Everything);
    wavefront.scatter_lambert(shared, [&](const KeptPath& kept, const LambertGroup& group, size_t lane) {
        const uint32_t path = wavefront.order[kept.place];
        const Rgb reflected_w = wavefront.batch.paths[path].power_w * kept.reflectance;
        if (is_black(reflected_w) || !is_sound(reflected_w, counts)) return;
        const vec3 normal = group.geometric_normal.get(lane);
        seen_.push_back({wavefront.batch.keys[path],
                         {.position = group.position.get(lane),
                          .power_w = reflected_w,
                          .normal = normal,
                          .direction = normal,
                          .smooth_normal = Octahedral<16>::encode(group.smooth_normal.get(lane)),
                          .scatterings_and_spread = ReflectedPhoton::pack(1, ReflectedPhoton::Spread::Lambert)},
                         max_component(reflected_w)});
    });
    wavefront.visit_others(shared, [&](size_t place) { see_other(wavefront, shared, wavefront.order[place]); });
    return seen_;
}

void SeenTexels::see_other(const PhotonWavefront& wavefront, const PhotonTracingScene& shared, uint32_t path) {
    using Spread = ReflectedPhoton::Spread;
    PartedHit parted;
    if (!wavefront.part_hit(shared, path, parted)) return;
    const Rgb& power_w = wavefront.batch.paths[path].power_w;
    const bool stays = parted.rough.scatters() && !parted.rough.has_non_delta_transmission();
    const vec3& normal = parted.point.geometric_normal;
    SeenTexel seen{wavefront.batch.keys[path],
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
