#pragma once
// The layers an image may have, in the order of protocol.md, and what each holds.

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

namespace photond {

enum class Layer : uint8_t {
    Emitted,
    Direct,
    Indirect,
    Caustic,
    Albedo,
    Normal,
    Position,
    Depth,
    StandardError,
    PhotonCount,
    Overlap,
    Clamped,
    Voxels,
    Vpls,
    SplitNormal,
    SplitIndirect,
};
inline constexpr size_t kLayerCount = 16;

/// How the passes' values become the image's.
enum class LayerMean : uint8_t {
    Radiance,  // a part of the light, or taken from it: mean over the passes
    Hits,      // auxiliary: mean over the samples that met a surface
    Passes,    // a look at a method's structures: mean over the passes
};

struct LayerInfo {
    Layer layer;
    std::string_view name;                     // the wire's and the EXR's
    std::array<std::string_view, 3> channels;  // EXR channel suffixes; single-valued layers use the first only
    uint32_t channel_count;
    LayerMean mean;
    std::string_view text;

    constexpr bool radiance() const { return mean == LayerMean::Radiance; }
};

inline constexpr std::array<LayerInfo, kLayerCount> kLayers{{
    {Layer::Emitted,
     "emitted",
     {"R", "G", "B"},
     3,
     LayerMean::Radiance,
     "lights seen directly, in mirrors and through glass"},
    {Layer::Direct, "direct", {"R", "G", "B"}, 3, LayerMean::Radiance, "light scattered once"},
    {Layer::Indirect,
     "indirect",
     {"R", "G", "B"},
     3,
     LayerMean::Radiance,
     "light scattered twice or more, caustics included"},
    {Layer::Caustic,
     "caustic",
     {"R", "G", "B"},
     3,
     LayerMean::Radiance,
     "the part of indirect that came by delta scatterings only"},
    {Layer::Albedo, "albedo", {"R", "G", "B"}, 3, LayerMean::Hits, "reflectance of the first non-delta surface"},
    {Layer::Normal, "normal", {"X", "Y", "Z"}, 3, LayerMean::Hits, "world-space shading normal facing the eye"},
    {Layer::Position, "position", {"X", "Y", "Z"}, 3, LayerMean::Hits, "world-space position [m]"},
    {Layer::Depth, "depth", {"Z", "", ""}, 1, LayerMean::Hits, "distance along the camera's forward axis [m]"},
    {Layer::StandardError,
     "standard_error",
     {"R", "G", "B"},
     3,
     LayerMean::Hits,
     "standard error of beauty from the passes"},
    {Layer::PhotonCount,
     "photon_count",
     {"Y", "", ""},
     1,
     LayerMean::Hits,
     "photons that a pass used in its estimates"},
    {Layer::Overlap, "overlap", {"Y", "", ""}, 1, LayerMean::Hits, "splats that lie over the pixel in a pass"},
    {Layer::Clamped, "clamped", {"R", "G", "B"}, 3, LayerMean::Radiance, "light that the clamp of connections takes"},
    {Layer::Voxels, "voxels", {"R", "G", "B"}, 3, LayerMean::Passes, "the first voxel on the pixel's ray, shaded"},
    {Layer::Vpls, "vpls", {"Y", "", ""}, 1, LayerMean::Passes, "virtual point lights of a pass that the pixel shows"},
    {Layer::SplitNormal, "split_normal", {"X", "Y", "Z"}, 3, LayerMean::Passes, "normals as the split G-buffer lies"},
    {Layer::SplitIndirect, "split_indirect", {"R", "G", "B"}, 3, LayerMean::Passes, "irradiance before the merge"},
}};
constexpr const LayerInfo& layer_info(Layer layer) { return kLayers[static_cast<size_t>(layer)]; }

/// A set of layers. Emitted, direct and indirect are always in it.
class LayerSet {
public:
    constexpr LayerSet() = default;
    constexpr bool has(Layer layer) const { return (bits_ >> static_cast<unsigned>(layer)) & 1u; }
    constexpr void add(Layer layer) { bits_ |= 1u << static_cast<unsigned>(layer); }
    constexpr void remove(Layer layer) { bits_ &= ~(1u << static_cast<unsigned>(layer)); }
    /// Whether a pass fills it: standard errors come of the passes together.
    constexpr bool has_in_passes(Layer layer) const { return layer != Layer::StandardError && has(layer); }
    /// Whether samples that met a surface are counted: there is an auxiliary layer to be divided by them.
    constexpr bool needs_hits() const {
        for (const LayerInfo& info : kLayers)
            if (info.mean == LayerMean::Hits && has_in_passes(info.layer)) return true;
        return false;
    }
    /// Every layer there is.
    static constexpr LayerSet all() {
        LayerSet layers;
        for (const LayerInfo& info : kLayers) layers.add(info.layer);
        return layers;
    }
    constexpr bool operator==(const LayerSet&) const = default;

private:
    uint32_t bits_ = 0b111;
};

}  // namespace photond
