#include "renderer/methods/radiance_cache/params.h"

#include "renderer/methods/radiance_cache/radiance_cells.h"

namespace photond {

void RadianceCacheParams::visit(ParamVisitor& visitor) {
    using enum ParamGroup;
    visitor.field("indirect_bounces", indirect_bounces,
                  {Light, "", 0, 1e6, "greatest number of bounces in the indirect layer; unlimited when not given"});
    visitor.field("gather_rays", gather_rays,
                  {Gathering, "rays", 1, 64,
                   "from each point that the eye sees, to where the cache is asked; fewer behind dim reflections"});
    visitor.field("training", training,
                  {Gathering, "", 0.001, 4,
                   "paths that fill the cache for each pixel of a pass: more make it less noisy, and take longer"});
    static constexpr std::string_view kSecondBounces[] = {"paths", "cache"};
    visitor.enumeration(
        "second_bounces", second_bounces,
        {Gathering, kSecondBounces,
         "where the paths that fill the cache end: as any path does (paths), or in cells that know enough already, "
         "which is sooner done, but keeps what the first ones got wrong (cache); where bounces are limited all go on"});
    visitor.field("cell_size", cell_size,
                  {DensityEstimate, "", 1e-4, 1,
                   "side of the cells that light is averaged in, over their distance from the eye, at most: smaller "
                   "ones blur less and are noisier"});
    visitor.field("cells", cells,
                  {DensityEstimate, "", RadianceCells::kLeastCells, 1u << 28,
                   "that there is memory for; where they do not suffice, paths go on as if there were no cache"});
    visitor.field("direction_bins", direction_bins,
                  {DensityEstimate, "", 1, 64,
                   "along each side of a square of all directions, in which the light that leaves what is not Lambert "
                   "is kept apart"});
    visitor.field("least_samples", least_samples,
                  {NoiseAndBias, "", 1, 1e6, "of a cell, for paths to end there instead of going on"});
    visitor.field("glossy_threshold", glossy_threshold,
                  {DensityEstimate, "", 0, 1,
                   "GGX alpha below which a lobe is too narrow for the cells' directions: paths follow it"});
    visitor.flag("shrink", shrink,
                 {NoiseAndBias, "cells shrink from pass to pass, so that the mean of the passes converges"});
    visitor.field("alpha", alpha,
                  {NoiseAndBias, "", 0.01, 1,
                   "the smaller, the faster they shrink; squared sizes fall as the passes' number to the power "
                   "alpha - 1"});
    visit_sampler(visitor, sampler);
    temporal.visit(visitor);
    visitor.flag("aged", aged,
                 {Frames,
                  "each frame begins with the cells of the one before, whose samples count for less: less noise and "
                  "flicker, and light that lags where it changes"});
    visitor.field("cache_age", cache_age,
                  {Frames, "frames", 2, 1024,
                   "that a cell's samples count as at most: more are smoother and lag more; one that had none in so "
                   "many is dropped"});
}

}  // namespace photond
