#pragma once
// Which techniques an image is rendered with: how many light paths, how many connections, whether vertices merge. A
// simple scene must not pay for what only a hard one needs.
//
// A small pilot of the same view tries all techniques. Of each of its samples it is known what it would weigh, and how
// often it would be taken, with any other choice of numbers; so one pilot estimates the second moment of every
// candidate [Grittmann et al. 2022, Sec. 4]: a sample of value C, taken n times of n' that the candidate takes, brings
// (w C)^2 n / n'. What the variance lacks to that are the squared means of the techniques, which are taken from blocks
// of pixels. The choice is the candidate whose relative variance times cost is the least. Cost is counted (rays,
// vertices, connections, merges), never timed: choices are part of the image, and the image is a pure function of the
// seed.
//
// [Grittmann et al. 2022] Efficiency-Aware Multiple Importance Sampling for Bidirectional Rendering Algorithms. ACM TOG
// 41(4).

#include <optional>
#include <span>
#include <vector>

#include "renderer/bidirectional/mis_weights.h"
#include "renderer/core/rgb.h"

namespace photond {

/// A choice of numbers.
struct TechniqueCandidate {
    float light_paths = 0;     // a pixel
    uint32_t connections = 0;  // of an eye vertex
    bool merges = false;
};

/// What a sample of a pilot was made by; means are subtracted from moments by these.
enum class TechniqueKind : uint8_t {
    FirstLightSample,  // at the eye path's first surface
    LightSample,       // beyond
    LightMet,
    Seen,  // by the camera, of a light path
    Connection,
    Merge,
};
inline constexpr size_t kTechniqueKinds = 6;

/// A candidate as samples of a pilot are weighed by it.
struct WeighedCandidate {
    TechniqueNumbers numbers;
    // How many samples the pilot takes for each that the candidate takes; 0 where the candidate takes none.
    float more_light_paths = 0;
    float more_connections = 0;

    float more(TechniqueKind kind) const {
        switch (kind) {
            case TechniqueKind::Seen:
            case TechniqueKind::Merge: return more_light_paths;
            case TechniqueKind::Connection: return more_connections;
            default: return 1;
        }
    }
};

/// What samples of a part of a pilot's image come to.
class CandidateMoments {
public:
    explicit CandidateMoments(size_t candidates = 0) : squares_(candidates), means_(candidates * kTechniqueKinds) {}

    /// `weights`: of the sample by each candidate.
    void add(TechniqueKind kind, const Rgb& value, std::span<const float> weights,
             std::span<const WeighedCandidate> candidates);
    CandidateMoments& operator+=(const CandidateMoments& other);
    /// Of the sum of all samples over `pixel_passes` pixels and passes: the mean, and the variance of one pixel and
    /// pass.
    double mean(size_t candidate, double pixel_passes) const;
    double variance(size_t candidate, double pixel_passes) const;

private:
    std::vector<double> squares_;  // by candidate
    std::vector<double> means_;    // candidate after candidate, by kind
};

/// All that a pilot counted, a pixel and a pass.
struct PilotCounts {
    double eye_vertices = 0;
    double open_vertices = 0;   // of them with a lobe that connects
    double light_vertices = 0;  // of one light path
    double seen = 0;            // of a light path, vertices that the camera may see
    double found = 0;           // vertices within the radius of an open vertex
};

/// What costs depend on besides.
struct CostlyScene {
    uint64_t triangles;
    bool only_lambert;  // Needs::only_lambert()
};
/// Of a pass, a pixel's; only ratios mean anything. bidirectional_bench prints what it comes to beside the clock.
double counted_cost(const TechniqueCandidate& candidate, const PilotCounts& counts, const CostlyScene& scene);

/// What there is to choose from.
struct TechniqueChoices {
    std::optional<float> light_paths;     // given
    float most_light_paths = 0;           // that there is room for
    std::optional<uint32_t> connections;  // given; of paths' own, which has nothing to choose: 1
    bool merges = false;                  // may
    // Some paths of the scene are made in no other way (left_out.h): what lacks them is no candidate.
    bool needs_light_paths = false, needs_connections = false, needs_merges = false;
};
/// At least one.
std::vector<TechniqueCandidate> technique_candidates(const TechniqueChoices& choices);

}  // namespace photond
