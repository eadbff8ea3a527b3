#include "renderer/photons/photon_arrivals.h"

namespace photond {

uint64_t PhotonArrivals::bytes_per_thread() {
    // As many photons as paths come at each vertex; a bright closed room has some ten vertices that matter.
    constexpr uint64_t kPhotonsPerPath = 10;
    return PhotonWavefront::kPaths * kPhotonsPerPath * sizeof(Photon);
}

std::span<const Photon> PhotonArrivals::trace(PhotonWavefront& wavefront, const PhotonTracingScene& shared,
                                              const SequenceSampler& sampler, const PhotonBatch& batch,
                                              PhotonCounts& counts) {
    photon_count_ = 0;
    first_element_ = batch.run * SequenceSampler::kRun;
    wavefront.start_paths(shared, sampler, batch, counts.counts);
    const bool caustic = shared.tracing.kind == PhotonMapKind::Caustic;
    for (uint32_t scatterings = 0; wavefront.batch.count > 0; ++scatterings) {
        wavefront.find_hits(shared, scatterings, counts.counts);
        if (scatterings < shared.tracing.most_scatterings)
            wavefront.draw_numbers(sampler, batch.run, scatterings, caustic ? wavefront.lambert_count : 0);
        // So that storing need not ask for room.
        const size_t most = photon_count_ + wavefront.order.size();
        if (photons_.size() < most) photons_.resize(2 * most);
        shade_lambert(wavefront, shared, scatterings, counts.counts);
        wavefront.visit_others(shared, [&](size_t place) {
            if (scatter_other(wavefront, shared, place, scatterings, counts))
                wavefront.batch.keep_next(wavefront.batch.keys[wavefront.order[place]]);
        });
        wavefront.batch.advance();
    }
    counts.counts.photons_emitted += batch.last - batch.first;
    counts.counts.photons_stored += photon_count_;
    return {photons_.data(), photon_count_};
}

/// Where that path of the batch has arrived.
void PhotonArrivals::store(const PhotonWavefront& wavefront, uint32_t path, const vec3& position, const vec3& normal,
                           uint32_t scatterings) {
    const LightPath& carrier = wavefront.batch.paths[path];
    const bool marked = is_marked_photon(first_element_ + wavefront.batch.keys[path], scatterings);
    photons_[photon_count_++] = {position, PhotonPayload::make(carrier.power_w, -wavefront.batch.rays[path].direction,
                                                               normal, scatterings, carrier.all_delta, marked)};
}

/// Hits on plain Lambert reflectors: always rough, so that caustic paths end there.
void PhotonArrivals::shade_lambert(PhotonWavefront& wavefront, const PhotonTracingScene& shared, uint32_t scatterings,
                                   Counts& counts) {
    const bool caustic = shared.tracing.kind == PhotonMapKind::Caustic;
    const bool scatters = !caustic && scatterings < shared.tracing.most_scatterings;
    if (caustic && scatterings == 0) return;
    wavefront.keep_some(shared, scatterings, PhotonRecord::Arrivals);
    wavefront.scatter_lambert(shared, [&](const KeptPath& kept, const LambertGroup& group, size_t lane) {
        const uint32_t i = wavefront.order[kept.place];
        const LightPath& path = wavefront.batch.paths[i];
        if (kept.stores) store(wavefront, i, group.position.get(lane), group.geometric_normal.get(lane), scatterings);
        if (!scatters || group.scattered[lane] == 0) return;
        const float hope = kept.hope * group.correction[lane];
        const float survival = std::min(hope, ROULETTE_MOST_SURVIVAL);
        if (!(wavefront.choice.x[kept.place] < survival)) {
            if (std::isnan(hope)) ++counts.nan_samples;
            return;
        }
        const Rgb power_w = path.power_w * kept.reflectance * (group.correction[lane] * (1 / survival));
        if (is_sound(power_w, counts)) wavefront.go_on_from_lambert(i, power_w, group, lane);
    });
}

/// Stores the photon at a hit on any other surface and draws the next ray. False: the path ends, and what stands in the
/// place of the next path does not count.
bool PhotonArrivals::scatter_other(PhotonWavefront& wavefront, const PhotonTracingScene& shared, size_t place,
                                   uint32_t scatterings, PhotonCounts& counts) {
    const PhotonTracing& tracing = shared.tracing;
    const uint32_t i = wavefront.order[place];
    const LightPath& path = wavefront.batch.paths[i];
    PartedHit parted;
    if (!wavefront.part_hit(shared, i, parted)) return false;
    const ShadingPoint& point = parted.point;
    const bool caustic = tracing.kind == PhotonMapKind::Caustic;
    if (scatterings == 0 && parted.specular.scatters()) ++counts.first_hits_specular;
    if ((caustic ? scatterings > 0 : path.rough) && (parted.rough.scatters() || shared.shading[point.instance].stores))
        store(wavefront, i, point.position, point.geometric_normal, scatterings);
    if (scatterings >= tracing.most_scatterings) return false;
    return wavefront.scatter_parted(parted, place, !caustic, counts.counts).goes_on;
}

}  // namespace photond
