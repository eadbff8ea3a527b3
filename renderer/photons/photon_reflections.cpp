#include "renderer/photons/photon_reflections.h"

namespace photond {

namespace {

/// The photon's smooth normal, and |cos_s| / |cos_g| of the arriving direction in front of it.
void set_smooth_normal(ReflectedPhoton& photon, const vec3& smooth_normal, const vec3& wi_world) {
    photon.smooth_normal = Octahedral<16>::encode(smooth_normal);
    if (smooth_normal == photon.normal) return;
    photon.correction = std::max(glm::dot(smooth_normal, wi_world), 0.0f) / glm::dot(photon.normal, wi_world);
}

}  // namespace

uint64_t PhotonReflections::bytes_per_thread() {
    constexpr uint64_t kPhotonsPerPath = 10;  // as of arrivals
    return PhotonWavefront::kPaths * kPhotonsPerPath *
           (sizeof(ReflectedPhoton) + sizeof(uint32_t) + sizeof(ReflectingSurface));
}

ReflectedBatch PhotonReflections::trace(PhotonWavefront& wavefront, const PhotonTracingScene& shared,
                                        const SequenceSampler& sampler, const PhotonBatch& batch, Counts& counts) {
    photons_.clear();
    elements_.clear();
    surfaces_.clear();
    const uint32_t most = std::min(shared.tracing.most_scatterings, batch.texels ? 1u : UINT32_MAX);
    wavefront.start_paths(shared, sampler, batch, counts);
    for (uint32_t scatterings = 0; wavefront.batch.count > 0 && scatterings < most; ++scatterings) {
        wavefront.find_hits(shared, scatterings, counts);
        wavefront.draw_numbers(sampler, batch.run, scatterings, 0);
        const Vertex vertex{wavefront, shared, counts, scatterings, scatterings + 1 < most};
        reflect_lambert(vertex);
        wavefront.visit_others(shared, [&](size_t place) {
            if (reflect_other(vertex, place)) wavefront.batch.keep_next(wavefront.batch.keys[wavefront.order[place]]);
        });
        wavefront.batch.advance();
    }
    counts.photons_emitted += batch.last - batch.first;
    counts.photons_stored += photons_.size();
    return {photons_, elements_, surfaces_};
}

void PhotonReflections::keep(const Vertex& vertex, uint32_t path, const ReflectedPhoton& photon) {
    photons_.push_back(photon);
    elements_.push_back(vertex.wavefront.batch.keys[path]);
}

/// Hits on plain Lambert reflectors. What lets the path go on keeps the photon: that its direction leads nowhere takes
/// nothing from the others it stands for, and the shading normal's correction, which depends on the direction, changes
/// the path's power alone.
void PhotonReflections::reflect_lambert(const Vertex& vertex) {
    PhotonWavefront& wavefront = vertex.wavefront;
    wavefront.keep_some(vertex.shared, vertex.scatterings, PhotonRecord::Reflections);
    wavefront.scatter_lambert(vertex.shared, [&](const KeptPath& kept, const LambertGroup& group, size_t lane) {
        const uint32_t i = wavefront.order[kept.place];
        const float survival = std::min(kept.hope, wavefront.most_survival(vertex.scatterings));
        ReflectedPhoton photon{
            .position = group.position.get(lane),
            .power_w = wavefront.batch.paths[i].power_w * kept.reflectance * (1 / survival),
            .normal = group.geometric_normal.get(lane),
            .direction = group.next_direction.get(lane),
            .scatterings_and_spread = ReflectedPhoton::pack(vertex.scatterings + 1, ReflectedPhoton::Spread::Lambert)};
        set_smooth_normal(photon, group.smooth_normal.get(lane), -wavefront.batch.rays[i].direction);
        if (!is_sound(photon.power_w, vertex.counts) || !is_sound(photon.power_w * photon.correction, vertex.counts))
            return;
        keep(vertex, i, photon);
        if (!vertex.goes_on || group.scattered[lane] == 0) return;
        const Rgb next_w = photon.power_w * group.correction[lane];
        if (is_sound(next_w, vertex.counts)) wavefront.go_on_from_lambert(i, next_w, group, lane);
    });
}

/// Keeps what leaves any other surface and draws the next ray. False: the path ends, and what stands in the place of
/// the next path does not count.
bool PhotonReflections::reflect_other(const Vertex& vertex, size_t place) {
    PhotonWavefront& wavefront = vertex.wavefront;
    const PhotonTracing& tracing = vertex.shared.tracing;
    const uint32_t i = wavefront.order[place];
    PartedHit parted;
    if (!wavefront.part_hit(vertex.shared, i, parted)) return false;
    const bool apart = tracing.rough_apart && parted.rough.scatters() && !parted.rough.has_non_delta_transmission();
    if (apart) keep_rough(vertex, parted, place);
    const bool beams = tracing.beams;
    if (!vertex.goes_on && (!beams || (apart && !parted.specular.scatters()))) return false;
    const PartedScattering scattering = wavefront.scatter_parted(parted, place, true, vertex.counts);
    if (!scattering.goes_on) return false;
    if (beams && !(apart && scattering.is_rough))
        keep(vertex, i,
             {.position = parted.point.position,
              .power_w = wavefront.batch.next_path().power_w,
              .normal = parted.point.geometric_normal,
              .direction = wavefront.batch.next_ray().direction,
              .smooth_normal = Octahedral<16>::encode(parted.point.smooth_normal),
              .scatterings_and_spread = ReflectedPhoton::pack(vertex.scatterings + 1, ReflectedPhoton::Spread::Beam,
                                                              wavefront.batch.hits[i].instance)});
    return vertex.goes_on;
}

/// All that the rough part scatters, whatever direction the path will take: kept with a probability that does not
/// depend on the direction.
void PhotonReflections::keep_rough(const Vertex& vertex, const PartedHit& parted, size_t place) {
    const PhotonWavefront& wavefront = vertex.wavefront;
    const uint32_t i = wavefront.order[place];
    const LightPath& path = wavefront.batch.paths[i];
    const Rgb albedo = parted.rough.albedo();
    const float hope = flux_to_keep_by(path.power_w, albedo) * path.reference_inverse;
    const float kept = std::min(hope, 1.0f);
    // By the upper end of the number whose lower end the path goes on by: photons and paths make up for one another.
    if (!(wavefront.choice.x[place] >= 1 - kept)) {
        if (std::isnan(hope)) ++vertex.counts.nan_samples;
        return;
    }
    const Rgb arriving_w = path.power_w / kept;
    const bool lambert = parted.rough.is_lambert();
    const vec3& normal = parted.point.geometric_normal;
    const vec2 u(wavefront.direction.x[place], wavefront.direction.y[place]);
    ReflectedPhoton photon{
        .position = parted.point.position,
        .power_w = arriving_w * albedo,
        .normal = normal,
        .direction = Frame(normal).to_world(sample_cosine_hemisphere(u)),
        .scatterings_and_spread = ReflectedPhoton::pack(
            vertex.scatterings + 1, lambert ? ReflectedPhoton::Spread::Lambert : ReflectedPhoton::Spread::Rough)};
    if (lambert) {
        set_smooth_normal(photon, parted.point.smooth_normal, parted.wi_world);
    } else {
        photon.smooth_normal = Octahedral<16>::encode(parted.point.smooth_normal);
        photon.surface = static_cast<uint32_t>(surfaces_.size());
    }
    if (!is_sound(arriving_w, vertex.counts) || !is_sound(photon.power_w * photon.correction, vertex.counts)) return;
    keep(vertex, i, photon);
    if (!lambert) surfaces_.push_back({wavefront.batch.hits[i], parted.wi_world, arriving_w, parted.outside_ior});
}

}  // namespace photond
