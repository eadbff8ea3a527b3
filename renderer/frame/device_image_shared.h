// The layers of a pass on the device: planes of one float buffer, each as large as the film, channel beside channel.
// For both compilers.
#ifndef PHOTOND_DEVICE_IMAGE_SHARED_H
#define PHOTOND_DEVICE_IMAGE_SHARED_H

// Specialisation constants: the first plane of a layer (three for colours and vectors), NO_PLANE where it is not kept;
// and how many planes there are.
#define PLANE_CAUSTIC_ID 32
#define PLANE_ALBEDO_ID 33
#define PLANE_NORMAL_ID 34
#define PLANE_POSITION_ID 35
#define PLANE_DEPTH_ID 36
#define PLANE_PHOTON_COUNT_ID 37
#define PLANE_OVERLAP_ID 38
#define PLANE_HIT_ID 39
#define PLANES_ID 40
#define PLANE_CLAMPED_ID 70
#define PLANE_VOXELS_ID 71
#define PLANE_VPLS_ID 72
#define PLANE_SPLIT_NORMAL_ID 73
#define PLANE_SPLIT_INDIRECT_ID 74
#define NO_PLANE 0xffffffffu

// Emitted, direct and indirect are always there, in this order.
#define PLANE_EMITTED 0
#define PLANE_DIRECT 3
#define PLANE_INDIRECT 6

#endif
