#include "renderer/methods/svo_many_lights/svo_memory.h"

#include "renderer/eye/specular_walk.h"
#include "renderer/film/film.h"
#include "renderer/gbuffer/gbuffer.h"
#include "renderer/gbuffer/light_depth_maps.h"
#include "renderer/many_lights/vpl_lighting.h"
#include "renderer/many_lights/vpl_shadow_maps.h"
#include "renderer/methods/svo_many_lights/svo_settings.h"
#include "renderer/voxels/sparse_voxel_octree.h"

namespace photond {

namespace {

/// Values a point has besides its place: what lights bring it, what is repaid, what narrow lobes send, and what the
/// filter leaves.
uint64_t values_of_point(const SvoManyLightsParams& params, const Needs& needs) {
    return uint64_t{2} + (asks_narrow_lobes(params, needs) ? 1 : 0) + (params.filter > 0 ? 1 : 0);
}

}  // namespace

uint64_t light_bytes(const SvoManyLightsParams& params, const Needs& needs) {
    const uint64_t lights = expected_vpls(params.vpls, std::max(params.bounces, 1u));
    const uint64_t maps =
        params.visibility == VplVisibility::ShadowMaps ? VplShadowMaps::bytes_for(lights, params.shadow_resolution) : 0;
    const uint64_t padding = uint64_t{params.split_side()} * params.split_side() * sizeof(VplBlock);
    return lights * (sizeof(Vpl) + sizeof(VplBlock) / kLanes + (needs.only_lambert() ? 0 : sizeof(RoughOrigin))) +
           padding + maps;
}

uint64_t voxel_tree_bytes(const SvoManyLightsParams& params) {
    constexpr double kSurface = 8, kNodesABrick = 3, kVoxelsABrick = 16;
    const double side = params.voxel_resolution / double{BRICK_SIDE};
    const double bricks = std::min(kSurface * side * side, side * side * side);
    const double surfaces = traces_voxels(params) ? (1 + kVoxelsABrick) * sizeof(uint32_t) : 0;
    return static_cast<uint64_t>(bricks * (kNodesABrick * sizeof(gpu::SvoNode) + sizeof(gpu::SvoBrick) + surfaces));
}

uint64_t SvoManyLights::estimate_bytes(const SvoManyLightsParams& params, const Workload& workload) {
    const bool lights = workload.lights > 0 || workload.environment_size.pixels() > 0;
    uint64_t bytes = PassImage::bytes_for(workload.film_size, workload.layers) +
                     workload.threads * SpecularWalk::bytes_per_thread(GBuffer::kTileSide) +
                     LightSampler::estimate_bytes(workload.lights, workload.environment_size) +
                     GBuffer::estimate_bytes(workload.film_size, workload.needs) +
                     values_of_point(params, workload.needs) * workload.film_size.pixels() * sizeof(Rgb);
    if (has_light_maps(params, workload.needs)) bytes += LightDepthMaps::guess_bytes(params.direct_resolution);
    if (!lights || params.bounces == 0) return bytes;
    bytes += EmissionSampler::estimate_bytes(workload.lights, workload.environment_size) +
             VplTracer::scratch_bytes(tracing_of(params), workload.threads, workload.lights) +
             VplTracer::result_bytes(tracing_of(params)) + light_bytes(params, workload.needs) +
             VplsBetweenFrames::bytes_for(params.incremental, params.vpls);
    if (params.needs_voxels(workload.layers)) bytes += voxel_tree_bytes(params);
    if (sends_caustics(params, workload))
        bytes +=
            CausticPhotons::estimate_bytes(workload.lights, workload.threads) +
            CausticPhotons::map_bytes(caustics_of(params), workload.photon_yield ? workload.photon_yield->caustic.guided
                                                                                 : kExpectedCausticYield);
    return bytes;
}

}  // namespace photond
