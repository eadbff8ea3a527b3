#pragma once
// The layers an image may have, in the order that files and pixel hashes have them in, and what each holds.

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "renderer/film/layers_shared.h"

namespace photond {

enum class Layer : uint8_t {
    Emitted = LAYER_EMITTED,
    Direct = LAYER_DIRECT,
    Indirect = LAYER_INDIRECT,
    Caustic = LAYER_CAUSTIC,
    Albedo = LAYER_ALBEDO,
    Normal = LAYER_NORMAL,
    Position = LAYER_POSITION,
    Depth = LAYER_DEPTH,
    StandardError = LAYER_STANDARD_ERROR,
    PhotonCount = LAYER_PHOTON_COUNT,
    Overlap = LAYER_OVERLAP,
    Clamped = LAYER_CLAMPED,
    Voxels = LAYER_VOXELS,
    Vpls = LAYER_VPLS,
    SplitNormal = LAYER_SPLIT_NORMAL,
    SplitIndirect = LAYER_SPLIT_INDIRECT,
    GeometricNormal = LAYER_GEOMETRIC_NORMAL,
    Radius = LAYER_RADIUS,
    BiasEstimate = LAYER_BIAS_ESTIMATE,
    Connections = LAYER_CONNECTIONS,
    Merges = LAYER_MERGES,
    LightImage = LAYER_LIGHT_IMAGE,
    Techniques = LAYER_TECHNIQUES,
    ShadowDistance = LAYER_SHADOW_DISTANCE,
    BlurRadius = LAYER_BLUR_RADIUS,
    UpsamplingWeight = LAYER_UPSAMPLING_WEIGHT,
    BounceMap = LAYER_BOUNCE_MAP,
    Proxies = LAYER_PROXIES,
    ProxyVoxels = LAYER_PROXY_VOXELS,
    VisibilityCount = LAYER_VISIBILITY_COUNT,
    ListsBeforeFilter = LAYER_LISTS_BEFORE_FILTER,
    CacheCells = LAYER_CACHE_CELLS,
    CacheSamples = LAYER_CACHE_SAMPLES,
    Volume = LAYER_VOLUME,
    ConeMip = LAYER_CONE_MIP,
    HistoryLength = LAYER_HISTORY_LENGTH,
    Rejected = LAYER_REJECTED,
    Reused = LAYER_REUSED,
};
inline constexpr size_t kLayerCount = LAYER_COUNT;

/// How the passes' values become the image's.
enum class LayerMean : uint8_t {
    Radiance,  // a part of the light, or taken from it: mean over the passes
    Hits,      // auxiliary: mean over the samples that met a surface
    Passes,    // a look at a method's structures: mean over the passes
};

/// How a display shows a layer: what previews of a job can be asked for.
enum class LayerPreview : uint8_t {
    None,        // numbers to look at closely
    Light,       // by exposure and tone curve, as the beauty
    HeatMap,     // splats over a pixel: blue 0, green 200, red 400, white 600
    Directions,  // (n + 1) / 2 as display values
    Scale,       // dark at 0, bright at the greatest that is not one of the rarest
    Signed,      // blue below 0, white, red above it; as bright as the greatest magnitude that is not one of the rarest
    Dots,        // what a pass puts on a pixel, as grey light: 1 is white
};
/// Whether exposure and tone curve mean anything to it.
constexpr bool has_exposure(LayerPreview preview) {
    return preview == LayerPreview::Light || preview == LayerPreview::Dots;
}

/// Who has something to put into a layer.
enum class LayerFilledBy : uint8_t {
    All,        // every method, but those whose row says otherwise
    Some,       // methods whose row says so
    Following,  // methods whose frames can follow from the one before: all of them
};

struct LayerInfo {
    Layer layer;
    std::string_view name;      // the wire's and the EXR's
    std::string_view channels;  // the EXR's suffixes, a letter each: "RGB", "XYZ", "Y", "Z"
    LayerMean mean;
    LayerPreview preview;
    LayerFilledBy filled_by;
    std::string_view unit;  // SI; empty for plain numbers
    std::string_view text;

