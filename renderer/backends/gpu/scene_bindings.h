// The buffers of descriptor set 1, the scene: written once by DeviceScene (device_scene.h), then only read. For both
// compilers. Who declares a buffer in GLSL is said beside it.
#ifndef PHOTOND_SCENE_BINDINGS_H
#define PHOTOND_SCENE_BINDINGS_H

#define SCENE_SET 1

#define SCENE_CONSTANTS_BINDING 0  // backends/gpu/scene.glsl
#define BVH_NODES_BINDING 1        // backends/gpu/bvh.glsl
#define BVH_TRIANGLES_BINDING 2    // backends/gpu/bvh.glsl
#define TRIANGLES_BINDING 3        // backends/gpu/scene.glsl, as all up to TEXELS
#define POSITIONS_BINDING 4
#define ATTRIBUTES_BINDING 5
#define MESHES_BINDING 6
#define INSTANCES_BINDING 7
#define MATERIALS_BINDING 8
#define TEXTURES_BINDING 9
#define TEXELS_BINDING 10
#define EMITTERS_BINDING 11         // transport/light_triangle.glsl
#define LIGHT_NODES_BINDING 12      // transport/light_tree.glsl
#define LIGHT_WORDS_BINDING 13      // transport/light_tables.glsl
#define PUNCTUAL_LIGHTS_BINDING 14  // transport/punctual.glsl
#define LIGHT_FLOATS_BINDING 15     // transport/light_tables.glsl
#define ENVIRONMENT_BINDING 16      // transport/environment_sampling.glsl
#define TABLES_BINDING 17           // transport/bsdf_albedo_table.glsl
#define SOBOL_BINDING 18            // transport/sobol.glsl
#define LIGHT_CONSTANTS_BINDING 19  // transport/light_tables.glsl
#define SCENE_BINDINGS 20

#endif
