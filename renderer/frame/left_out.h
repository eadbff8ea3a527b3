#pragma once
// Kinds of path that a method leaves out of its images, said once: statistics, dry runs and comparisons tell of them by
// these names and sentences. Kinds have no path in common (but for one, which is a part of another), so that what one
// image lacks and another has is their difference.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/scene/needs.h"

namespace photond {

/// Of the light that conventions.md calls indirect. Delta lights are points, spots and suns (directional lights): no
/// path meets them, and where delta scatterings alone lie between one and a surface no shadow ray does.
enum class PathKind : uint8_t {
    FurtherBounces,           // than a method does, or was asked for
    DeltaLightCaustics,       // delta light, delta scatterings, x_1
    DeltaLightAfterCaustics,  // delta light, delta scatterings, a surface, any scatterings, x_1
    DeltaLightInGloss,        // delta light, delta scatterings, x_1, a glossy lobe there that paths from the eye follow
    DeltaLightCausticsInMirrors,  // of delta light caustics: those at an x_1 that the eye sees by delta scatterings
    Caustics,                     // other light whose last scattering before x_1 is a narrow or transmitting lobe's
};

struct PathKindInfo {
    PathKind kind;
    std::string_view name;  // on the wire
    std::string_view text;  // after "left out: "
    uint32_t least_bounces;
};

inline constexpr std::array<PathKindInfo, 6> kPathKinds{{
    {PathKind::FurtherBounces, "further_bounces", "light of more bounces", 0},
    {PathKind::DeltaLightCaustics, "delta_light_caustics",
     "light of points, spots and suns that mirrors or smooth glass send to a surface", 1},
    {PathKind::DeltaLightAfterCaustics, "delta_light_after_caustics",
     "light of points, spots and suns that mirrors or smooth glass sent to a surface, scattered on from there", 2},
    {PathKind::DeltaLightInGloss, "delta_light_in_gloss",
     "light of points, spots and suns that mirrors or smooth glass send to narrow gloss, as the eye sees it there", 1},
    {PathKind::DeltaLightCausticsInMirrors, "delta_light_caustics_in_mirrors",
     "light of points, spots and suns that mirrors or smooth glass send to a surface, as mirrors and smooth glass show "
     "it",
     1},
    {PathKind::Caustics, "caustics", "light that mirrors, glass and narrow gloss send to other surfaces", 1},
}};

/// What an image leaves out.
class PathsLeftOut {
public:
    /// From so many bounces on there are as good as all: most methods do no more.
    static constexpr uint32_t kAllBounces = 254;

    PathsLeftOut() = default;
    /// Paths of more bounces, in a scene where anything scatters light.
    PathsLeftOut(uint32_t most_bounces, const Needs& needs);
    explicit PathsLeftOut(uint32_t most_bounces) : most_bounces_(most_bounces) {}

    /// Unless none of the bounces that there are would be such a path.
    PathsLeftOut& add(PathKind kind);
    bool has(PathKind kind) const { return has_[static_cast<size_t>(kind)]; }
    /// ... by itself or as a part of another.
    bool holds(PathKind kind) const {
        return has(kind) || (kind == PathKind::DeltaLightCausticsInMirrors && has(PathKind::DeltaLightCaustics));
    }
    uint32_t most_bounces() const { return most_bounces_; }
    std::vector<PathKind> kinds() const;  // in the order of kPathKinds
    bool empty() const { return kinds().empty(); }
    /// "light of more than 1 bounce"
    std::string text(PathKind kind) const;
    /// All of them: "light of more than 1 bounce, and light ..."; empty for none.
    std::string text() const;

    /// What this leaves out and `other` does not.
    PathsLeftOut without(const PathsLeftOut& other) const;

private:
    std::array<bool, kPathKinds.size()> has_{};
    uint32_t most_bounces_ = kAllBounces;
};

/// Whether delta scatterings can lie between a delta light and a surface.
inline bool has_delta_light_by_delta(const Needs& needs) { return needs.delta && needs.punctual_lights; }

/// GGX alpha below which gloss is narrow, where a method has no threshold of its own.
inline constexpr float kNarrowAlpha = 0.05f;

/// What no path from the eye finds that samples lights at its vertices.
PathsLeftOut left_out_by_eye_paths(uint32_t most_bounces, const Needs& needs);
/// What neither eye nor light paths find, nor any connection of the two.
PathsLeftOut left_out_by_two_paths(uint32_t most_bounces, const Needs& needs);
/// What photons stored at rough lobes do not bring, where eye paths follow those with GGX alpha below
/// `glossy_threshold`.
PathsLeftOut left_out_by_photons(uint32_t most_bounces, float glossy_threshold, const Needs& needs);
/// What connections with lights where the scene is lit do not bring: no lobe with GGX alpha below `connect_threshold`
/// connects, nor any that transmits.
PathsLeftOut left_out_by_connections(uint32_t most_bounces, float glossy_threshold, float connect_threshold,
                                     const Needs& needs);

/// Greatest number of bounces of paths with so many scatterings (conventions.md).
constexpr uint32_t bounces_of_scatterings(uint32_t most_scatterings) {
    return most_scatterings > PathsLeftOut::kAllBounces ? PathsLeftOut::kAllBounces
           : most_scatterings == 0                      ? 0
                                                        : most_scatterings - 1;
}

}  // namespace photond
