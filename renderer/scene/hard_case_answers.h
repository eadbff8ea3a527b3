#pragma once
// Closed forms that the hard cases' answers are made of, all in double. None shares code with the renderer.
//
// [Howell 1982] A Catalog of Radiation Heat Transfer Configuration Factors. McGraw-Hill.
// [Baum, Rushmeier, Winget 1989] Improving Radiosity Solutions Through the Use of Analytically Determined Form-Factors.
//     SIGGRAPH.
// [Van Oosterom and Strackee 1983] The Solid Angle of a Plane Triangle. IEEE Trans. Biomed. Eng. 30(2).
// [Heitz 2014] Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs. JCGT 3(2).

#include <span>

#include "renderer/core/geometry.h"

namespace photond {

/// An axis-parallel rectangle in its plane [m].
struct Rectangle {
    double x0, x1, y0, y1;
    double area() const { return (x1 - x0) * (y1 - y0); }
};

/// Share of the diffuse light of `from` that meets `to`, which lies in a parallel plane at distance `gap` > 0 and faces
/// it. With a Lambert receiver `from` of albedo rho and an emitter `to` of radiance L, the receiver's mean radiance is
/// rho L times it. [Howell 1982, C-13]
double parallel_form_factor(const Rectangle& from, const Rectangle& to, double gap);

/// The same for rectangles in perpendicular planes: `from` has its x along the distance from the planes' common line
/// (x0 >= 0) and y along that line, `to` likewise in the other plane. [Howell 1982, C-15]
double perpendicular_form_factor(const Rectangle& from, const Rectangle& to);

/// Irradiance [W m^-2] at `point` with normal `normal` from a polygon of unit radiance that is wholly above the
/// point's plane. Corners counter-clockwise as seen from the point: positive. [Baum et al. 1989, Eq. 5]
double polygon_irradiance(const dvec3& point, const dvec3& normal, std::span<const dvec3> corners);

/// Solid angle [sr] of the triangle (a, b, c) from the origin. [Van Oosterom and Strackee 1983, Eq. 8]
double triangle_solid_angle(const dvec3& a, const dvec3& b, const dvec3& c);

/// Share of light from the direction of cosine `cos_o` that a GGX surface of this roughness (alpha = roughness^2) and
/// reflectance 1 sends on in a single scattering, height-correlated Smith shadowing; by quadrature, to 1e-4.
double ggx_directional_albedo(double roughness, double cos_o);

}  // namespace photond
