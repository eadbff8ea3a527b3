// The photons that light paths leave where they are reflected: what PhotonWavefront does for trace_reflected().

#include "renderer/photons/photon_wavefront.h"
#include "renderer/transport/hit_prefetch.h"

namespace photond {

namespace {

/// The photon's smooth normal, and |cos_s| / |cos_g| of the arriving direction in front of it.
void set_smooth_normal(ReflectedPhoton& photon, const vec3& smooth_normal, const vec3& wi_world) {
    photon.smooth_normal = Octahedral<16>::encode(smooth_normal);
    if (smooth_normal == photon.normal) return;
    photon.correction = std::max(glm::dot(smooth_normal, wi_world), 0.0f) / glm::dot(photon.normal, wi_world);
}

}  // namespace

uint64_t PhotonWavefront::reflection_bytes_per_thread() {
    constexpr uint64_t kPhotonsPerPath = 10;  // as bytes_per_thread()
    return bytes_per_thread() +
           kPaths * kPhotonsPerPath * (sizeof(ReflectedPhoton) + sizeof(uint32_t) + sizeof(ReflectingSurface));
}

ReflectedBatch PhotonWavefront::trace_reflected(const PhotonTracingScene& shared, const SequenceSampler& sampler,
                                                const PhotonBatch& batch, Counts& counts) {
    reflections_.clear();
    reflection_elements_.clear();
    surfaces_.clear();
    const uint32_t most = std::min(shared.tracing.most_scatterings, batch.texels ? 1u : UINT32_MAX);
    start_paths(shared, sampler, batch, counts);
    for (uint32_t scatterings = 0; count_ > 0 && scatterings < most; ++scatterings) {
        find_hits(shared, scatterings, counts);
        draw_numbers(sampler, batch.run, scatterings, 0);
        const bool goes_on = scatterings + 1 < most;
        reflect_lambert(shared, scatterings, goes_on, counts);
        reflect_general(shared, scatterings, goes_on, counts);
        advance();
    }
    counts.photons_emitted += batch.last - batch.first;
    counts.photons_stored += reflections_.size();
    return {reflections_, reflection_elements_, surfaces_};
}

void PhotonWavefront::keep(uint32_t path, const ReflectedPhoton& photon) {
    reflections_.push_back(photon);
    reflection_elements_.push_back(elements_[path]);
}

/// Hits on plain Lambert reflectors. What lets the path go on keeps the photon: that its direction leads nowhere takes
/// nothing from the others it stands for, and the shading normal's correction, which depends on the direction, changes
/// the path's power alone.
void PhotonWavefront::reflect_lambert(const PhotonTracingScene& shared, uint32_t scatterings, bool goes_on,
                                      Counts& counts) {
    keep_some(shared, scatterings, Record::Reflections);
    scatter_lambert(shared, [&](const Kept& kept, const LambertGroup& group, size_t lane) {
        const uint32_t i = order_[kept.place];
        const float survival = std::min(kept.hope, most_survival(scatterings));
        ReflectedPhoton photon{
            .position = group.position.get(lane),
            .power_w = paths_[i].power_w * kept.reflectance * (1 / survival),
            .normal = group.geometric_normal.get(lane),
            .direction = group.next_direction.get(lane),
            .scatterings_and_spread = ReflectedPhoton::pack(scatterings + 1, ReflectedPhoton::Spread::Lambert)};
        set_smooth_normal(photon, group.smooth_normal.get(lane), -rays_[i].direction);
        if (!is_sound(photon.power_w, counts) || !is_sound(photon.power_w * photon.correction, counts)) return;
        keep(i, photon);
        if (!goes_on || group.scattered[lane] == 0) return;
        const Rgb next_w = photon.power_w * group.correction[lane];
        if (is_sound(next_w, counts)) go_on_from_lambert(i, next_w, group, lane);
    });
}

/// Any other hits, one by one.
void PhotonWavefront::reflect_general(const PhotonTracingScene& shared, uint32_t scatterings, bool goes_on,
                                      Counts& counts) {
    const std::span<const uint32_t> order = std::span<const uint32_t>(order_).subspan(lambert_count_);
    for (size_t k = 0; k < order.size(); ++k) {
        prefetch_ahead(shared.scene, hits_, order, k);
        if (reflect_parted(shared, lambert_count_ + k, scatterings, goes_on, counts))
            next_elements_[next_count_++] = elements_[order[k]];
    }
}

/// Keeps what leaves and draws the next ray. False: the path ends, and what stands in the place of the next path does
/// not count.
bool PhotonWavefront::reflect_parted(const PhotonTracingScene& shared, size_t place, uint32_t scatterings, bool goes_on,
                                     Counts& counts) {
    PartedHit parted;
    if (!part_hit(shared, order_[place], parted)) return false;
    const bool apart =
        shared.tracing.rough_apart && parted.rough.scatters() && !parted.rough.has_non_delta_transmission();
    if (apart) keep_rough(parted, place, scatterings, counts);
    const bool beams = shared.tracing.beams;
    if (!goes_on && (!beams || (apart && !parted.specular.scatters()))) return false;
    const PartedScattering scattering = scatter_parted(parted, place, true, counts);
    if (!scattering.goes_on) return false;
    if (beams && !(apart && scattering.is_rough))
        keep(order_[place],
             {.position = parted.point.position,
              .power_w = next_paths_[next_count_].power_w,
              .normal = parted.point.geometric_normal,
              .direction = next_rays_[next_count_].direction,
              .smooth_normal = Octahedral<16>::encode(parted.point.smooth_normal),
              .scatterings_and_spread = ReflectedPhoton::pack(scatterings + 1, ReflectedPhoton::Spread::Beam)});
    return goes_on;
}

/// All that the rough part scatters, whatever direction the path will take: kept with a probability that does not
/// depend on the direction.
void PhotonWavefront::keep_rough(const PartedHit& parted, size_t place, uint32_t scatterings, Counts& counts) {
    const Path& path = paths_[order_[place]];
    const Rgb albedo = parted.rough.albedo();
    const float hope = flux_to_keep_by(path.power_w, albedo) * path.reference_inverse;
    const float kept = std::min(hope, 1.0f);
    // By the upper end of the number whose lower end the path goes on by: photons and paths make up for one another.
    if (!(choice_.x[place] >= 1 - kept)) {
        if (std::isnan(hope)) ++counts.nan_samples;
        return;
    }
    const Rgb arriving_w = path.power_w / kept;
    const bool lambert = parted.rough.is_lambert();
    const vec3& normal = parted.point.geometric_normal;
    ReflectedPhoton photon{
        .position = parted.point.position,
        .power_w = arriving_w * albedo,
        .normal = normal,
        .direction = Frame(normal).to_world(sample_cosine_hemisphere({direction_.x[place], direction_.y[place]})),
        .scatterings_and_spread = ReflectedPhoton::pack(
            scatterings + 1, lambert ? ReflectedPhoton::Spread::Lambert : ReflectedPhoton::Spread::Rough)};
    if (lambert) {
        set_smooth_normal(photon, parted.point.smooth_normal, parted.wi_world);
    } else {
        photon.smooth_normal = Octahedral<16>::encode(parted.point.smooth_normal);
        photon.surface = static_cast<uint32_t>(surfaces_.size());
    }
    if (!is_sound(arriving_w, counts) || !is_sound(photon.power_w * photon.correction, counts)) return;
    keep(order_[place], photon);
    if (!lambert) surfaces_.push_back({hits_[order_[place]], parted.wi_world, arriving_w, parted.outside_ior});
}

}  // namespace photond
