// Layers that show what the method works with (svo_layers.h), for both compilers.
#ifndef PHOTOND_SVO_LAYERS_SHARED_H
#define PHOTOND_SVO_LAYERS_SHARED_H

// Specialisation constants: their planes (frame/device_image_shared.h).
#define PLANE_VOXELS_ID 71
#define PLANE_VPLS_ID 72

#endif
