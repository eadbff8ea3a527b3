#pragma once
// Shadow maps of the scene's own lights [Sun 2015, 4.4 and 4.9], traced: a ray a texel. Point lights have the six faces
// of a cube, spots a perspective map of their cone (wider than 60 degrees from the axis: a cube too),
// directional lights an orthographic map over the scene's bounds. Emissive triangles and the environment have none and
// keep shadow rays: a map shows what one point sees. GLSL twin: light_depth_maps.glsl; on the device:
// LightDepthMapsGpu.
//
// Percentage-closer filtering asks one texel at a time, at random within a square about the point's place in the map:
// the mean over passes is the filter's value.
//
// Bias. What a texel's ray met is compared with where the same ray meets the point's tangent plane, so that a plane
// shadows itself nowhere, however light grazes it and however wide the filter is: the slope's part of the bias is
// exact. What lies nearer than that by at most a texel's width at the point, and LIGHT_DEPTH_CONCAVE_SLOPE times the
// distance from the point to the ray, is tolerated, for surfaces that are not plane: where two faces meet at a right
// angle and light falls between them, depths differ from the plane's by tan a + 1 / tan a >= 2 times that distance.
// Planes are taken to rise by LIGHT_DEPTH_MOST_SLOPE times it at most, so that what lies beyond their horizon is no
// occluder. Lit falsely: what lies behind an occluder by less than is tolerated, along the ray. Dark falsely: concave
// edges that light grazes or that are sharper, within half the filter's width. And either where some of the filter's
// texels meet an occluder and some do not, which is what the filter is for. With LIGHT_DEPTH_CONCAVE_SLOPE = 2 both are
// about equally frequent; with 0 there is twice as much false shadow as false light.
//
// [Reeves et al. 1987] Rendering Antialiased Shadows with Depth Maps. SIGGRAPH.

#include <span>
#include <vector>

#include "renderer/core/stats.h"
#include "renderer/gbuffer/light_depth_shared.h"
#include "renderer/scene/intersector.h"
#include "renderer/transport/light_seen.h"

namespace photond {

/// The maps of a scene's punctual lights one behind the other, as both devices lay them out. Throws
/// ErrorCode::Unsupported past 2^32 texels in all.
struct LightDepthLayout {
    LightDepthLayout(const Scene& scene, uint32_t resolution, uint32_t pcf);

    gpu::LightDepthConstants constants;
    std::vector<gpu::LightDepthMap> maps;  // by punctual light
    uint32_t texels;                       // of all
};

class LightDepthMaps {
public:
    static constexpr uint32_t kLeastResolution = 8, kMostResolution = 8192;
    static constexpr uint32_t kMostPcf = 32;
    // Depth over distance across.

    /// Traces the maps, in parallel: stage `shadow_maps`, counts.shadow_rays. `resolution` texels along each side of a
    /// map or face; `pcf` texels along the side of the filter, 0 for none. Does not keep what it is given.
    LightDepthMaps(const Scene& scene, const Intersector& intersector, uint32_t resolution, uint32_t pcf, Stats& stats);

    /// Whole or Nothing as the map of a punctual light has it, Unknown of other sources (LightSample::source).
    /// `position` and `normal` (unit, geometric, of either side) of the surface that is lit; `u` uniform in [0, 1)^2
    /// chooses among the filter's texels.
    LightSeen seen(uint32_t source, const vec3& position, const vec3& normal, const vec2& u) const;

    /// A number for seen(), where the caller has none at hand: a hash of where and which pass.
    static vec2 tap_number(const vec3& position, uint32_t source, uint32_t pass_key);

    uint64_t bytes() const;
    /// Of the maps of a scene; the same on the device.
    static uint64_t bytes_for(const Scene& scene, uint32_t resolution);
    /// The same where nothing is known of them but that there are some: a spot has one map, a point six.
    static uint64_t guess_bytes(uint32_t resolution) { return 2ull * resolution * resolution * sizeof(float); }

    const LightDepthLayout& layout() const { return layout_; }
    std::span<const float> depths_m() const { return depths_m_; }

private:
    LightDepthLayout layout_;
    std::vector<float> depths_m_;
};

}  // namespace photond
