#pragma once
// What all sub-paths of one render share: prepared once by begin(), read by all threads.

#include "renderer/bidirectional/bidirectional_params.h"
#include "renderer/bidirectional/bidirectional_shared.h"
#include "renderer/bidirectional/merging_correlation.h"
#include "renderer/bidirectional/technique_blocks.h"
#include "renderer/eye/camera_connection.h"
#include "renderer/eye/path_wavefront.h"
#include "renderer/photons/disc_coverage.h"
#include "renderer/progressive/radius_map.h"
#include "renderer/transport/light_ends.h"

namespace photond {

struct BidirectionalScene : PathScene {
    BidirectionalScene(const RenderContext& context, const BidirectionalParams& params)
        : PathScene(context, params.sampler, params.max_scatterings(), params.roulette_start),
          emission(context.scene),
          ends(context.scene, lights, emission),
          camera(camera_rays),
          mis(params.heuristic) {}

    const EmissionSampler emission;
    const LightEnds ends;
    const CameraConnector camera;
    const Mis mis;
};

/// What vertices that merge with one lie on.
struct MergeDisc {
    float radius_m = 0;       // 0: nothing merges
    bool may_be_cut = false;  // it may hang over an edge, or reach behind a wall

    /// By which weights count merging [m^2].
    float acceptance_m2() const { return kPi * sqr(radius_m) * (may_be_cut ? MERGE_EDGE_SHARE : 1); }
    float most_height_m() const { return MERGE_MOST_HEIGHT * radius_m; }
    MergeDisc scaled(float share) const { return {share * radius_m, may_be_cut}; }
};

/// How often each technique is tried in a pass, and where vertices merge.
struct PassTechniques {
    uint32_t light_paths = 0;
    BlockTechniques everywhere;               // where there are no blocks
    const TechniqueBlocks* blocks = nullptr;  // where they differ
    bool own_path = false;                    // connections are with all vertices of one light path instead
    float merge_radius_m = 0;                 // 0: nothing merges; the greatest, where places have their own:
    const RadiusMap* radii = nullptr;         // those of the first pass,
    float radius_share = 1;                   // times this,
    uint32_t radius_turn = 0;                 // looked up by this number
    const DiscCoverage* coverage = nullptr;   // where there is merging
    float edge_radius_m = 0;                  // how near an edge cuts a disc
    bool correlated = false;                  // merging is weighed by merging_correlation.h: paths keep their vertices

    /// Of a pixel.
    const BlockTechniques& at(uint32_t x, uint32_t y) const {
        return blocks ? (*blocks)[blocks->index_at(x, y)] : everywhere;
    }

    /// Where an eye's vertex merges at that place, but with caustics: a function of place alone, as weights have to be.
    /// Whether a caustic's disc may be cut is taken from the larger one's.
    MergeDisc merge_disc_at(const vec3& position) const {
        if (!(merge_radius_m > 0)) return {};
        const float radius_m = radii ? radius_share * radii->radius_m(position, radius_turn) : merge_radius_m;
        return {radius_m, coverage->may_be_cut(position, radius_m * (edge_radius_m / merge_radius_m))};
    }
    /// Where a light path merges at that place. `caustic`: it was scattered before, and by delta lobes alone.
    MergeDisc merge_disc_at(const vec3& position, bool caustic) const {
        const MergeDisc disc = merge_disc_at(position);
        return caustic ? disc.scaled(everywhere.numbers.caustic_radius) : disc;
    }
    /// Of a path whose first surface lies so far from the camera.
    MergingCorrelation correlation(const Mis& mis, float first_distance_m) const {
        return {mis.heuristic(), first_distance_m, static_cast<float>(light_paths)};
    }
};

/// What a contribution is a part of, beside the beauty.
enum class Join : uint8_t { LightSample, Connection, Merge, LightImage };

/// Adds light of a path with so many scatterings, all of them delta beyond x_1 where `caustic` says so.
inline void add_joined(PassImage& image, uint32_t pixel, uint32_t scatterings, bool caustic, Join join,
                       const Rgb& radiance) {
    if (scatterings <= 1) {
        image.of<Layer::Direct>()[pixel] += radiance;
    } else {
        image.of<Layer::Indirect>()[pixel] += radiance;
        if (caustic && image.layers.has(Layer::Caustic)) image.of<Layer::Caustic>()[pixel] += radiance;
    }
    const auto add_to = [&]<Layer layer>() {
        if (image.layers.has(layer)) image.of<layer>()[pixel] += radiance;
    };
    if (join == Join::Connection) add_to.template operator()<Layer::Connections>();
    if (join == Join::Merge) add_to.template operator()<Layer::Merges>();
    if (join == Join::LightImage) add_to.template operator()<Layer::LightImage>();
}

}  // namespace photond
