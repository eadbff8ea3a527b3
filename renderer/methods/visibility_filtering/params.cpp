#include "renderer/methods/visibility_filtering/params.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "protocol/error.h"
#include "renderer/gbuffer/light_depth_maps.h"
#include "renderer/methods/visibility_filtering/kept_lists_shared.h"
#include "renderer/methods/visibility_filtering/visibility_lists_shared.h"

namespace photond {

namespace {

constexpr uint32_t kMostVoxels = 128, kMostRays = 1024;
static_assert((KEPT_MOST_LISTS + 1) * kMostRays <= UINT16_MAX, "a voxel's rays are counted in 16 bits");
constexpr uint32_t kMostVoxelsOfIndices = 40;
static_assert(kMostVoxelsOfIndices * kMostVoxelsOfIndices * kMostVoxelsOfIndices <= 32 * FILTER_MOST_WORDS);

}  // namespace

void VisibilityFilteringParams::visit(ParamVisitor& visitor) {
    using enum ParamGroup;
    visitor.field(
        "proxies", proxies,
        {Light, "points", 16, 1e8, "points on the scene's surfaces that send on light, about so many a pass"});
    visitor.field(
        "voxels", voxels,
        {Light, "", 1, kMostVoxels,
         "that proxies lie in, along the longest side of the scene's box: what is visible or not is a voxel"});
    visitor.field("bounces", bounces,
                  {Light, "", 0, 1, "greatest number of bounces in the indirect layer; it does no more than one"});
    static constexpr std::string_view kShadows[] = {"rays", "depth_maps"};
    visitor.enumeration("proxy_shadows", proxy_shadows,
                        {Light, kShadows,
                         "what tells whether points, spots and suns reach a proxy: a ray (rays), or a map of what the "
                         "light sees, as the paper has it (depth_maps); other lights are asked by rays"});
    visitor.field("depth_map_resolution", depth_map_resolution,
                  {LightMaps, "texels", LightDepthMaps::kLeastResolution, LightDepthMaps::kMostResolution,
                   "along each side of such a map, or of each face of a point's"});
    static constexpr std::string_view kVisibilities[] = {"discs", "svo", "rays"};
    visitor.enumeration("visibility", visibility,
                        {Visibility, kVisibilities,
                         "who says which voxels a point sees: sparse rays, which the proxies' discs stop (discs) or a "
                         "finer voxel octree of the triangles (svo), with the visibility filter; or a shadow ray to "
                         "every voxel that has light (rays), without it"});
    static constexpr std::string_view kLists[] = {"counts", "bits", "indices"};
    visitor.enumeration(
        "lists", lists,
        {Visibility, kLists,
         "what is kept of sparse rays: how many have met each voxel, which then counts by as much of it as "
         "they say is seen (counts); or whether any has, as the paper has it, which counts it wholly, as a "
         "set of bits (bits) or as a list of numbers (indices)"});
    visitor.field("rays", rays, {Visibility, "rays", 1, kMostRays, "sparse rays of each point that has a list"});
    visitor.field(
        "most_seen", most_seen,
        {Visibility, "", 1, 1e4,
         "by how much of a voxel it may count, where lists are counts: few rays make an uncertain share, of which "
         "more leaves bright spots"});
    visitor.flag("world_rays", world_rays,
                 {Visibility,
                  "sparse rays go the same ways wherever a place is seen from, and in all frames of an animation, so "
                  "that they do not flicker; jobs that differ by their seed alone have them in common"});
    visitor.field(
        "disc_scale", disc_scale,
        {Visibility, "", 0.1, 10,
         "radius of the proxies' discs where rays meet them, over that of their share of the surface: smaller "
         "ones leave holes"});
    visitor.field("voxel_resolution", voxel_resolution,
                  {Visibility, "voxels", 16, 1024, "of the octree, along each side; a power of two"});
    visitor.field(
        "march_subsampling", march_subsampling,
        {Visibility, "", 1, 8,
         "of each block of n x n pixels one has rays and a list; n is 1, 2, 4 or 8, and not below subsampling"});
    visitor.field("filter_side", filter_side,
                  {Visibility, "", 1, FILTER_MOST_SIDE,
                   "of the square of lists whose union the visibility filter takes; odd; 1: none"});
    visitor.field("filter_normal", filter_normal,
                  {Visibility, "", -1, 1, "least cosine between normals of points that share what they see"});
    visitor.field("filter_distance", filter_distance,
                  {Visibility, "", 1e-6, 10,
                   "distance from each other's planes, over the depth, up to which points share what they see"});
    static constexpr std::string_view kNormalisations[] = {"weights", "paper"};
    visitor.enumeration(
        "normalisation", normalisation,
        {NoiseAndBias, kNormalisations,
         "what the four lists about a pixel are divided by: their weights (weights), or their number, as "
         "the paper has it (paper), which darkens"});
    static constexpr std::string_view kSpeculars[] = {"ggx", "paper"};
    visitor.enumeration("specular", specular,
                        {NoiseAndBias, kSpeculars,
                         "how narrow lobes look at voxels: by the BSDF (ggx), or by the paper's Gaussian about the "
                         "mirrored direction (paper)"});
    visitor.field("near_voxels", near_voxels,
                  {NoiseAndBias, "", 0, 1e6,
                   "distance, in voxels, up to which a voxel's proxies count one by one; farther off by spherical "
                   "harmonics"});
    visitor.flag(
        "shrink", shrink,
        {NoiseAndBias,
         "voxels, what is near and the proxies' softening shrink from pass to pass: with visibility 'rays' the "
         "mean of the passes converges"});
    visitor.field("alpha", alpha,
                  {NoiseAndBias, "", 0.01, 1,
                   "the smaller, the faster they shrink; squared sizes fall as the passes' "
                   "number to the power alpha - 1"});
    visit_upsampling(visitor, subsampling, upsampling);
    visitor.field("glossy_threshold", glossy_threshold,
                  {Light, "", 0, 1, "GGX alpha below which a lobe counts as a mirror: paths from the eye follow it"});
    visit_sampler(visitor, sampler);
    temporal.visit(visitor);
    visitor.field("kept_lists", kept_lists,
                  {Frames, "frames", 0, KEPT_MOST_LISTS,
                   "before this one, of which each point takes over what its sparse rays met, so that fewer rays do; "
                   "those whose way leads through what has moved are shot again; 0: none"});
}

void VisibilityFilteringParams::check() const {
    require_power_of_two("/subsampling", subsampling);
    require_power_of_two("/march_subsampling", march_subsampling);
    require_power_of_two("/voxel_resolution", voxel_resolution);
    if (march_subsampling < subsampling)
        throw Error(ErrorCode::OutOfRange, "/march_subsampling",
                    "must be at least subsampling, " + std::to_string(subsampling) +
                        ": lists are those of pixels that are lit");
    if (!asks_rays() && lists == ListKind::Indices && voxels > kMostVoxelsOfIndices)
        throw Error(ErrorCode::OutOfRange, "/voxels",
                    "must be at most " + std::to_string(kMostVoxelsOfIndices) + " where lists are indices");
    if (kept_lists > 0 && asks_rays())
        throw Error(ErrorCode::OutOfRange, "/kept_lists", "must be 0 with visibility rays: there are no lists");
    if (filter_side % 2 == 0) throw Error(ErrorCode::OutOfRange, "/filter_side", "must be odd");
}

uint32_t VisibilityFilteringParams::voxels_of_pass(uint32_t pass) const {
    const uint32_t most = !asks_rays() && lists == ListKind::Indices ? kMostVoxelsOfIndices : kMostVoxels;
    const double wanted = std::ceil(static_cast<double>(voxels) / double{share_of_pass(pass)} - 1e-6);
    return static_cast<uint32_t>(std::min(wanted, static_cast<double>(most)));
}

}  // namespace photond
