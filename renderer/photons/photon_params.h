#pragma once
// Parameters that methods with photon maps have in common, declared once.

#include <cstdint>
#include <optional>

namespace photond {

class ParamVisitor;
enum class DiscBoundary : uint8_t;
enum class KernelShape : uint8_t;

/// `photons` and `caustic_photons`
void visit_map_photons(ParamVisitor& visitor, uint32_t& photons, std::optional<uint32_t>& caustic_photons);
/// `indirect_bounces`
void visit_photon_bounces(ParamVisitor& visitor, std::optional<uint32_t>& bounces);
/// `kernel` and `cone_k`
void visit_kernel(ParamVisitor& visitor, KernelShape& kernel, float& cone_k);
/// `disc_thickness`
void visit_disc_thickness(ParamVisitor& visitor, std::optional<float>& thickness_m);
/// `boundary`
void visit_disc_boundary(ParamVisitor& visitor, DiscBoundary& boundary);
/// `projection_maps`
void visit_projection_maps(ParamVisitor& visitor, bool& projection_maps);
/// `glossy_threshold`, of what is followed and of what is looked up
void visit_photon_glossy_threshold(ParamVisitor& visitor, float& threshold);
/// `radius` and `radius_relative` exclude each other: throws ErrorCode::Conflict where both are given.
void require_one_radius(const std::optional<float>& radius_m, const std::optional<float>& radius_relative);

}  // namespace photond
