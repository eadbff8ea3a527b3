#pragma once
// Parameters that methods have in common whose indirect light is the first bounce's lights, declared once.

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace photond {

class ParamVisitor;
enum class VplPlacement : uint8_t;  // path_selection.h

/// `incremental` and `new_vpls` (incremental_vpls.h)
struct IncrementalVplParams {
    bool on = false;
    uint32_t new_vpls = 256;

    void visit(ParamVisitor& visitor);
};

/// Parameters of a method whose frames may hand lights on.
struct WithIncrementalVpls {
    IncrementalVplParams incremental;

    /// Throws OutOfRange where lights are handed on that are placed by anything but their flux.
    void require_flux_placement(VplPlacement placement) const;
    /// What a frame leaves to the next beside its indirect light.
    std::vector<std::string_view> left_beside_light() const {
        return incremental.on ? std::vector<std::string_view>{"virtual point lights"} : std::vector<std::string_view>{};
    }
};

/// `map_resolution`
void visit_map_resolution(ParamVisitor& visitor, uint32_t& resolution);
/// `placement`
void visit_vpl_placement(ParamVisitor& visitor, VplPlacement& placement);
/// `clamp`, of connections to virtual point lights
void visit_vpl_clamp(ParamVisitor& visitor, std::optional<float>& clamp_m2);
/// `filter`, `filter_normal` and `filter_distance` (gbuffer/geometry_filter.h)
void visit_geometry_filter(ParamVisitor& visitor, uint32_t& side, float& normal, float& distance);
/// `glossy_threshold`, of paths from the eye to points that lights light
void visit_lit_glossy_threshold(ParamVisitor& visitor, float& threshold);
/// `connect_threshold`, of virtual point lights
void visit_vpl_connect_threshold(ParamVisitor& visitor, float& threshold);

}  // namespace photond
