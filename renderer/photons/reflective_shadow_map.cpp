#include "renderer/photons/reflective_shadow_map.h"

#include <algorithm>

#include "renderer/photons/emission_grid.h"
#include "renderer/photons/weak_lights.h"

namespace photond {

namespace {

/// Of RandomDomain::Photons in a pass; the light paths' numbers are of a SequenceSampler.
constexpr uint64_t kMapStream = 0;

/// At most so many texels in a grid about as wide as high.
uvec2 grid_size(double texels) {
    auto columns = static_cast<uint32_t>(std::sqrt(texels));
    // The other numbers come along one sequence from texel to texel, row after row. With an even number of columns
    // their leading bits would repeat down a column; with an odd one each column is covered as evenly as each row. Few
    // texels have no room for the difference.
    if (columns >= 8) columns |= 1u;
    return {columns, static_cast<uint32_t>(texels / columns)};
}

}  // namespace

ReflectiveShadowMaps::ReflectiveShadowMaps(const EmissionSampler& emission, uint32_t texels) : emission_(emission) {
    double left_over = 0;  // of a texel, by the lights before: many lights of few texels each have all together
    for (uint32_t light = 0; light < emission.lights(); ++light) {
        const double expected = double{emission.probability(light)} * texels;
        if (!(expected > 0)) continue;
        if (expected < 1) {
            weak_.push_back({light, uvec2(1), 0, static_cast<float>(expected)});
            continue;
        }
        const uvec2 size = grid_size(expected + left_over);
        const uint64_t count = uint64_t{size.x} * size.y;
        left_over = std::min(expected + left_over - static_cast<double>(count), 1.0);
        grids_.push_back({light, size, texels_, static_cast<float>(count)});
        texels_ += count;
    }
}

ReflectiveShadowMapPass::ReflectiveShadowMapPass(const ReflectiveShadowMaps& maps, uint64_t seed, uint32_t pass)
    : maps_(maps), texels_(maps.texels_) {
    const MapPassNumbers numbers(seed, pass, kMapStream);
    seed_ = numbers.texel_seed;
    take_turns(maps.weak_, numbers.offset, [&](Grid grid) {
        grid.first_texel = texels_++;
        chosen_.push_back(grid);
    });
}

bool ReflectiveShadowMapPass::sample(uint64_t texel, const vec2& u_jitter, vec2 u_position, vec2 u_direction,
                                     EmissionSample& out) const {
    const std::vector<Grid>& grids = texel < maps_.texels_ ? maps_.grids_ : chosen_;
    const Grid& grid = *(std::upper_bound(grids.begin(), grids.end(), texel,
                                          [](uint64_t t, const Grid& other) { return t < other.first_texel; }) -
                         1);
    const uint64_t place = texel - grid.first_texel;
    const uvec2 cell(place % grid.size.x, place / grid.size.x);
    (maps_.emission_.guided_by_position(grid.light) ? u_position : u_direction) = into_cell(cell, grid.size, u_jitter);
    return maps_.emission_.sample_light(grid.light, grid.expected, u_position, u_direction, out);
}

std::vector<gpu::TexelGrid> ReflectiveShadowMapPass::device_grids() const {
    std::vector<gpu::TexelGrid> grids;
    grids.reserve(maps_.grids_.size() + chosen_.size());
    for (const std::vector<Grid>* some : {&maps_.grids_, &chosen_})
        for (const Grid& grid : *some)
            grids.push_back(
                {grid.light, grid.size.x, grid.size.y, static_cast<uint32_t>(grid.first_texel), grid.expected});
    return grids;
}

}  // namespace photond
