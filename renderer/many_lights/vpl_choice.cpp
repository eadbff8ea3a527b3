#include "renderer/many_lights/vpl_choice.h"

#include <algorithm>

#include "renderer/core/rng.h"
#include "renderer/many_lights/vpl_choice_shared.h"

namespace photond {

namespace {

namespace stdx = std::experimental;
constexpr stdx::vector_aligned_tag kAligned;

constexpr size_t kGroupBlocks = 8;  // whose sum is kept, so that few lights are looked at twice
constexpr float kLeastGeneralCosine = 0.25f;
constexpr uint32_t kGolden = 0x9e3779b9u;

}  // namespace

struct ResampledVpls::Receiver {
    Vec3Lanes position, normal;
    FloatLanes least_cosine, most_scatterings;
    float clamp_sq_m2;
};

void ResampledVpls::assign(std::span<const Vpl> vpls) {
    const size_t lights_of_group = kGroupBlocks * kLanes;
    blocks_.resize((vpls.size() + lights_of_group - 1) / lights_of_group * kGroupBlocks);
    for (size_t i = 0; i < blocks_.size() * kLanes; ++i) {
        Block& block = blocks_[i / kLanes];
        const size_t lane = i % kLanes;
        const Vpl vpl = i < vpls.size() ? vpls[i] : Vpl{.surface = NO_VPL_SURFACE};
        block.position.set(lane, vpl.position);
        block.normal.set(lane, vpl.normal);
        block.size[lane] = vpl_size(vpl);
        block.least_cosine[lane] = is_lambert(vpl) ? 0.0f : 1.0f;
        block.scatterings[lane] = static_cast<float>(vpl.scatterings);
    }
}

inline FloatLanes ResampledVpls::sizes(const Block& block, const Receiver& to) {
    const Vec3Lanes d = block.position.load() - to.position;
    const FloatLanes d_sq = dot(d, d);
    const FloatLanes along_light = -dot(block.normal.load(), d), along_point = dot(to.normal, d);
    const FloatLanes divisor = stdx::max(d_sq, FloatLanes(to.clamp_sq_m2));
    const FloatLanes inverse_d = 1.0f / stdx::sqrt(stdx::max(d_sq, FloatLanes(1e-37f)));
    const FloatMask lit = along_light > 0 && (along_point > 0 || to.least_cosine == 1) &&
                          FloatLanes(block.scatterings, kAligned) <= to.most_scatterings;
    const FloatLanes least(block.least_cosine, kAligned);
    const FloatLanes cos_light = least + (1.0f - least) * (along_light * inverse_d);
    const FloatLanes cos_point = to.least_cosine + (1.0f - to.least_cosine) * (along_point * inverse_d);
    return select(lit,
                  FloatLanes(block.size, kAligned) * cos_light * cos_point / stdx::max(divisor, FloatLanes(1e-20f)),
                  FloatLanes(0));
}

void ResampledVpls::choose(const ChoicePoints& points, float clamp_sq_m2, Scratch& scratch) const {
    for (size_t lane = 0; lane < kLanes; ++lane) {
        std::vector<ChosenVpl>& chosen = scratch.chosen[lane];
        chosen.clear();
        if (!(points.receivers.there[lane] > 0)) continue;
        const auto of_lane = [&](const Vec3Lanes& v) { return vec3(v.x[lane], v.y[lane], v.z[lane]); };
        const vec3 normal = of_lane(points.receivers.normal);
        const Receiver to{broadcast(of_lane(points.receivers.position)), broadcast(normal),
                          normal == vec3(0)      ? 1.0f
                          : points.general[lane] ? kLeastGeneralCosine
                                                 : 0.0f,
                          static_cast<float>(points.most_scatterings[lane]), clamp_sq_m2};
        scratch.sums.clear();
        double total = 0;
        for (size_t first = 0; first < blocks_.size(); first += kGroupBlocks) {
            FloatLanes sum = 0;
            for (size_t b = first; b < first + kGroupBlocks; ++b) sum += sizes(blocks_[b], to);
            scratch.sums.push_back(stdx::reduce(sum));
            total += double{scratch.sums.back()};
        }
        if (!(total > 0)) continue;

        const double step = total / count_;
        double next = step * double{to_unit_float(hash32(points.key[lane] ^ RESAMPLED_SALT))};
        double passed = 0;
        for (size_t group = 0; group < scratch.sums.size(); ++group) {
            const double end = passed + double{scratch.sums[group]};
            double running = passed;
            size_t last = 0;
            float last_size = 0;
            for (size_t b = group * kGroupBlocks; b < (group + 1) * kGroupBlocks && next < end; ++b) {
                alignas(kLaneAlignment) LaneFloats size;
                sizes(blocks_[b], to).copy_to(size, kAligned);
                for (size_t i = 0; i < kLanes && next < end; ++i) {
                    if (!(size[i] > 0)) continue;
                    running += double{size[i]};
                    last = b * kLanes + i, last_size = size[i];
                    uint32_t times = 0;
                    for (; next < std::min(running, end); next += step) ++times;
                    if (times > 0)
                        chosen.push_back(
                            {static_cast<uint32_t>(last), static_cast<float>(times * step / double{last_size})});
                }
            }
            // What rounding of the group's sum leaves over is its last light's.
            for (; next < end && last_size > 0; next += step)
                chosen.push_back({static_cast<uint32_t>(last), static_cast<float>(step / double{last_size})});
            passed = end;
        }
    }
}

void LightcutVpls::find_cut(const VplReceivers& receivers, float clamp_sq_m2, Scratch& scratch) const {
    using Node = Scratch::Node;
    const auto less = [](const Node& a, const Node& b) { return a.bound < b.bound; };
    std::vector<Node>& heap = scratch.heap;
    heap.clear();
    scratch.cut.clear();
    const auto add = [&](uint32_t index) {
        const float bound = stdx::reduce(vpl_bound(tree_.nodes()[index], receivers, clamp_sq_m2));
        if (!(bound > 0)) return;
        if (index >= tree_.leaves()) {
            scratch.cut.push_back(index);
        } else {
            heap.push_back({bound, index});
            std::push_heap(heap.begin(), heap.end(), less);
        }
    };
    add(VPL_TREE_ROOT);
    while (!heap.empty() && heap.size() + scratch.cut.size() < cut_size_) {
        const uint32_t parted = heap.front().index;
        std::pop_heap(heap.begin(), heap.end(), less);
        heap.pop_back();
        add(2 * parted), add(2 * parted + 1);
    }
    for (const Node& node : heap) scratch.cut.push_back(node.index);
}

void LightcutVpls::choose(const ChoicePoints& points, float clamp_sq_m2, Scratch& scratch) const {
    find_cut(points.receivers, clamp_sq_m2, scratch);
    const std::span<const VplTreeNode> nodes = tree_.nodes();
    for (size_t lane = 0; lane < kLanes; ++lane) {
        std::vector<ChosenVpl>& chosen = scratch.chosen[lane];
        chosen.clear();
        if (!(points.receivers.there[lane] > 0)) continue;
        for (const uint32_t top : scratch.cut) {
            uint32_t state = hash32(points.key[lane] ^ hash32(top ^ LIGHTCUT_SALT));
            uint32_t node = top;
            while (node < tree_.leaves()) {
                const float left = nodes[2 * node].intensity, right = nodes[2 * node + 1].intensity;
                state += kGolden;
                const bool to_left = !(right > 0) || to_unit_float(hash32(state)) * nodes[node].intensity < left;
                node = 2 * node + (to_left ? 0 : 1);
            }
            chosen.push_back({nodes[node].light, nodes[top].intensity / nodes[node].intensity});
        }
    }
}

void light_by_choice(const VplChooser& chooser, const VplPass& pass, const GBuffer& buffer, uint32_t first,
                     uint32_t end, std::span<Rgb> sums, VplLighting& lighting, VplChooser::Scratch& scratch,
                     Counts& counts) {
    for (uint32_t begin = first; begin < end; begin += uint32_t{kLanes}) {
        const uint32_t count = std::min(end - begin, uint32_t{kLanes});
        ChoicePoints points;
        Vec3Array position, normal;
        alignas(kLaneAlignment) LaneFloats there;
        bool any = false;
        for (uint32_t lane = 0; lane < kLanes; ++lane) {
            const bool is_there = lane < count && buffer.points()[begin + lane].kind != 0;
            // What is not there lies with those that are: no lane computes with what is no number.
            const gpu::GBufferPoint& point = buffer.points()[begin + std::min(lane, count - 1)];
            position.set(lane, is_there ? point.position : vec3(0));
            normal.set(lane, is_there ? point.normal : vec3(0));
            there[lane] = is_there ? 1.0f : 0.0f;
            points.key[lane] = lighting.key_of(pass, point);
            points.most_scatterings[lane] = point.kind & GBUFFER_SCATTERINGS;
            points.general[lane] = (point.kind & GBUFFER_GENERAL) != 0;
            any |= is_there;
        }
        if (!any) continue;
        points.receivers = {position.load(), normal.load(), FloatLanes(there, kAligned)};
        chooser.choose(points, pass.clamp_sq_m2, scratch);
        for (uint32_t lane = 0; lane < count; ++lane)
            if (there[lane] > 0)
                sums[begin + lane - first] +=
                    lighting.light_by(pass, buffer, begin + lane, scratch.chosen[lane], counts);
    }
}

}  // namespace photond
