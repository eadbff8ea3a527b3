#pragma once
// Looks at what the method works with: the voxels, and where its lights are (thesis, Figures 4.3 and 4.9). GPU twins:
// svo_voxels.comp, svo_vpls.comp.

#include <span>

#include "renderer/eye/eye_scene.h"
#include "renderer/gbuffer/gbuffer.h"
#include "renderer/many_lights/vpl.h"
#include "renderer/voxels/svo_march.h"

namespace photond {

/// Layer `voxels`: the first voxel on the ray through each pixel's centre, its brick's colour in the light of a lamp at
/// the eye. Black where the ray meets none.
void show_voxels(const SvoView& tree, const EyeScene& eye, std::vector<Rgb>& layer);

/// Layer `vpls`: how many lights lie in each pixel that are no farther away, or nearer, than what it shows by more than
/// a hundredth.
void show_vpls(std::span<const Vpl> vpls, const EyeScene& eye, const GBuffer& buffer, std::vector<float>& layer);

}  // namespace photond
