#pragma once
// The families of built-in scenes, one file each; builtin_scenes.cpp lists them by name. None is finished yet
// (finish_scene).

#include "renderer/scene/scene.h"

namespace photond {

// builtin_cornell.cpp: the measured Cornell box and its variations.
Scene make_cornell_box();
Scene make_cornell_box_spot();
Scene make_cornell_box_glass();
Scene make_cornell_box_glossy();
// Of Figure 6 of the paper on visibility filtering.
Scene make_box_of_glossiness_10();
Scene make_box_of_glossiness_30();
Scene make_box_of_glossiness_50();

// builtin_studies.cpp: small scenes that each show one thing.
Scene make_furnace();
Scene make_caustic_ring();
Scene make_keyhole();

// builtin_interior.cpp: a furnished room.
Scene make_interior();

// builtin_conference.cpp: a larger one.
Scene make_conference();

// builtin_splatting_figures.cpp: figures of the photon splatting thesis.
Scene make_splatting_plate();
Scene make_splatting_skimming_ray();
Scene make_splatting_chairs();

// builtin_details.cpp: what stands at the foot of a wall and hangs on it.
Scene make_detail_bar();
Scene make_detail_bar_at_mid_height();
Scene make_detail_stepped_bars();
Scene make_detail_moulding();
Scene make_detail_bevel();
Scene make_detail_shelf();
Scene make_detail_books();

// builtin_caustics.cpp: light that glass and mirrors cast.
Scene make_glass_on_floor();

// builtin_progressive.cpp: scenes of the papers on progressive photon mapping, lit through glass.
Scene make_progressive_lamp();
Scene make_progressive_box();
Scene make_progressive_torus();
Scene make_progressive_torus_spot();
// builtin_bathroom.cpp, builtin_flashlight.cpp: two more of them.
Scene make_progressive_mirror_bathroom();
Scene make_progressive_flashlight();

// builtin_bidirectional.cpp: scenes for methods that join paths from the eye and from the lights.
Scene make_small_vcm_sun();
Scene make_small_vcm_ceiling();
Scene make_small_vcm_point();
Scene make_small_vcm_sky();
Scene make_ajar_door();

// builtin_moving.cpp: animated scenes.
Scene make_moving_cornell_box();
Scene make_moving_thin_object();
Scene make_moving_teleport();
Scene make_moving_appearing();
Scene make_moving_light_switched_on();
Scene make_moving_light_switched_off();

/// A matte material without the 4 % specular lobe of a glTF non-metal: pure Lambert.
Material lambert(const char* name, const Rgb& albedo);
Material metal(const char* name, const Rgb& reflectance, float roughness);
/// Lambert below a smooth or rough dielectric coat of index 1.5.
Material plastic(const char* name, const Rgb& albedo, float roughness);
/// Solid glass of index 1.5, clear.
Material glass(const char* name);
/// Emits and reflects nothing.
Material emitter(const char* name, const Rgb& radiance);

/// Adds a material and returns its index.
uint32_t add_material(Scene& scene, Material material);
/// Adds a mesh with one placing of its own, in world space.
void add_mesh(Scene& scene, Mesh mesh);
/// Adds a camera named "camera".
void add_camera(Scene& scene, const dvec3& eye, const dvec3& target, float yfov);

}  // namespace photond
