#pragma once
// What many lights take on the CPU, as far as it is known before.

#include "renderer/methods/svo_many_lights/svo_many_lights.h"

namespace photond {

/// What lights take beside their photons: lists in subsets, surfaces where not all is Lambert.
uint64_t light_bytes(const SvoManyLightsParams& params, const Needs& needs);
/// Of the octree where nothing is known of the scene but that it has rooms: surfaces of some times the cube's side.
uint64_t voxel_tree_bytes(const SvoManyLightsParams& params);

}  // namespace photond