    constexpr bool radiance() const { return mean == LayerMean::Radiance; }
    constexpr uint32_t channel_count() const { return static_cast<uint32_t>(channels.size()); }
};

inline constexpr std::array<LayerInfo, kLayerCount> kLayers = [] {
    using enum Layer;
    using enum LayerMean;
    using enum LayerFilledBy;
    using P = LayerPreview;
    constexpr std::string_view kRadiance = "W m^-2 sr^-1";
    return std::array<LayerInfo, kLayerCount>{{
        {Emitted, "emitted", "RGB", Radiance, P::Light, All, kRadiance,
         "lights seen directly, in mirrors and through glass"},
        {Direct, "direct", "RGB", Radiance, P::Light, All, kRadiance, "light scattered once"},
        {Indirect, "indirect", "RGB", Radiance, P::Light, All, kRadiance,
         "light scattered twice or more, caustics included"},
        {Caustic, "caustic", "RGB", Radiance, P::Light, All, kRadiance,
         "the part of indirect that came by delta scatterings only"},
        {Albedo, "albedo", "RGB", Hits, P::None, All, "", "reflectance of the first non-delta surface"},
        {Normal, "normal", "XYZ", Hits, P::None, All, "", "world-space shading normal facing the eye"},
        {Position, "position", "XYZ", Hits, P::None, All, "m", "world-space position [m]"},
        {Depth, "depth", "Z", Hits, P::None, All, "m", "distance along the camera's forward axis [m]"},
        {StandardError, "standard_error", "RGB", Hits, P::None, All, kRadiance,
         "standard error of beauty from the passes; infinite after a single one, which does not tell it"},
        {PhotonCount, "photon_count", "Y", Hits, P::Scale, Some, "", "photons that a pass used in its estimates"},
        {Overlap, "overlap", "Y", Hits, P::HeatMap, Some, "", "splats that lie over the pixel in a pass"},
        {Clamped, "clamped", "RGB", Radiance, P::Light, Some, kRadiance, "light that the clamp of connections takes"},
        {Voxels, "voxels", "RGB", Passes, P::Light, Some, "", "the first voxel on the pixel's ray, shaded"},
        {Vpls, "vpls", "Y", Passes, P::Dots, Some, "", "virtual point lights of a pass that the pixel shows"},
        {SplitNormal, "split_normal", "XYZ", Passes, P::Directions, Some, "", "normals as the split G-buffer lies"},
        {SplitIndirect, "split_indirect", "RGB", Passes, P::Light, Some, "W m^-2", "irradiance before the merge"},
        {GeometricNormal, "geometric_normal", "XYZ", Hits, P::Directions, All, "",
         "world-space normal of the triangle itself facing the eye, no smoothing and no normal map"},
        {Radius, "radius", "Y", Hits, P::Scale, Some, "m",
         "of the discs that photons were counted on, the larger of two maps'"},
        {BiasEstimate, "bias_estimate", "Y", Passes, P::Signed, Some, kRadiance,
         "how much too bright the discs make the pixel's luminance, as the photons on them tell"},
        {Connections, "connections", "RGB", Passes, P::Light, Some, kRadiance,
         "the part of direct and indirect that connections of eye and light paths bring, as weighed"},
        {Merges, "merges", "RGB", Passes, P::Light, Some, kRadiance,
         "the part that merging of eye and light paths brings, as weighed"},
        {LightImage, "light_image", "RGB", Passes, P::Light, Some, kRadiance,
         "the part that light paths bring which the camera sees, as weighed"},
        {Techniques, "techniques", "RGB", Passes, P::Light, Some, "",
         "what a pilot chose: red where vertices merge, green connections of an eye vertex over 8, blue light paths a "
         "pixel over 2"},
        {ShadowDistance, "shadow_distance", "Y", Passes, P::Scale, Some, "m",
         "to what hides the middle of the pixel's light, mean about the pixel; 0 where nothing does"},
        {BlurRadius, "blur_radius", "Y", Passes, P::Scale, Some, "pixels",
         "of the disc that a soft shadow is the mean of"},
        {UpsamplingWeight, "upsampling_weight", "Y", Passes, P::Scale, Some, "",
         "of the four lit pixels that a pixel takes its light from, in all; 0 where it is lit itself"},
        {BounceMap, "bounce_map", "Y", Passes, P::Dots, Some, "",
         "places of a pass where light first arrives that the pixel shows, and photons leave from"},
        {Proxies, "proxies", "RGB", Passes, P::Light, Some, "W m^-2",
         "radiosity of the point proxy whose disc the pixel shows; 0 where it shows none"},
        {ProxyVoxels, "proxy_voxels", "RGB", Passes, P::Light, Some, "", "the voxel of proxies, a colour each"},
        {VisibilityCount, "visibility_count", "Y", Passes, P::Scale, Some, "",
         "voxels that count as visible from the pixel's part of the image"},
        {ListsBeforeFilter, "lists_before_filter", "Y", Passes, P::Scale, Some, "",
         "voxels that its own rays have met, before the visibility filter"},
        {CacheCells, "cache_cells", "RGB", Passes, P::Light, Some, "",
         "the cell of the radiance cache that the pixel's place lies in, a colour each"},
        {CacheSamples, "cache_samples", "Y", Passes, P::Scale, Some, "",
         "that the cell has of the paths which filled the cache"},
        {Volume, "volume", "RGB", Passes, P::Light, Some, kRadiance,
         "of the cell before the pixel's surface, mean over all directions"},
        {ConeMip, "cone_mip", "RGB", Passes, P::Light, Some, kRadiance,
         "what a cone from the eye sees of the voxels' light: cells as large as they are far"},
        {HistoryLength, "history_length", "Y", Passes, P::Scale, Following, "frames",
         "whose indirect light the pixel's is the mean of, this one counted"},
        {Rejected, "rejected", "RGB", Passes, P::Light, Following, "",
         "why a pixel took over nothing: red where another surface was there, blue where the last frame's image did "
         "not "
         "reach; and green as far as the light has changed"},
        {Reused, "reused", "Y", Passes, P::Dots, Following, "",
         "the share of the pixel's indirect light that earlier frames made"},
    }};
}();
constexpr const LayerInfo& layer_info(Layer layer) { return kLayers[static_cast<size_t>(layer)]; }
/// nullptr where there is no layer of that name; the beauty is none.
constexpr const LayerInfo* find_layer(std::string_view name) {
    for (const LayerInfo& info : kLayers)
        if (info.name == name) return &info;
    return nullptr;
}

/// A set of layers. Emitted, direct and indirect are always in it.
class LayerSet {
public:
    constexpr LayerSet() = default;
    constexpr bool has(Layer layer) const { return (bits_ >> static_cast<unsigned>(layer)) & 1u; }
    constexpr void add(Layer layer) { bits_ |= bit_of(layer); }
    constexpr void remove(Layer layer) { bits_ &= ~bit_of(layer); }
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
    static_assert(kLayerCount <= 64);
    static constexpr uint64_t bit_of(Layer layer) { return uint64_t{1} << static_cast<unsigned>(layer); }

    uint64_t bits_ = 0b111;
};

}  // namespace photond
