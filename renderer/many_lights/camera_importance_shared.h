// CameraImportance (camera_importance.h) on a device, for both compilers.
#ifndef PHOTOND_CAMERA_IMPORTANCE_SHARED_H
#define PHOTOND_CAMERA_IMPORTANCE_SHARED_H

#define CAMERA_IMPORTANCE_POINTS 64  // CameraImportance::kPoints
#define CAMERA_IMPORTANCE_ASKED 16   // of those, by a light path
#define CAMERA_IMPORTANCE_STREAM 1   // of RandomDomain::Splats in a pass, that chooses them
#define CAMERA_IMPORTANCE_GROUP 64   // threads

// Specialisation constant, after those of device_image_shared.h.
#define IMPORTANCE_HAS_TREE_ID 48

#ifdef __cplusplus
namespace photond::gpu {
#else
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#endif

struct CameraImportancePush {
    uint64_t seed;
    uint pass;
    uint points;       // of the G-buffer
    uint first_texel;  // half open
    uint end_texel;
    float clamp_sq_m2;
    uint unused;  // the compilers differ in whether they would leave room here
};

#ifdef __cplusplus
static_assert(sizeof(CameraImportancePush) == 32, "must match the scalar layout of GLSL");
}  // namespace photond::gpu
#endif

#endif
