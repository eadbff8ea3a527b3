// The state DeviceTiles::record() left, for shaders that run by it. Define DEVICE_TILES_BINDING first.
#ifndef PHOTOND_DEVICE_TILES_GLSL
#define PHOTOND_DEVICE_TILES_GLSL

#include "renderer/backends/gpu/device_tiles_shared.h"

layout(set = 0, binding = DEVICE_TILES_BINDING, scalar) readonly buffer DeviceTilesBuffer { DeviceTilesState tiles_state; };

/// Which tile this group takes; the last row's groups may be past the last tile.
uint tile_index() { return gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x; }

#endif
