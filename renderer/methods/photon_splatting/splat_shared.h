// What photon splatting keeps on the device, for both compilers. CPU twins: splat.h, visible_clusters.h,
// splat_settings.h.
#ifndef PHOTOND_SPLAT_SHARED_H
#define PHOTOND_SPLAT_SHARED_H

#include "renderer/gbuffer/gbuffer_shared.h"
#include "renderer/photons/kernel_shared.h"

#define SPLAT_GROUP 64  // threads of a group that lights a cluster, and most points of one: a tile of EYE_TILE squared
#define MOST_DEPTH_TEXELS 64  // SplatDepthMaps::kMostResolution

#define SPLAT_MOST_SLOPE 6.0f  // of depth maps, depth over distance across: 80.5 degrees of incidence
#define SPLAT_OFF_PLANE 1e-6f  // that points on a plane may lie beside it, over their coordinates
#define BEAM_WAY_SHARE 0.5f    // of the way that a beam has come, which its radius is no more than; both of BeamSizes
#define BEAM_LEAST_SHARE 0.015625f  // of the greatest radius: no beam is narrower, though light may meet in a point
#define SPLAT_CLAMP_SHARE 0.16f     // of a splat's radius: connections are clamped within it, and repaid by short rays

// Specialisation constants of the shaders here, after those of device_image_shared.h.
#define SPLAT_HAS_CONNECTIONS_ID 48
#define SPLAT_HAS_BEAMS_ID 49
#define SPLAT_NORMALISED_ID 50
#define SPLAT_VISIBILITY_ID 51
#define SPLAT_STRATIFIED_ID 52
#define SPLAT_EDGES_ID 53  // whether the blur asks for normals and depths

#define NO_POINT 0xffffffffu
#define POINT_GENERAL 0x80000000u  // in SplatPoint::kind: not Lambert

// Splat::kind, its lowest bits.
#define SPLAT_NONE 0u  // lights nothing
#define SPLAT_CONNECT 1u
#define SPLAT_CONNECT_ROUGH 2u
#define SPLAT_BEAM 3u
#define SPLAT_KIND_MASK 3u
#define SPLAT_CORRECTED 4u         // SPLAT_CONNECT: by shading normals
#define SPLAT_SCATTERINGS_SHIFT 8  // above: the photon's

// SplatCounts: words of one buffer.
#define SPLAT_COUNT_POINTS 0  // visible points; more than there is room for: those past it were left out
#define SPLAT_COUNT_CLUSTERS 1
#define SPLAT_COUNTS 2

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
using glm::uvec4;
#else
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#endif

/// A cell of BeamSizes that is cut in two, by the coordinate along an axis; or one that is not, with the radius of
/// beams that land there [m].
struct BeamCell {
    float split_or_radius;
    uint axis;
};

/// Lengths and choices of the method in a scene: SplatSettings, sizes by the pilot, and what changes from pass to pass.
struct SplatConstants {
    uint64_t seed;
    uint pass;
    float shrink;         // SplatSettings::shrink(pass)
    KernelRecord kernel;  // SplatSettings::filter
    float radius_m;
    float beam_radius_m;
    float beam_step_back_m;  // SplatSettings
    float beam_step_back_radii;
    float beam_depth_m;
    float beam_depth_radii;
    uint beam_levels;  // BeamSizes; of beam_casters as many as there are instances, or none
    uint beam_casters;
    uint shadow_resolution;
    uint rays_per_photon;
    uint connects;           // 0: rough photons light along their rays too
    float glossy_threshold;  // of eye paths
    float photon_threshold;  // of photons
    float colour_scale;      // `normalised`: of a power as a colour, paths / surface area
    float exposure;          // `normalised`
    float ambient;
    uint point_capacity;
    uint cluster_capacity;
    vec3 sizes_low;  // SplatSizes: its grid
    float sizes_cell_m;
    uvec3 sizes_cells;  // 0: the same radius everywhere
};

/// A visible point. PointBlock has the CPU's.
struct SplatPoint {
    vec3 position;  // world [m]
    uint pixel;
    vec3 normal;            // that shades; 0 where light from both sides counts
    uint next;              // of the pixel's other points, or NO_POINT
    vec3 geometric_normal;  // on the eye's side
    uint kind;              // scatterings a photon that lights it may have had, and POINT_GENERAL
    vec3 weight;            // Lambert: throughput times reflectance / pi; others: throughput
    float splat_radius_m;   // of connections that light it
};

/// What splats have brought to a point.
struct SplatSum {
    vec3 sum;            // Lambert: irradiance [W m^-2], others: radiance [W m^-2 sr^-1]
    float splats;        // that reach the point
    float splat_weight;  // `normalised`: sum of the filter's weights
};

/// Points that one group of threads lights: those that a tile of the image left at one vertex of its paths.
struct SplatCluster {
    vec3 centre;  // of a box, and of a sphere about the points
    float radius_m;
    vec3 half_extent;
    float splat_radius_m;  // greatest of its points
    vec3 normal;           // unit, of the plane that all are on; 0: none
    uint first_point;
    uint points;
    uint most_scatterings;  // greatest of its points
};

/// A photon's ray and what it brings to the points about it. splat.h's.
struct Splat {
    vec3 origin;   // world [m]
    float radius;  // connections: over the receiver's splat_radius_m; beams: [m]
    vec3 axis;     // unit
    float disc;    // connections: of the disc that stands for the filter near y's horizon, over the radius
    vec3 normal;   // geometric, at y
    uint kind;     // SPLAT_*, and the photon's scatterings
    vec3 intensity;
    float weight;  // `normalised`: of its cell
    float near_m;  // beams: the part of the ray that they light
    float far_m;
    uint smooth_normal;  // connections, SPLAT_CORRECTED: ReflectedPhoton's
    float correction;
    uint surface;  // SPLAT_CONNECT_ROUGH: among the reflecting surfaces
};

/// Tiles of the film, a group each.
struct SplatEyePush {
    uint first_tile;
    uint end_tile;
};
/// Clusters, a group each, and the splats of a batch that light them.
struct SplatClusterPush {
    uint first_cluster;
    uint end_cluster;
    uint first_splat;
    uint end_splat;
};
/// Sources of a batch: the batch's first splat is that source's.
struct SplatMakePush {
    uint first_source;
    uint end_source;
    uint splats;  // of the batch: no more are made
};
/// Points, a thread each.
struct SplatPointPush {
    uint first_point;
    uint end_point;
};

#ifdef __cplusplus
static_assert(sizeof(SplatConstants) == 128 && sizeof(SplatPoint) == 64 && sizeof(SplatSum) == 20 &&
                  sizeof(SplatCluster) == 56 && sizeof(Splat) == 84,
              "must match the scalar layout of GLSL");
}  // namespace photond::gpu
#endif

#endif
