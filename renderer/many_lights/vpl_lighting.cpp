#include "renderer/many_lights/vpl_lighting.h"

#include "renderer/core/rng.h"
#include "renderer/many_lights/vpl_lighting_shared.h"
#include "renderer/many_lights/vpl_shadow_maps.h"
#include "renderer/photons/photon.h"
#include "renderer/transport/photon_scattering.h"
#include "renderer/voxels/sparse_voxel_octree.h"

namespace photond {

namespace {

namespace stdx = std::experimental;
constexpr stdx::vector_aligned_tag kAligned;

}  // namespace

void VplBlock::set(size_t lane, const Vpl& vpl, uint32_t light) {
    position.set(lane, vpl.position);
    normal.set(lane, vpl.normal);
    intensity.set(lane, vpl.intensity);
    scatterings[lane] = static_cast<float>(vpl.scatterings);
    index[lane] = light;
    if (!is_lambert(vpl) || vpl.correction != 1) plain = false;
}

void VplBlock::clear_from(size_t lane) {
    const bool is_plain = plain;
    for (; lane < kLanes; ++lane) set(lane, {.normal = vec3(0), .surface = NO_VPL_SURFACE}, 0);
    plain = is_plain;
}

void VplSubsets::assign(const VplSet& set, uint32_t tiles, uint32_t rotation) {
    blocks_.clear();
    begins_.assign(1, 0);
    const auto count = static_cast<uint32_t>(set.vpls.size());
    for (uint32_t tile = 0; tile < tiles; ++tile) {
        size_t lane = kLanes;
        for (uint32_t i = (tile + rotation) % tiles; i < count; i += tiles) {
            if (lane == kLanes) {
                blocks_.emplace_back().clear_from(0);
                lane = 0;
            }
            blocks_.back().set(lane++, set.vpls[i], i);
        }
        begins_.push_back(static_cast<uint32_t>(blocks_.size()));
    }
}

uint32_t VplLighting::key_of(const VplPass& pass, const gpu::GBufferPoint& point) {
    return hash32(point.pixel ^ hash32(pass.pass ^ hash32(static_cast<uint32_t>(pass.seed ^ pass.seed >> 32))));
}

void VplLighting::start_point(const VplPass& pass, const GBuffer& buffer, uint32_t point) {
    point_ = &buffer.points()[point];
    general_ = (point_->kind & GBUFFER_GENERAL) != 0 ? &buffer.general(point) : nullptr;
    evaluator_.reset();
    if (general_) evaluator_.emplace(general_->rough, general_->wo);
    key_ = key_of(pass, *point_);
    asked_.clear();
}

VplLighting::Arriving VplLighting::arriving(const VplPass& pass, const VplBlock& block) const {
    const Vec3Lanes d = block.position.load() - broadcast(point_->position);
    const FloatLanes d_sq = dot(d, d);
    const FloatLanes inverse_d = 1.0f / stdx::sqrt(stdx::max(d_sq, FloatLanes(1e-37f)));
    const Vec3Lanes w = inverse_d * d;  // to the light
    const FloatLanes cos_o = -dot(block.normal.load(), w);
    const FloatLanes divisor = stdx::max(d_sq, FloatLanes(pass.clamp_sq_m2));
    const float most = static_cast<float>(point_->kind & GBUFFER_SCATTERINGS);
    FloatMask lit = cos_o > 0 && divisor > 0 && FloatLanes(block.scatterings, kAligned) <= most;
    FloatLanes cos_x = 1;
    if (point_->normal != vec3(0)) {
        cos_x = dot(broadcast(point_->normal), w);
        lit = lit && cos_x > 0 && dot(broadcast(point_->geometric_normal), w) > 0;
    }
    Arriving found;
    if (stdx::none_of(lit)) {
        found.light.store(broadcast(vec3(0)));
        FloatLanes(0).copy_to(found.size, kAligned);
        return found;
    }
    const FloatLanes falloff = select(lit, 1.0f / divisor, FloatLanes(0));
    Vec3Lanes light = (cos_o * falloff) * block.intensity.load();
    if (!block.plain) {
        found.light.store(light);
        for (size_t lane = 0; lane < kLanes; ++lane) {
            if (!lit[lane]) continue;
            const Vpl& vpl = pass.set.vpls[block.index[lane]];
            const vec3 out(-w.x[lane], -w.y[lane], -w.z[lane]);
            if (is_lambert(vpl)) {
                const bool in_front = glm::dot(Octahedral<16>::decode(vpl.smooth_normal), out) > 0;
                if (vpl.correction != 1 && in_front) found.light.set(lane, found.light.get(lane) * vpl.correction);
            } else {
                const RoughOrigin& from = pass.set.rough[vpl.surface];
                found.light.set(lane, vpl.intensity * float(falloff[lane]) *
                                          scatter_density(from.surface, from.rough, from.wi_world, out));
            }
        }
        light = found.light.load();
    }
    if (general_) {
        const Frame& frame = general_->surface.shading;
        const Vec3Lanes local{dot(broadcast(frame.tangent), w), dot(broadcast(frame.bitangent), w),
                              dot(broadcast(frame.normal), w)};
        light = light * evaluator_->f_cos(local);
        light = {select(lit, light.x, FloatLanes(0)), select(lit, light.y, FloatLanes(0)),
                 select(lit, light.z, FloatLanes(0))};
    } else {
        light = cos_x * light;
    }
    found.light.store(light);
    stdx::max(light.x, stdx::max(light.y, light.z)).copy_to(found.size, kAligned);
    return found;
}

void VplLighting::ask(const VplPass& pass, uint32_t vpl, const Rgb& light) {
    const Vpl& from = pass.set.vpls[vpl];
    if (pass.visibility == VplVisibility::Rays) {
        const vec3 d = from.position - point_->position;
        const bool front = glm::dot(point_->geometric_normal, d) > 0;
        const vec3 origin =
            offset_ray_origin(point_->position, front ? point_->geometric_normal : -point_->geometric_normal);
        rays_.push_back({origin, offset_ray_origin(from.position, from.normal) - origin, kConnectionEnd});
    }
    asked_.push_back({vpl, light});
}

/// Russian roulette over V: by what would come unshadowed alone, which is of size `size` where lights of the point
/// bring `mean`, so that the mean stays.
void VplLighting::ask_by_chance(const VplPass& pass, uint32_t vpl, const Rgb& light, float size, float mean) {
    if (!(size > 0)) return;
    const float bright = pass.visibility == VplVisibility::None ? 0 : pass.roulette * mean;
    float chance = 1;
    if (size < bright) {
        chance = std::max(size / bright, general_ ? VPL_LEAST_GENERAL_CHANCE : 0.0f);
        if (!(to_unit_float(hash32(key_ + 0x9e3779b9u * vpl)) < chance)) return;
    }
    ask(pass, vpl, light / chance);
}

Rgb VplLighting::trace(const VplPass& pass, Counts& counts) {
    Rgb sum(0);
    if (pass.visibility != VplVisibility::None) counts.shadow_rays += asked_.size();
    occluded_.assign(asked_.size(), 0);
    if (pass.visibility == VplVisibility::Rays) {
        pass.eye.intersector.occluded(rays_, occluded_, Coherence::Coherent);
        rays_.clear();
    } else if (asks_voxels(pass.visibility)) {
        segments_.clear();
        for (const Asked& asked : asked_) {
            const Vpl& from = pass.set.vpls[asked.vpl];
            const bool front = glm::dot(point_->geometric_normal, from.position - point_->position) > 0;
            segments_.push_back({point_->position, front ? point_->geometric_normal : -point_->geometric_normal,
                                 from.position, from.normal});
        }
        svo_occluded(pass.tree->view(), segments_, occluded_, pass.voxel_reach_m);
    } else if (pass.visibility == VplVisibility::ShadowMaps) {
        for (size_t i = 0; i < asked_.size(); ++i) occluded_[i] = pass.maps->occluded(asked_[i].vpl, point_->position);
    }
    for (size_t i = 0; i < asked_.size(); ++i)
        if (!occluded_[i]) sum += asked_[i].light;
    asked_.clear();
    return sum;
}

void VplLighting::light(const VplPass& pass, const GBuffer& buffer, uint32_t first, uint32_t end, std::span<Rgb> sums,
                        Counts& counts) {
    const SplitLayout& layout = buffer.layout();
    const std::span<const VplBlock> blocks = pass.subsets.of_tile(layout.tile_of(first));
    const auto scale = static_cast<float>(layout.tiles());
    for (uint32_t index = first; index < end; ++index) {
        if (buffer.points()[index].kind == 0) continue;
        start_point(pass, buffer, index);
        arriving_.clear();
        float total = 0;
        uint32_t lit = 0;
        for (const VplBlock& block : blocks) {
            arriving_.push_back(arriving(pass, block));
            const FloatLanes size(arriving_.back().size, kAligned);
            total += stdx::reduce(size);
            lit += static_cast<uint32_t>(stdx::popcount(size > 0));
        }
        if (lit == 0) continue;
        const float mean = total / static_cast<float>(lit);
        for (size_t b = 0; b < blocks.size(); ++b)
            for (size_t lane = 0; lane < kLanes; ++lane)
                ask_by_chance(pass, blocks[b].index[lane], arriving_[b].light.get(lane) * scale,
                              arriving_[b].size[lane], mean);
        sums[index - first] += trace(pass, counts);
    }
}

Rgb VplLighting::light_by(const VplPass& pass, const GBuffer& buffer, uint32_t point, std::span<const ChosenVpl> lights,
                          Counts& counts) {
    start_point(pass, buffer, point);
    blocks_.clear();
    arriving_.clear();
    float total = 0;
    uint32_t lit = 0;
    for (size_t first = 0; first < lights.size(); first += kLanes) {
        const size_t count = std::min(lights.size() - first, kLanes);
        VplBlock& block = blocks_.emplace_back();
        for (size_t lane = 0; lane < count; ++lane)
            block.set(lane, pass.set.vpls[lights[first + lane].vpl], lights[first + lane].vpl);
        block.clear_from(count);
        arriving_.push_back(arriving(pass, block));
        for (size_t lane = 0; lane < count; ++lane) {
            total += arriving_.back().size[lane] * lights[first + lane].weight;
            lit += arriving_.back().size[lane] > 0 ? 1 : 0;
        }
    }
    if (lit == 0) return Rgb(0);
    const float mean = total / static_cast<float>(lit);
    for (size_t i = 0; i < lights.size(); ++i) {
        const Arriving& from = arriving_[i / kLanes];
        const size_t lane = i % kLanes;
        ask_by_chance(pass, lights[i].vpl, from.light.get(lane) * lights[i].weight, from.size[lane] * lights[i].weight,
                      mean);
    }
    return trace(pass, counts);
}

}  // namespace photond
