// GLSL twin of transport/mis.h.
#ifndef PHOTOND_MIS_GLSL
#define PHOTOND_MIS_GLSL

#include "renderer/core/geometry.glsl"

/// Balance heuristic for one sample of each of two techniques; the densities are of the same measure. 0 when both are
/// 0.
float balance_heuristic(float pdf, float other_pdf) { return pdf > 0 ? pdf / (pdf + other_pdf) : 0.0; }

/// Power heuristic with exponent 2, [Veach and Guibas 1995, sec. 4.1]. Written with the ratio of the densities, so that
/// neither square overflows. 0 when `pdf` is 0.
float power_heuristic(float pdf, float other_pdf) { return pdf > 0 ? 1.0 / (1.0 + sqr(other_pdf / pdf)) : 0.0; }

/// Density per area [m^-2] as density per solid angle [sr^-1], seen from `distance_sq_m2` away under `cos_at_surface`
/// (absolute value taken). Infinite where the surface is seen edge-on.
float area_to_solid_angle_pdf(float pdf_area, float distance_sq_m2, float cos_at_surface) {
    return pdf_area * distance_sq_m2 / abs(cos_at_surface);
}

#endif
