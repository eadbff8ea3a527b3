#pragma once
// What the hard cases' scenes and answers are put together from.

#include "renderer/scene/builtin_families.h"
#include "renderer/scene/hard_cases.h"
#include "renderer/scene/mesh_builder.h"

namespace photond::hard_case {

inline constexpr double kPiD = 3.14159265358979323846;
inline constexpr const char* kPrefix = "hard-case/";

/// An orthographic camera named "camera": the mean over its image is the mean over the plane it looks at.
void add_orthographic_camera(Scene& scene, const dvec3& eye, const dvec3& target, const dvec3& up, float half_height_m);
/// Straight down onto (x, z) from height y; the image's right is +x, its top -z.
void add_camera_down(Scene& scene, float x, float y, float z, float half_height_m);

/// Light from far away along `direction`; irradiance [W m^-2] on a plane perpendicular to it.
void add_directional_light(Scene& scene, const vec3& direction, const Rgb& irradiance);
void add_point_light(Scene& scene, const vec3& position, const Rgb& intensity);

/// A level rectangle at height y whose front looks up, or down.
Mesh level_rectangle(float x0, float x1, float z0, float z1, float y, bool front_up, uint32_t material);
/// The inside of a box: fronts look inwards.
Mesh inward_box(const vec3& min, const vec3& max, uint32_t material);

/// Checks of the image's whole region.
KnownCheck equals(std::string_view layer, const dvec3& value, std::optional<uint32_t> bounces = {},
                  double tolerance = 0);
KnownCheck at_most(std::string_view layer, const dvec3& value, std::optional<uint32_t> bounces = {});
KnownCheck zero(std::string_view layer, std::optional<uint32_t> bounces = {});
KnownCheck same_as(std::string_view layer, std::string_view name, double scale, std::optional<uint32_t> bounces = {});
KnownCheck reference(std::string_view layer, std::optional<uint32_t> bounces = {});
KnownCheck finite();
/// The same check of a part of the image.
KnownCheck in_region(KnownCheck check, const std::array<double, 4>& region);

}  // namespace photond::hard_case
