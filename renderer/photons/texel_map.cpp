#include "renderer/photons/texel_map.h"

#include <algorithm>
#include <bit>

#include "renderer/core/hilbert.h"
#include "renderer/photons/weak_lights.h"

namespace photond {

namespace {

constexpr uint64_t kMapStream = 1;  // of RandomDomain::Photons in a pass; 0: ReflectiveShadowMapPass
constexpr uint32_t kPlaceBits = TexelMapPass::kPlaceBits;
static_assert(kPlaceBits == 2 * kHilbertLevels);
constexpr float kCells = 1u << kHilbertLevels;  // a side

}  // namespace

TexelMap::TexelMap(const EmissionSampler& emission, uint32_t side)
    : emission_(emission), levels_(static_cast<uint32_t>(std::countr_zero(side))) {
    double weak = 0, strong = 0;
    for (uint32_t light = 0; light < emission.lights(); ++light) {
        const double expected = double{emission.probability(light)} * texels();
        if (!(expected > 0)) continue;
        const gpu::TexelRun run{light, 0, 1, static_cast<float>(expected)};
        (expected < 1 ? weak_ : runs_).push_back(run);
        (expected < 1 ? weak : strong) += expected;
    }
    // Room for the weak ones is kept free. Of what is left each strong light has one texel, and the rest by power:
    // there are as many at least, as each expects one or more.
    const double rest = texels() - std::ceil(weak) - static_cast<double>(runs_.size());
    const double surplus = strong - static_cast<double>(runs_.size());
    double expected_so_far = 0;
    uint32_t next = 0;
    for (gpu::TexelRun& run : runs_) {
        run.first_texel = next;
        const double before = surplus > 0 ? std::floor(rest * (expected_so_far / surplus)) : 0;
        expected_so_far += double{run.expected} - 1;
        const double after = surplus > 0 ? std::floor(rest * (expected_so_far / surplus)) : 0;
        run.texels = 1 + static_cast<uint32_t>(after - before);
        run.expected = static_cast<float>(run.texels);
        next += run.texels;
    }
}

TexelMapPass::TexelMapPass(const TexelMap& map, uint64_t seed, uint32_t pass) : map_(map) {
    const MapPassNumbers numbers(seed, pass, kMapStream);
    seed_ = numbers.texel_seed;
    rotation_ = numbers.rotation;
    texels_ = map.runs().empty() ? 0 : map.runs().back().first_texel + map.runs().back().texels;
    take_turns(map.weak(), numbers.offset, [&](gpu::TexelRun run) {
        run.first_texel = texels_++;
        chosen_.push_back(run);
    });
}

TexelMapPass::TexelNumbers TexelMapPass::numbers(uint32_t texel, const vec2& u_jitter, vec2 u_position,
                                                 vec2 u_direction) const {
    const std::vector<gpu::TexelRun>& runs =
        chosen_.empty() || texel < chosen_.front().first_texel ? map_.runs() : chosen_;
    const gpu::TexelRun& run =
        *(std::upper_bound(runs.begin(), runs.end(), texel,
                           [](uint32_t t, const gpu::TexelRun& other) { return t < other.first_texel; }) -
          1);
    (map_.emission().guided_by_position(run.light) ? u_position : u_direction) =
        place_in_square(texel - run.first_texel, run.texels, u_jitter);
    return {run.light, run.expected, u_position, u_direction};
}

bool TexelMapPass::sample(uint32_t texel, const vec2& u_jitter, const vec2& u_position, const vec2& u_direction,
                          EmissionSample& out) const {
    const TexelNumbers mine = numbers(texel, u_jitter, u_position, u_direction);
    return map_.emission().sample_light(mine.light, mine.expected, mine.u_position, mine.u_direction, out);
}

const gpu::TexelRun* TexelMapPass::run_of(uint32_t light) const {
    for (const std::vector<gpu::TexelRun>* runs : {&map_.runs(), &chosen_}) {  // both by their lights
        const auto found = std::ranges::lower_bound(*runs, light, {}, &gpu::TexelRun::light);
        if (found != runs->end() && found->light == light) return &*found;
    }
    return nullptr;
}

uint64_t TexelMapPass::curve_place(const gpu::TexelRun& run, const vec2& u_position, const vec2& u_direction) const {
    const vec2& guided = map_.emission().guided_by_position(run.light) ? u_position : u_direction;
    return (uint64_t{run.first_texel} << kPlaceBits) + hilbert_place(uvec2(guided * kCells)) * run.texels;
}

vec2 place_in_square(uint32_t j, uint32_t n, const vec2& u_jitter) {
    const uvec2 jitter(u_jitter * kCells);
    const uint64_t jittered = uint64_t{j} << kPlaceBits | uint64_t{jitter.x} << kHilbertLevels | jitter.y;
    return (vec2(hilbert_cell(jittered / n)) + 0.5f) * (1 / kCells);
}

uint32_t texel_at_place(const vec2& place, uint32_t n) {
    return static_cast<uint32_t>(hilbert_place(uvec2(place * kCells)) * n >> kPlaceBits);
}

}  // namespace photond
