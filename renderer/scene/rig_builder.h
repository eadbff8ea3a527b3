#pragma once
// Rigs put together in code, and what the loader shares with that.

#include <initializer_list>

#include "renderer/scene/pose.h"

namespace photond {

/// Gives the index of the new node. Nodes added so are listed in this order, parents before their children.
uint32_t add_node(Rig& rig, RigNode node);

/// Gives the scene a mesh with one instance, which the rig poses. `object`: its material is the scene's.
void add_rigged_mesh(Scene& scene, Rig& rig, std::shared_ptr<const ObjectMesh> object, uint32_t node,
                     std::optional<uint32_t> skin = std::nullopt);

/// A quaternion (x, y, z, w): by `angle` [rad] about a unit axis, counter-clockwise seen against it.
std::vector<float> turn_about(const dvec3& axis, double angle);

/// A channel with a value of as many numbers as `width` at each time.
Channel drive(Property property, uint32_t target, std::vector<float> times, std::vector<float> values,
              Interpolation interpolation = Interpolation::Linear);

/// Joins values, as of keys, to one list.
std::vector<float> keys_of(std::initializer_list<std::vector<float>> values);

}  // namespace photond
