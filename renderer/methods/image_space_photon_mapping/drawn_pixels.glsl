// Which pixels are lit by photons that are drawn over them (photon_raster.h); the others are gone through by tiles. Define
// FOOTPRINTS (the PhotonScatterConstants) before, and include disc_coverage.glsl and upsampling.glsl.
#ifndef PHOTOND_DRAWN_PIXELS_GLSL
#define PHOTOND_DRAWN_PIXELS_GLSL

#include "renderer/scene/camera_projection.glsl"
#include "renderer/splats/splat_film.glsl"

layout(constant_id = SCATTER_DRAWS_ID) const bool SCATTER_DRAWS = false;

/// `radius_m`: of the footprints. Not those whose point the image shows elsewhere, in mirrors or out of focus; whose light
/// depends on the direction; or whose disc is cut.
bool is_drawn(uint x, uint y, GBufferPoint point, float radius_m) {
    if (!SCATTER_DRAWS || !is_lit(point) || is_general(point)) return false;
    if (FOOTPRINTS.split.side > 1u && !is_sub_sample(FOOTPRINTS.split, x, y)) return false;
    vec2 film;
    if (!project(FOOTPRINTS.camera, point.position, film)) return false;
    const vec2 from_middle = abs(film - (vec2(x, y) + 0.5));
    if (!(max_component(vec3(from_middle, 0.0)) <= FOOTPRINTS.filter_reach + 0.01)) return false;
    return !(DISC_COVERAGE && has_edges(point.position, radius_m));
}

#endif
