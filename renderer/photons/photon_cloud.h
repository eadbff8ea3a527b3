#pragma once
// Photon maps as a file to look at: a binary glTF with one point for each photon.

#include <filesystem>

#include "renderer/photons/photon_map.h"

namespace photond {

/// One node at `origin` (Scene::origin, world [m]) with one mesh of POINTS: a primitive with the material "global
/// photons", one with "caustic photons", left out where a map is empty. Each photon has POSITION and NORMAL (of the
/// surface), COLOR_0 (linear RGB: its power, scaled so that the mean luminance of its map is kPhotonCloudMeanLuminance,
/// cut at 1), _POWER (W), _DIRECTION (towards where the light came from) and _SCATTERINGS (since the light, at most
/// 255). Written whole or not at all. Throws ErrorCode::NoSpace, and ErrorCode::OutOfRange when the photons need more
/// than the 4 GiB a binary glTF can have.
void write_photon_cloud(const PhotonMap& global, const PhotonMap& caustic, const dvec3& origin,
                        const std::filesystem::path& path);

/// Bytes of such a file, to some kilobytes.
uint64_t photon_cloud_bytes(uint64_t photons);

inline constexpr double kPhotonCloudMeanLuminance = 0.5;

}  // namespace photond
