#pragma once
// Material colours that vary over a surface and are needed before any BSDF is: emission and coverage, textures
// included. transport/emission.h is what paths use; finding a scene's lights needs the same numbers earlier.

#include "renderer/core/rgb.h"

namespace photond {

struct Scene;
struct Mesh;
struct TextureRef;

/// Texture coordinates of a reference at barycentrics (u, v) of a triangle, transform applied; (0, 0) where the mesh
/// has none in that set.
vec2 texture_coordinates(const Mesh& mesh, const TextureRef& reference, uint32_t triangle, float u, float v);

/// Emission [W m^-2 sr^-1]: factor x texture x strength; sides and unlit are not looked at.
Rgb surface_emission(const Scene& scene, const Mesh& mesh, uint32_t triangle, float u, float v);

/// Base colour (rgb) and alpha of the material: factor x texture x vertex colour.
vec4 surface_base_color(const Scene& scene, const Mesh& mesh, uint32_t triangle, float u, float v);

/// Asks the memory for what surface_base_color() will read of the texture.
void prefetch_base_color(const Scene& scene, const Mesh& mesh, uint32_t triangle, float u, float v);

/// Share of rays that meet the surface here: opaque 1; masked 0 or 1; blended its alpha.
float surface_coverage(const Scene& scene, const Mesh& mesh, uint32_t triangle, float u, float v);

}  // namespace photond
