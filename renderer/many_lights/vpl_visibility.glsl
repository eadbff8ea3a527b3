// V of virtual point lights, as the build's row says for this variant of a shader (CMakeLists.txt): each file defines
// vpl_visibility_asks() and vpl_occluded().
#if defined(VARIANT_none)
#include "renderer/many_lights/vpl_visibility_none.glsl"
#elif defined(VARIANT_rays)
#include "renderer/many_lights/vpl_visibility_rays.glsl"
#elif defined(VARIANT_maps)
#include "renderer/many_lights/vpl_visibility_maps.glsl"
#elif defined(VARIANT_svo)
#include "renderer/many_lights/vpl_visibility_svo.glsl"
#else
#error "no variant: a row of CMakeLists.txt names those of this shader"
#endif
