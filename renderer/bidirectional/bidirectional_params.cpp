#include "renderer/bidirectional/bidirectional_params.h"

#include "protocol/error.h"
#include "renderer/frame/common_params.h"
#include "renderer/photons/photon_params.h"

namespace photond {

void BidirectionalParams::visit(ParamVisitor& visitor) {
    using enum ParamGroup;
    static constexpr std::string_view kConnections[] = {"cache", "own_path"};
    static constexpr std::string_view kHeuristics[] = {"balance", "power"};

    visitor.field("indirect_bounces", indirect_bounces,
                  {Light, "", 0, 1e6, "greatest number of bounces in the indirect layer; unlimited when not given"});
    visitor.flag("adapt", adapt,
                 {Light,
                  "choose the numbers of light paths and connections, and whether to merge, by a pilot: what an image "
                  "does not need is left out; what is given stays as it is"});
    visitor.field("light_paths", light_paths,
                  {Light, "a pixel", 0, 16,
                   "light paths of a pass over the image's pixels, fewer where the cache is full; the pilot's choice "
                   "when not given, or 1"});
    visitor.field(
        "light_cache", light_cache_mib,
        {Light, "MiB", 1, 4096, "for the vertices of a pass's light paths; fewer paths where they need more"});
    visitor.enumeration("connections", connections,
                        {Gathering, kConnections,
                         "the light vertices that an eye vertex is connected with: drawn from those of all light paths "
                         "of the pass (cache), or all those of one light path (own_path)"});
    visitor.field("connections_per_vertex", connections_per_vertex,
                  {Gathering, "", 0, 64,
                   "of each eye vertex, where they are drawn from the cache; 0: none; the pilot's choice when not "
                   "given, or 1"});
    visitor.enumeration("heuristic", heuristic,
                        {NoiseAndBias, kHeuristics,
                         "by which the ways to make one path are weighed: their densities (balance) or the squares of "
                         "those (power)"});
    visitor.field("roulette_start", roulette_start,
                  {NoiseAndBias, "", 1, 1e6,
                   "surface interactions after which Russian roulette may end a path from the eye; light paths have "
                   "it from the first"});
    visit_sampler(visitor, sampler);
}

void MergingParams::visit(ParamVisitor& visitor) {
    using enum ParamGroup;
    static constexpr std::string_view kRules[] = {"global", "trained"};  // the first two of RadiusRule
    visitor.enumeration(
        "radius_rule", radius_rule,
        {DensityEstimate, kRules,
         "the radius within which vertices are merged: one for all places (global), or each place's own, "
         "by what a pilot says of the light's curvature and noise there (trained; on the CPU)"});
    visitor.field("alpha", alpha,
                  {DensityEstimate, "", 0.01, 1,
                   "share of the light paths' vertices that is merged with from pass to pass: squared bias falls as "
                   "the passes' number to the power 2 alpha - 2; 1 keeps the radius"});
    visitor.field("nearest_vertices", nearest_vertices,
                  {DensityEstimate, "", 2, 100'000,
                   "of a pass's light paths: that the first radius is to hold where light is bright, as a pilot finds "
                   "it where no "
                   "radius is given"});
    visitor.field("radius", radius_m,
                  {DensityEstimate, "m", 1e-9, 1e9,
                   "within which vertices are merged in the first pass; a pilot's when not given"});
    visitor.field("radius_relative", radius_relative,
                  {DensityEstimate, "", 1e-9, 1e3, "the same, over the radius of the scene's bounding sphere"});
    visitor.field(
        "caustic_radius_share", caustic_radius_share,
        {DensityEstimate, "", 0.01, 1,
         "of the radius: within which light is merged that mirrors and glass alone have scattered; not given: "
         "as a pilot finds both, or 1 where the radius is given"});
    static constexpr std::string_view kWeights[] = {"automatic", "recursive", "correlation_aware"};
    visitor.enumeration("weights", weights,
                        {NoiseAndBias, kWeights,
                         "how much merging counts for: as if all vertices that are merged with were independent "
                         "(recursive), or less where few light paths arrive, whose vertices many pixels share "
                         "(correlation_aware); automatic: the latter, but on a GPU, which has the former alone"});
}

void MergingParams::check() const {
    require_one_radius(radius_m, radius_relative);
    if (radius_rule == RadiusRule::Trained && (radius_m || radius_relative))
        throw Error(ErrorCode::Conflict, "/radius_rule", "trained radii exclude a radius that is given");
}

}  // namespace photond
