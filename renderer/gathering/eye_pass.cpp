#include "renderer/gathering/eye_pass.h"

namespace photond {

/// Many light samples where many rays are gathered, which compete with them; shadow photons.
class EyePass::Guide final : public WalkGuide {
public:
    Guide(const GatheringScene& shared, const PassMaps& maps, Neighbours& scratch)
        : shared_(shared), maps_(maps), scratch_(scratch) {}

    static bool needed(const GatheringScene& shared, const PassMaps& maps) {
        return shared.splits.light_samples > 1 || FinalGather::samples_lights(shared.params) || maps.shadow;
    }

    WalkVertex decide(const Rgb& throughput, float eta_scale, bool waits) const override {
        const bool rays = waits && FinalGather::samples_lights(shared_.params);
        return {split_of(shared_.splits.light_samples, throughput, eta_scale),
                rays ? split_of(shared_.splits.gather_rays, throughput, eta_scale) : 0};
    }
    LightSeen light_seen(const vec3& position, const vec3& normal, uint32_t source) override {
        return photond::light_seen(maps_, position, normal, source, scratch_);
    }

private:
    const GatheringScene& shared_;
    const PassMaps& maps_;
    Neighbours& scratch_;
};

/// Light of the maps that visible points scatter, and what they gather.
class EyePass::Lookups final : public VisiblePointSink {
public:
    Lookups(EyePass& eye, const PassSampler& sampler, const GatherPass& pass, const CancelToken& cancel)
        : eye_(eye),
          sampler_(sampler),
          pass_(pass),
          shared_(pass.shared),
          maps_(pass.maps),
          image_(pass.image),
          cancel_(cancel) {}

    void take(std::span<const LambertVisiblePoint> lambert, std::span<const VisiblePoint> others) override {
        eye_.gather_points_.clear();
        for (const LambertVisiblePoint& point : lambert) look_up(eye_.walk_.general(point));
        for (const VisiblePoint& point : others) look_up(point);
        if (shared_.params.final_gather()) eye_.final_gather_.gather(pass_, eye_.gather_points_, cancel_);
    }

private:
    void look_up(const VisiblePoint& point) {
        const uint32_t most = shared_.photon_scatterings(point.scatterings + 1);
        const DiscQuery query{
            .turn = disc_turn(sampler_.sample_2d(point.path_key, sample_set(point.vertex, VertexSet::Direction)))};
        const RadianceEstimate caustic =
            estimate_caustic(shared_, maps_, point.surface, point.rough, point.wo, most, eye_.neighbours_, query);
        RadianceEstimate global;
        if (shared_.params.final_gather()) {
            eye_.gather_points_.push_back({point, FinalGather::key(point.path_key, point.vertex),
                                           split_of(shared_.splits.gather_rays, point.throughput, point.eta_scale),
                                           split_of(shared_.splits.light_samples, point.throughput, point.eta_scale)});
        } else {
            global =
                estimate_global(shared_, maps_, point.surface, point.rough, point.wo, most, eye_.neighbours_, query);
        }
        image_.of<Layer::Indirect>()[point.pixel] += point.throughput * (caustic.radiance + global.radiance);
        if (image_.layers.has(Layer::Caustic) && point.scatterings == 0)
            image_.of<Layer::Caustic>()[point.pixel] += point.throughput * caustic.delta_radiance;
        if (image_.layers.has(Layer::PhotonCount))
            image_.of<Layer::PhotonCount>()[point.pixel] += static_cast<float>(caustic.photons + global.photons);
    }

    EyePass& eye_;
    const PassSampler& sampler_;
    const GatherPass& pass_;
    const GatheringScene& shared_;
    const PassMaps& maps_;
    PassImage& image_;
    const CancelToken& cancel_;
};

EyePass::EyePass() : walk_(kTileSide) { gather_points_.reserve(size_t{kTileSide} * kTileSide); }

uint64_t EyePass::bytes_per_thread() {
    return SpecularWalk::bytes_per_thread(kTileSide) + size_t{kTileSide} * kTileSide * sizeof(GatherPoint) +
           FinalGather::bytes_per_thread();
}

void EyePass::trace_tile(const EyePassSetting& setting, const Tile& tile, RayEndLookups& ends, PassImage& image,
                         Counts& counts, EyeSeconds& seconds, const CancelToken& cancel) {
    const auto& [shared, maps, samplers] = setting;
    Guide guide(shared, maps, neighbours_);
    const GatherPass pass{shared, maps, samplers.gather, ends, image, counts};
    Lookups lookups(*this, samplers.path, pass, cancel);
    const WalkSettings settings{shared.params.glossy_threshold, Guide::needed(shared, maps) ? &guide : nullptr};
    walk_.trace_tile(shared, settings, {samplers.path, samplers.light.all()}, tile, image, counts, seconds, cancel,
                     lookups);
}

}  // namespace photond
