// The layer that shows splats, for both compilers.
#ifndef PHOTOND_SPLAT_LAYERS_SHARED_H
#define PHOTOND_SPLAT_LAYERS_SHARED_H

#define PLANE_OVERLAP_ID 38  // specialisation constant: where the layer is

#endif
