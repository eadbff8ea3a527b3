#include "renderer/bidirectional/bidirectional_plan.h"

#include "renderer/bidirectional/technique_pilot.h"
#include "renderer/core/parallel.h"
#include "renderer/core/rng.h"
#include "renderer/frame/left_out.h"
#include "renderer/photons/pilot_radius.h"
#include "renderer/progressive/disc_radii.h"
#include "renderer/progressive/first_radius.h"

namespace photond {

namespace {

constexpr uint64_t kPilotSeed = reference_seed(0xb1d1);
constexpr uint32_t kPilotPaths = 1u << 15;
constexpr uint32_t kTrainingPaths = 1u << 17;  // where they train radii
constexpr size_t kRadiusPlaces = 8192;         // about, where radii are trained
constexpr uint32_t kPilotNearest = 8;          // vertices among which a pilot's density is measured
constexpr size_t kLeastSeen = 100;             // vertices whose density says something
// Of the power is where they are denser than the first radius asks for.
constexpr double kBrightShare = 0.5, kBrightCausticShare = 0.25;

/// Those that the camera sees, whose density is what the image shows; all, where it sees hardly any: by mirrors alone.
std::vector<LightVertex> seen_vertices(const BidirectionalScene& scene, const std::vector<LightVertex>& vertices,
                                       Counts& counts) {
    ShadowBatch<const LightVertex*> rays(vertices.size());
    for (const LightVertex& vertex : vertices) {
        const auto seen = scene.camera.connect(vertex.position, vec2(0.5f));
        if (!seen || !scene.filter.reaches_image(seen->film, scene.view.film_size)) continue;
        const vec3 start = ray_origin(vertex.surface(scene.scene).point, seen->to_camera);
        rays.add({start, seen->target - start, 1.0f}, &vertex);
    }
    std::vector<LightVertex> found;
    counts.shadow_rays += rays.trace(scene.intersector, Coherence::Incoherent,
                                     [&](const LightVertex* vertex) { found.push_back(*vertex); });
    return found.size() < kLeastSeen ? vertices : found;
}

/// All that any of them has: the most connections, and whether one merges. They share their light paths.
TechniqueCandidate union_of(std::span<const TechniqueCandidate> of_blocks) {
    TechniqueCandidate all = of_blocks.front();
    for (const TechniqueCandidate& candidate : of_blocks) {
        all.connections = std::max(all.connections, candidate.connections);
        all.merges = all.merges || candidate.merges;
    }
    return all;
}

/// Of the vertices that are asked for, as photons.
template <class Wanted>
PhotonMap map_of(std::span<const LightVertex> vertices, const PhotonSearch& search, const Wanted& wanted) {
    std::vector<Photon> photons;
    photons.reserve(vertices.size());
    for (const LightVertex& v : vertices)
        if (wanted(v))
            photons.push_back({v.position, PhotonPayload::make(v.power_w, v.from, v.normal, v.surfaces, v.all_delta)});
    return PhotonMap(std::move(photons), search);
}

struct FirstRadius {
    float radius_m;
    float caustic_radius = 1;  // of it
};

/// `pilot`: vertices of its light paths. `paths_over_pilot`: of a pass.
FirstRadius first_merge_radius(const MergingParams& merging, std::span<const LightVertex> pilot, float scene_radius_m,
                               double paths_over_pilot) {
    const RadiusLimits limits(scene_radius_m);
    const float share = merging.caustic_radius_share.value_or(1);
    if (merging.radius_m) return {*merging.radius_m, share};
    if (merging.radius_relative) return {std::max(*merging.radius_relative * scene_radius_m, limits.least_m), share};
    // Caustics are sharp and dense where the rest is smooth.
    const auto wanted_m = [&](bool caustic) {
        const PhotonMap map = map_of(pilot, {PhotonSearch::Kind::Nearest, kPilotNearest, limits.most_m},
                                     [&](const LightVertex& v) { return v.caustic() == caustic; });
        if (map.size() < kPilotNearest) return limits.most_m;
        const float found_m = radius_of_pilot(map, {.photons_in_radius = static_cast<double>(merging.nearest_vertices),
                                                    .bright_share = caustic ? kBrightCausticShare : kBrightShare,
                                                    .paths_over_pilot = paths_over_pilot});
        return std::clamp(found_m, limits.least_m, limits.most_m);
    };
    const float radius_m = wanted_m(false), caustic_m = wanted_m(true);
    return {radius_m, merging.caustic_radius_share.value_or(std::min(caustic_m / radius_m, 1.0f))};
}

/// Where the camera sees light, each place's own radius; none of them far from the one that would be everyone's.
RadiusMap train_merge_radii(const BidirectionalScene& scene, const MergingParams& merging,
                            std::span<const LightVertex> seen, const PhotonMap& pilot, double pilot_passes,
                            float global_m) {
    constexpr float kLeastShare = 0.25f, kMostShare = 2;  // of global_m
    const EstimateSettings estimate{
        .kernel = Kernel(KernelShape::Constant), .disc_thickness_m = {}, .soft_disc = false};
    const double scale = over_schedule(double{merging.alpha});
    const size_t step = std::max<size_t>(1, seen.size() / kRadiusPlaces);
    std::vector<PlacedRadius> places(seen.size() / step);
    parallel_for(places.size(), 64, [&](size_t i) {
        const LightVertex& vertex = seen[i * step];
        const SurfaceVertex surface = vertex.surface(scene.scene);
        const auto to_eye = scene.camera.connect(vertex.position, vec2(0.5f));
        const vec3 wo = surface.point.shading.to_local(to_eye ? to_eye->to_camera : vertex.from);
        Neighbours scratch;
        const auto first_m = first_radius_at({surface.point, surface.bsdf, wo}, pilot, pilot_passes, estimate, scratch);
        const float wanted_m = first_m ? static_cast<float>(scale * double{*first_m}) : global_m;
        places[i] = {vertex.position, std::clamp(wanted_m, kLeastShare * global_m, kMostShare * global_m)};
    });
    return RadiusMap(std::move(places), global_m);
}

}  // namespace

uint64_t bytes_of_light_vertex(const MergingParams* merging) {
    const bool places = merging != nullptr && merging->correlated();
    return sizeof(LightVertex) + (places ? sizeof(PathVertex) : 0);
}

uint64_t estimate_radii_bytes(const MergingParams* merging) {
    if (merging == nullptr || merging->radius_rule != RadiusRule::Trained) return 0;
    const auto vertices = static_cast<uint64_t>(kExpectedLightVertices * kTrainingPaths);
    return RadiusMap::bytes_for(kRadiusPlaces) + PhotonMap::bytes_for(vertices) + vertices * sizeof(LightVertex);
}

float most_light_paths(const BidirectionalParams& params, Size2 size, double vertices_per_path) {
    const double room = static_cast<double>(params.light_cache_mib) * (1 << 20) /
                        (kLightVertexMargin * std::max(vertices_per_path, 0.1) *
                         static_cast<double>(bytes_of_light_vertex(params.merging())));
    return static_cast<float>(std::min(room, 1e9) / static_cast<double>(size.pixels()));
}

uint32_t paths_of_pass(float light_paths, Size2 size) {
    return static_cast<uint32_t>(std::lround(double{light_paths} * static_cast<double>(size.pixels())));
}

BidirectionalPlan make_bidirectional_plan(const RenderContext& context, const BidirectionalParams& params,
                                          const BidirectionalScene& scene, LightPathTracer& light, TechniquesBy by,
                                          uint64_t (*bytes_of_path)(double vertices, const MergingParams* merging),
                                          Stats& stats) {
    const StageTimer timer(stats, "pilot");
    const Size2 size = scene.view.film_size;
    BidirectionalPlan plan;
    PassTechniques& techniques = plan.techniques;
    techniques.own_path = params.connections == Connections::OwnPath;
    techniques.correlated = params.merging() != nullptr && params.merging()->correlated();
    double& vertices = plan.vertices_per_path;
    float& first_radius_m = plan.first_radius_m;
    float caustic_radius = 1;
    if (scene.emission.total_power_w() > 0 && params.light_paths.value_or(1) > 0) {
        PassTechniques pilot;
        const bool trains = params.merging() != nullptr && params.merging()->radius_rule == RadiusRule::Trained;
        pilot.light_paths = trains ? kTrainingPaths : std::min(kPilotPaths, static_cast<uint32_t>(size.pixels()));
        Counts counts;
        const LightPaths& paths = light.trace(hash64(scene.seed) ^ kPilotSeed, 0, pilot, counts, CancelToken{});
        stats.counts.photon_rays += counts.photon_rays;
        vertices = static_cast<double>(paths.vertices.size()) / pilot.light_paths;
        if (params.merging() != nullptr && vertices > 0) {
            const float light_paths =
                std::min(params.light_paths.value_or(1), most_light_paths(params, size, vertices));
            const MergingParams& merging = *params.merging();
            const std::vector<LightVertex> seen = seen_vertices(scene, paths.vertices, stats.counts);
            const double over_pilot = double{light_paths} * static_cast<double>(size.pixels()) / pilot.light_paths;
            const FirstRadius first = first_merge_radius(merging, seen, scene.scene.bounds.radius(), over_pilot);
            first_radius_m = first.radius_m;
            caustic_radius = first.caustic_radius;
            plan.alpha = merging.alpha;
            if (trains) {
                context.budget.require("radius_pilots", PhotonMap::bytes_for(paths.vertices.size()));
                const float most_m = RadiusLimits(scene.scene.bounds.radius()).most_m;
                plan.radii =
                    train_merge_radii(scene, merging, seen,
                                      map_of(paths.vertices, {PhotonSearch::Kind::Nearest, kRadiusPilotNearest, most_m},
                                             [](const LightVertex&) { return true; }),
                                      1 / over_pilot, first_radius_m);
                first_radius_m = plan.radii->most_m();
            }
            plan.coverage = std::make_unique<const DiscCoverage>(scene.scene, scene.intersector, first_radius_m);
        }
    }
    const auto skip_light_paths = [&](const char* why) {
        const uint64_t paths = paths_of_pass(params.light_paths.value_or(1), size);
        stats.skipped.push_back({"light paths", why, paths * bytes_of_path(kExpectedLightVertices, params.merging())});
    };
    if (!(vertices > 0)) {
        skip_light_paths(!(scene.emission.total_power_w() > 0) ? "the scene has no light"
                         : params.light_paths.value_or(1) > 0  ? "light paths meet nothing that can be joined"
                                                               : "light_paths is 0");
        return plan;
    }

    // Light of points, spots and suns by mirrors and glass: no path from the eye ends there, and what mirrors show of
    // it is connected, or merged.
    const bool by_delta_alone = has_delta_light_by_delta(scene.scene.needs);
    const TechniqueChoices choices{
        .light_paths = params.light_paths,
        .most_light_paths = most_light_paths(params, size, vertices),
        .connections = techniques.own_path ? std::optional<uint32_t>(1) : params.connections_per_vertex,
        .merges = first_radius_m > 0,
        .needs_light_paths = by_delta_alone,
        .needs_connections = by_delta_alone && !(first_radius_m > 0),
        .needs_merges = by_delta_alone && first_radius_m > 0};
    TechniqueCandidate chosen{.light_paths = std::min(params.light_paths.value_or(1), choices.most_light_paths),
                              .connections = choices.connections.value_or(1),
                              .merges = choices.merges};
    std::vector<TechniqueCandidate> of_blocks;  // where they are asked for
    uint32_t block_side = 0;
    if (params.adapt) {
        const TechniquePilot judged =
            run_technique_pilot({context, params, vertices, choices, first_radius_m, caustic_radius,
                                 plan.radii ? &*plan.radii : nullptr, plan.coverage.get()},
                                stats);
        chosen = judged.candidates[judged.chosen.everywhere].candidate;
        if (by == TechniquesBy::Block) {
            block_side = judged.block_side;
            for (const size_t c : judged.chosen.of_blocks) of_blocks.push_back(judged.candidates[c].candidate);
            chosen = union_of(of_blocks);
        }
        if (!(chosen.light_paths > 0)) {
            skip_light_paths("paths from the eye alone are worth more here, a pilot says");
            return plan;
        }
        constexpr const char* kNotWorth = "they are not worth their cost here, a pilot says";
        if (chosen.connections == 0 && !params.connections_per_vertex)
            stats.skipped.push_back({"connections", kNotWorth, 0});
        if (choices.merges && !chosen.merges) stats.skipped.push_back({"merging", kNotWorth, 0});
    }
    techniques.light_paths = std::max(paths_of_pass(chosen.light_paths, size), 1u);
    const auto of_pixel = [&](const TechniqueCandidate& candidate) {
        return BlockTechniques{
            .connections_per_vertex = candidate.connections,
            .numbers = {
                .light_paths = static_cast<float>(techniques.light_paths),
                .connections = techniques.own_path ? 1.0f : static_cast<float>(candidate.connections / vertices),
                .merges = candidate.merges,
                .caustic_radius = caustic_radius}};
    };
    techniques.everywhere = of_pixel(chosen);
    std::vector<BlockTechniques> blocks;
    blocks.reserve(of_blocks.size());
    for (const TechniqueCandidate& candidate : of_blocks) blocks.push_back(of_pixel(candidate));
    if (std::ranges::any_of(blocks, [&](const BlockTechniques& b) { return b != techniques.everywhere; }))
        plan.blocks.emplace(size, block_side, std::move(blocks));
    techniques.correlated = techniques.correlated && chosen.merges;
    return plan;
}

PassTechniques BidirectionalPlan::of_pass(uint32_t pass) const {
    PassTechniques of_pass = techniques;
    if (techniques.everywhere.numbers.merges) {
        of_pass.radius_share = radius_share(pass, double{alpha});
        of_pass.merge_radius_m = first_radius_m * of_pass.radius_share;
    }
    if (radii) {
        of_pass.radii = &*radii;
        of_pass.radius_turn = hash32(pass);
    }
    of_pass.edge_radius_m = of_pass.merge_radius_m;
    of_pass.coverage = coverage.get();
    if (blocks) of_pass.blocks = &*blocks;
    return of_pass;
}

}  // namespace photond
