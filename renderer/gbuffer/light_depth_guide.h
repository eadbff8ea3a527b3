#pragma once
// Direct light of punctual lights by their depth maps, for the walk from the eye; other lights keep shadow rays. GPU
// twin: gbuffer_walk_depth_maps.comp.

#include "renderer/eye/specular_walk.h"
#include "renderer/gbuffer/light_depth_maps.h"

namespace photond {

/// Of one pass: other passes, and other seeds, ask other texels of the filter. Borrows the maps.
class LightDepthGuide final : public WalkGuide {
public:
    LightDepthGuide(const LightDepthMaps& maps, const PassSampler& sampler, uint32_t pass)
        : maps_(maps), pass_key_(sampler.pixel_key(pass)) {}

    WalkVertex decide(const Rgb&, float, bool) const override { return {}; }
    LightSeen light_seen(const vec3& position, const vec3& normal, uint32_t source) override {
        return maps_.seen(source, position, normal, LightDepthMaps::tap_number(position, source, pass_key_));
    }

private:
    const LightDepthMaps& maps_;
    const uint32_t pass_key_;
};

}  // namespace photond
