#pragma once
// Which techniques an image is rendered with: how many light paths, how many connections, whether vertices merge. A
// simple scene must not pay for what only a hard one needs.
//
// A small pilot of the same view tries all techniques. Of each of its samples it is known what it would weigh, and how
// often it would be taken, with any other choice of numbers; so one pilot estimates the second moment of every
// candidate [Grittmann et al. 2022, Sec. 4]. Samples that belong to one path from the eye are no independent ones: all
// vertices that merge with one of its vertices share what the eye's path is worth. So the second moment is of the whole
// path. With T the sum of all its weighed samples, of which the candidate takes as many as the pilot but for some,
// taken n' times for the pilot's n, whose squares sum to S, it is T^2 + (n / n' - 1) S, less the squared mean in S
// where their number is no matter of chance (connections); and the variance is taken from the passes of each pixel, for
// what differs from pixel to pixel is the image. What the camera sees of light paths has nothing to do with the eye's;
// a sample of value C brings (w C)^2 n / n'.
//
// A candidate that lacks a technique makes its paths in other ways, rarely and with great weights, which a pilot may
// not have met once: a lamp's tiny filament by way of glass. But it has met those paths by the technique that is
// missing. Of a sample f / p, which the pilot weighs among densities whose sum is s and the candidate among such of the
// sum s', the square (f / s)^2 s / s' is a sample of the candidate's second moment, whatever made it. So no variance is
// taken for less than what the pilot itself has and the difference of the two second moments. Variances are relative to
// the light around the pixel. The choice is the candidate whose relative variance times cost is the least. Cost is
// counted (rays, vertices, connections, merges), never timed: choices are part of the image, and the image is a pure
// function of the seed.
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

/// What a sample of an eye's path was made by.
enum class TechniqueKind : uint8_t { Alone, Connection, Merge };

/// A candidate as samples of a pilot are weighed by it.
struct WeighedCandidate {
    TechniqueNumbers numbers;
    // How many samples the pilot takes for each that the candidate takes; 0 where the candidate takes none.
    float more_light_paths = 0;
    float more_connections = 0;
};

/// What a sample of a pilot weighs for a candidate.
struct CandidateWeight {
    float weight = 0;
    /// By which the square of its value, before it is weighed, is a sample of the second moment of all of the
    /// candidate's techniques together, whether or not the one that made it is among them.
    float by_density = 0;
};
/// Both shares are of one sample: as the pilot's numbers have it, and as the candidate's.
CandidateWeight weigh_candidate(const MisShare& of_pilot, const MisShare& of_candidate);

/// What one path from the eye brought in a pilot, as a candidate weighs it.
struct EyePathSum {
    Rgb all{0}, connected{0};
    // Sums of squares, means of the channels.
    float connected_squared = 0, merged_squared = 0, by_density = 0;
    /// `value`: before it is weighed.
    void add(TechniqueKind kind, const Rgb& value, const CandidateWeight& weight);
};

/// What a pixel of a pilot comes to for a candidate.
class PixelMoments {
public:
    void add(const EyePathSum& path);
    /// What the camera sees of a light path.
    void add_seen(const Rgb& value, const CandidateWeight& weight);
    double mean(uint32_t passes) const;
    /// Of one pass of the candidate; two passes or more.
    double variance(uint32_t passes, const WeighedCandidate& candidate) const;
    /// The second moment of a pass of the candidate, were all samples independent.
    double second_moment(uint32_t passes) const;

private:
    EyePathSum eye_;
    float squares_ = 0;  // of the eye's paths
    float seen_ = 0, seen_squares_ = 0, seen_by_density_ = 0;
};

/// What is known of candidates' variances: by what a pilot's samples would have weighed, and by second moments.
struct VarianceSums {
    explicit VarianceSums(size_t candidates) : of_paths(candidates), second_moments(candidates) {}

    std::vector<double> of_paths, second_moments;
    void add(const VarianceSums& more, double weight);
    /// By candidate. `known`: the one that the pilot itself is, or is the most like.
    std::vector<double> variances(size_t known) const;
};
/// The candidate that is the most like a pilot of one light path a pixel, one connection and merging.
size_t most_like_pilot(std::span<const TechniqueCandidate> candidates);

/// What one path from the eye counted in a pilot.
struct EyePathCounts {
    uint32_t vertices = 0;
    uint32_t open_vertices = 0;  // of them with a lobe that connects
    uint32_t found = 0;          // vertices within the radius of an open vertex
    uint32_t clipped = 0;        // discs of merging that an edge may cut
    EyePathCounts& operator+=(const EyePathCounts& more) {
        vertices += more.vertices, open_vertices += more.open_vertices, found += more.found, clipped += more.clipped;
        return *this;
    }
};

/// All that a pilot counted, a pixel and a pass.
struct PilotCounts {
    double eye_vertices = 0;
    double open_vertices = 0;   // of them with a lobe that connects
    double light_vertices = 0;  // of one light path
    double seen = 0;            // of a light path, vertices that the camera may see
    double found = 0;           // vertices within the radius of an open vertex
    double clipped = 0;         // discs of merging that an edge may cut
};

/// What costs depend on besides.
struct CostlyScene {
    uint64_t triangles;
    bool only_lambert;  // Needs::only_lambert()
};
/// Of a pass, a pixel's; only ratios mean anything. bidirectional_bench prints what it comes to beside the clock.
double counted_cost(const TechniqueCandidate& candidate, const PilotCounts& counts, const CostlyScene& scene);

/// What a candidate would be in a block of pixels: sums over these.
struct JudgedBlock {
    double relative_variance = 0;
    double cost = 0;  // counted_cost()
};
struct ChosenTechniques {
    size_t everywhere = 0;          // the one that would be best for the whole image
    std::vector<size_t> of_blocks;  // block by block: candidates that share their light paths
    double gain = 1;                // of variance times cost: the first one's over that of the blocks' choices
};
/// The least variance times cost, of the image's sums, by candidates of one number of light paths, which every block
/// takes from. `judged`: block by block, by candidate. A block may only add to what is best for the image, and does so
/// where that is clearly better: a pilot's variances are no better known, and a technique that is missing where the
/// pilot happened to see no use for it is a bright dot in the image.
ChosenTechniques choose_techniques(std::span<const TechniqueCandidate> candidates, std::span<const JudgedBlock> judged);

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
