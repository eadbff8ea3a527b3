#include "renderer/methods/photon_mapping/eye_pass.h"

namespace photond {

namespace {

/// With the general form's BSDF and surface, as far as lookups and gather rays ask for them.
VisiblePoint general_point(const SpecularWalk& walk, const LambertVisiblePoint& point) {
    const EyePath& path = walk.path(point);
    VisiblePoint general;
    general.surface.position = point.position;
    general.surface.geometric_normal = point.geometric_normal;
    general.surface.smooth_normal = point.normal;
    general.surface.shading = Frame(point.normal);
    general.rough = Bsdf::lambert(general.surface.shading.to_local(point.geometric_normal), point.reflectance);
    general.wo = vec3(0, 0, 1);  // to a Lambert reflector all directions above the horizon are one
    general.throughput = path.throughput;
    general.eta_scale = path.eta_scale;
    general.pixel = point.pixel;
    general.scatterings = point.scatterings;
    general.media = path.media;
    general.path_key = walk.path_key(point);
    general.vertex = walk.vertex();
    general.lit_normal = point.normal;
    return general;
}

}  // namespace

/// Many light samples where many rays are gathered, which compete with them; shadow photons.
class EyePass::Guide final : public WalkGuide {
public:
    Guide(const PhotonMappingScene& shared, const PassMaps& maps, Neighbours& scratch)
        : shared_(shared), maps_(maps), scratch_(scratch) {}

    static bool needed(const PhotonMappingScene& shared, const PassMaps& maps) {
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
    const PhotonMappingScene& shared_;
    const PassMaps& maps_;
    Neighbours& scratch_;
};

/// Light of the maps that visible points scatter, and what they gather.
class EyePass::Lookups final : public VisiblePointSink {
public:
    Lookups(EyePass& pass, const PhotonMappingScene& shared, const PassMaps& maps, const PassSamplers& samplers,
            PassImage& image, Counts& counts, const CancelToken& cancel)
        : pass_(pass),
          shared_(shared),
          maps_(maps),
          sampler_(samplers.path),
          gather_(samplers.gather),
          image_(image),
          counts_(counts),
          cancel_(cancel) {}

    void take(std::span<const LambertVisiblePoint> lambert, std::span<const VisiblePoint> others) override {
        pass_.gather_points_.clear();
        for (const LambertVisiblePoint& point : lambert) look_up(general_point(pass_.walk_, point));
        for (const VisiblePoint& point : others) look_up(point);
        if (shared_.final_gather())
            pass_.final_gather_.gather(shared_, maps_, gather_, pass_.gather_points_, image_, counts_, cancel_);
    }

private:
    void look_up(const VisiblePoint& point) {
        const uint32_t most = shared_.photon_scatterings(point.scatterings + 1);
        const uint32_t turn =
            disc_turn(sampler_.sample_2d(point.path_key, sample_set(point.vertex, VertexSet::Direction)));
        const RadianceEstimate caustic =
            estimate_caustic(shared_, maps_, point.surface, point.rough, point.wo, most, pass_.neighbours_, turn);
        RadianceEstimate global;
        if (shared_.final_gather()) {
            pass_.gather_points_.push_back({point, FinalGather::key(point.path_key, point.vertex),
                                            split_of(shared_.splits.gather_rays, point.throughput, point.eta_scale),
                                            split_of(shared_.splits.light_samples, point.throughput, point.eta_scale)});
        } else {
            global =
                estimate_global(shared_, maps_, point.surface, point.rough, point.wo, most, pass_.neighbours_, turn);
        }
        image_.of<Layer::Indirect>()[point.pixel] += point.throughput * (caustic.radiance + global.radiance);
        if (image_.layers.has(Layer::Caustic) && point.scatterings == 0)
            image_.of<Layer::Caustic>()[point.pixel] += point.throughput * caustic.delta_radiance;
        if (image_.layers.has(Layer::PhotonCount))
            image_.of<Layer::PhotonCount>()[point.pixel] += static_cast<float>(caustic.photons + global.photons);
    }

    EyePass& pass_;
    const PhotonMappingScene& shared_;
    const PassMaps& maps_;
    const PassSampler& sampler_;
    const SplitSamplers& gather_;
    PassImage& image_;
    Counts& counts_;
    const CancelToken& cancel_;
};

EyePass::EyePass() : walk_(kTileSide) { gather_points_.reserve(size_t{kTileSide} * kTileSide); }

uint64_t EyePass::bytes_per_thread() {
    return SpecularWalk::bytes_per_thread(kTileSide) + size_t{kTileSide} * kTileSide * sizeof(GatherPoint) +
           FinalGather::bytes_per_thread();
}

void EyePass::trace_tile(const PhotonMappingScene& shared, const PassMaps& maps, const PassSamplers& samplers,
                         const Tile& tile, PassImage& image, Counts& counts, EyeSeconds& seconds,
                         const CancelToken& cancel) {
    Guide guide(shared, maps, neighbours_);
    Lookups lookups(*this, shared, maps, samplers, image, counts, cancel);
    const WalkSettings settings{shared.params.glossy_threshold, Guide::needed(shared, maps) ? &guide : nullptr};
    walk_.trace_tile(shared, settings, {samplers.path, samplers.light.all()}, tile, image, counts, seconds, cancel,
                     lookups);
}

}  // namespace photond
