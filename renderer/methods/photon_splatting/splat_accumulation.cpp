#include "renderer/methods/photon_splatting/splat_accumulation.h"

#include "renderer/many_lights/vpl.h"
#include "renderer/transport/photon_scattering.h"

namespace photond {

namespace {

namespace stdx = std::experimental;
constexpr stdx::vector_aligned_tag kAligned;

void add_to(LaneFloats& sums, const FloatLanes& values) {
    (FloatLanes(sums, kAligned) + values).copy_to(sums, kAligned);
}

/// Where shadow rays from the points to a splat's origin begin: offset_ray_origin(), lane by lane.
Vec3Lanes shadow_ends(const PointBlock& points, const Splat& splat) {
    const Vec3Lanes p = points.position.load(), n = points.geometric_normal.load();
    const FloatLanes side = select(dot(n, broadcast(splat.origin) - p) < 0, FloatLanes(-1), FloatLanes(1));
    return {lambert_lanes::offset_coordinate(p.x, side * n.x), lambert_lanes::offset_coordinate(p.y, side * n.y),
            lambert_lanes::offset_coordinate(p.z, side * n.z)};
}

/// What changes a splat's intensity towards a point, `d` from its origin.
Rgb intensity_towards(const SplatPass& pass, const Splat& splat, const RoughOrigin* rough, const vec3& d) {
    if (!rough && !splat.corrected) return splat.intensity;
    const vec3 w = d * (1 / glm::length(d));
    if (!rough) return splat.intensity * pass.photons.photons[splat.photon].correction_towards(w);
    // The gain holds cos / pi, as Lambert reflectors send it out.
    const float cosine = glm::dot(splat.normal, w);
    if (!(cosine > 0)) return Rgb(0);
    return splat.intensity * scatter_density(rough->surface, rough->rough, rough->wi_world, w) * (kPi / cosine);
}

}  // namespace

SplatAccumulator::SplatAccumulator()
    : rays_(kShadowRays),
      occluded_(kShadowRays),
      arriving_(VisibleCluster::kMostPoints),
      evaluators_(VisibleCluster::kMostPoints) {
    pending_.reserve(kShadowRays);
}

uint64_t SplatAccumulator::bytes_per_thread() {
    return kShadowRays * (sizeof(Ray) + sizeof(Pending) + 1) +
           VisibleCluster::kMostPoints * (sizeof(Arriving) + sizeof(std::optional<BsdfEvaluator>));
}

void SplatAccumulator::light(const SplatPass& pass, const SplatBatch& batch, uint32_t cluster, PointTile& points,
                             Counts& counts) {
    if (batch.of_cluster(cluster).empty()) return;
    const VisibleCluster& at = pass.clusters.clusters()[cluster];
    tile_ = &points;
    blocks_ = points.blocks.data() + at.first_block;
    if (at.general)
        light_cluster<Receiver::General>(pass, batch, cluster, counts);
    else if (at.flat())
        light_cluster<Receiver::FlatLambert>(pass, batch, cluster, counts);
    else
        light_cluster<Receiver::SmoothLambert>(pass, batch, cluster, counts);
}

template <Receiver kReceiver>
void SplatAccumulator::light_cluster(const SplatPass& pass, const SplatBatch& batch, uint32_t cluster, Counts& counts) {
    const VisibleCluster& at = pass.clusters.clusters()[cluster];
    const uint32_t blocks = at.blocks();
    const Kernel& filter = pass.settings.filter;
    for (const SplatBatch::Pair& pair : batch.of_cluster(cluster)) {
        const SplatBatch::Chunk& chunk = batch.chunk(pair);
        const Splat& splat = chunk.splats[pair.splat];
        const bool beam = splat.kind == Splat::Kind::Beam;
        const SplatBroadcast wide(splat, beam ? splat.radius : splat.radius * at.splat_radius_m);
        if (beam) {
            const bool asks_map = pass.settings.visibility;
            const Frame frame(splat.axis);
            for (uint32_t b = 0; b < blocks; ++b) {
                SplatGain found = beam_gain<kReceiver>(splat, wide, blocks_[b], filter);
                counts.splat_contributions += static_cast<uint64_t>(stdx::popcount(found.lit));
                if (asks_map && stdx::any_of(found.lit)) {
                    for (size_t lane = 0; lane < kLanes; ++lane) {
                        if (!found.lit[lane]) continue;
                        const vec3 d = blocks_[b].position.get(lane) - splat.origin;
                        const vec2 across(glm::dot(d, frame.tangent), glm::dot(d, frame.bitangent));
                        if (chunk.depth_maps.reaches(splat.slot, across, glm::dot(d, splat.axis) - splat.near_m))
                            continue;
                        found.lit[lane] = false;
                        found.gain[lane] = 0;
                    }
                }
                take<kReceiver>(pass, splat, nullptr, b, found, true, counts);
            }
            continue;
        }
        const RoughOrigin* rough = splat.kind == Splat::Kind::ConnectRough ? &chunk.rough[splat.slot] : nullptr;
        const bool unknown = pair.blockers == SplatBatch::kUnknown;
        for (uint32_t b = 0; b < blocks; ++b) {
            SplatGain found = connect_gain<kReceiver>(splat, wide, blocks_[b], filter, at.clamp_sq_m2());
            counts.splat_contributions += static_cast<uint64_t>(stdx::popcount(found.lit));
            if (!unknown && pair.blockers != SplatBatch::kClear && stdx::any_of(found.lit)) {
                found.lit = found.lit && !pass.shafts->blocked(batch.blockers(pair), shadow_ends(blocks_[b], splat),
                                                               splat.shadow_target);
                found.gain = select(found.lit, found.gain, FloatLanes(0));
            }
            take<kReceiver>(pass, splat, rough, b, found, !unknown, counts);
        }
    }
    trace_shadow_rays<kReceiver>(pass, counts);
    if constexpr (kReceiver == Receiver::General) {
        for (uint32_t point = 0; point < at.points; ++point) {
            shade_arriving(point);
            evaluators_[point].reset();
        }
    }
}

template <Receiver kReceiver>
void SplatAccumulator::take(const SplatPass& pass, const Splat& splat, const RoughOrigin* rough, uint32_t block,
                            const SplatGain& found, bool clear, Counts& counts) {
    if (stdx::none_of(found.lit)) return;
    PointBlock& points = blocks_[block];
    if (kReceiver != Receiver::General && clear && !rough && !splat.corrected) {
        add_to(points.sum.x, splat.intensity.x * found.gain);
        add_to(points.sum.y, splat.intensity.y * found.gain);
        add_to(points.sum.z, splat.intensity.z * found.gain);
        add_to(points.splats, select(found.lit, FloatLanes(1), FloatLanes(0)));
        if (pass.settings.normalised) {
            // The filter's weight without the receiver's cosine.
            const FloatLanes cosine = -dot(points.normal.load(), broadcast(splat.axis));
            add_to(points.splat_weight, select(found.lit, splat.weight * found.gain / cosine, FloatLanes(0)));
        }
        return;
    }
    for (uint32_t lane = 0; lane < kLanes; ++lane) {
        if (!found.lit[lane]) continue;
        const uint32_t point = block * static_cast<uint32_t>(kLanes) + lane;
        const float gain = found.gain[lane];
        if (clear) {
            add_one<kReceiver>(pass, splat, rough, point, gain);
            continue;
        }
        if (pending_.size() == kShadowRays) trace_shadow_rays<kReceiver>(pass, counts);
        const vec3 position = points.position.get(lane), normal = points.geometric_normal.get(lane);
        const bool front = glm::dot(normal, splat.origin - position) > 0;
        const vec3 from = offset_ray_origin(position, front ? normal : -normal);
        rays_[pending_.size()] = {from, splat.shadow_target - from, kConnectionEnd};
        pending_.push_back({&splat, rough, point, gain});
    }
}

template <Receiver kReceiver>
void SplatAccumulator::add_one(const SplatPass& pass, const Splat& splat, const RoughOrigin* rough, uint32_t point,
                               float gain) {
    PointBlock& points = blocks_[point / kLanes];
    const size_t lane = point % kLanes;
    const vec3 d = points.position.get(lane) - splat.origin;
    const Rgb light = intensity_towards(pass, splat, rough, d) * gain;
    points.splats[lane] += 1;
    if constexpr (kReceiver != Receiver::General) {
        points.sum.set(lane, points.sum.get(lane) + light);
        if (pass.settings.normalised)
            points.splat_weight[lane] += splat.weight * gain / -glm::dot(points.normal.get(lane), splat.axis);
        return;
    }
    if (pass.settings.normalised) points.splat_weight[lane] += splat.weight * gain;
    const VisiblePoint& receiver = tile_->general[points.general[lane]];
    Arriving& arriving = arriving_[point];
    const vec3 from = splat.kind == Splat::Kind::Beam ? -splat.axis : -d * (1 / glm::length(d));
    arriving.wi.set(arriving.count, receiver.surface.shading.to_local(from));
    arriving.irradiance.set(arriving.count, light);
    if (++arriving.count == kLanes) shade_arriving(point);
}

template <Receiver kReceiver>
void SplatAccumulator::trace_shadow_rays(const SplatPass& pass, Counts& counts) {
    const size_t count = pending_.size();
    if (count == 0) return;
    pass.intersector.occluded({rays_.data(), count}, {occluded_.data(), count}, Coherence::Coherent);
    counts.shadow_rays += count;
    for (size_t i = 0; i < count; ++i) {
        const Pending& connection = pending_[i];
        if (!occluded_[i])
            add_one<kReceiver>(pass, *connection.splat, connection.rough, connection.point, connection.gain);
    }
    pending_.clear();
}

/// Scatters what has arrived at a point that is not Lambert towards the eye.
void SplatAccumulator::shade_arriving(uint32_t point) {
    Arriving& arriving = arriving_[point];
    if (arriving.count == 0) return;
    PointBlock& points = blocks_[point / kLanes];
    const size_t lane = point % kLanes;
    const VisiblePoint& receiver = tile_->general[points.general[lane]];
    if (!evaluators_[point]) evaluators_[point].emplace(receiver.rough, receiver.wo);
    for (uint32_t i = arriving.count; i < kLanes; ++i) {
        arriving.wi.set(i, arriving.wi.get(0));
        arriving.irradiance.set(i, vec3(0));
    }
    const Vec3Lanes light = evaluators_[point]->f_cos(arriving.wi.load()) * arriving.irradiance.load();
    points.sum.set(lane,
                   points.sum.get(lane) + vec3(stdx::reduce(light.x), stdx::reduce(light.y), stdx::reduce(light.z)));
    arriving.count = 0;
}

}  // namespace photond
