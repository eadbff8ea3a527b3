#include "renderer/methods/image_based_lighting/environment_pyramid.h"

#include <algorithm>

#include "renderer/core/parallel.h"
#include "renderer/scene/scene.h"
#include "renderer/transport/environment_sampling.h"

namespace photond {

namespace {

constexpr uint32_t kTopColumns = 8;        // of the coarsest grid, at most
constexpr float kMostCellOfScale = 0.35f;  // side of a cell over the scale on which the weight changes

uint32_t divided_up(uint32_t a, uint32_t b) { return (a + b - 1) / b; }

vec3 direction_at(float polar, float azimuth) {
    return {std::sin(polar) * std::sin(azimuth), std::cos(polar), -std::sin(polar) * std::cos(azimuth)};
}

/// Of the finest grid.
Size2 cells_for(Size2 map, uint32_t columns) {
    const uint32_t finer = std::max(divided_up(columns, map.width), divided_up(columns, 2 * map.height));
    if (finer > 1) return {map.width * finer, map.height * finer};
    const uint32_t coarser = std::max(std::min(map.width / (2 * columns), map.height / columns), 1u);
    return {divided_up(map.width, coarser), divided_up(map.height, coarser)};
}

/// Mean of what the sampler interpolates: exact where cells are whole texels or whole parts of one, as within a quarter
/// of such a cell it is bilinear.
Rgb mean_of_cell(const Environment& environment, const EnvironmentSampler& sampler, Size2 cells, uint32_t x,
                 uint32_t y) {
    const uint32_t side = 2 * divided_up(environment.map.size.width, cells.width);
    Rgb sum(0);
    float weights = 0;
    for (uint32_t j = 0; j < side; ++j) {
        const float polar = kPi * (static_cast<float>(y * side + j) + 0.5f) / static_cast<float>(cells.height * side);
        for (uint32_t i = 0; i < side; ++i) {
            const float turn = (static_cast<float>(x * side + i) + 0.5f) / static_cast<float>(cells.width * side);
            sum +=
                std::sin(polar) * sampler.radiance(direction_at(polar, 2 * kPi * (turn - 0.5f) - environment.rotation));
            weights += std::sin(polar);
        }
    }
    return sum / weights;
}

}  // namespace

/// The weight, to a common factor, by the squared distance of two points of the unit sphere: the cosine is 1 less half
/// of that, cos^2 of the angle to the half-vector 1 less a quarter.
struct EnvironmentPyramid::Lobe {
    vec3 direction;
    float alpha_sq;

    float weight(float distance_sq) const {
        const float cosine = 1 - 0.5f * distance_sq;
        return std::max(cosine, 0.0f) / sqr(alpha_sq + 0.25f * distance_sq * (1 - alpha_sq));
    }
    /// Square of how far one has to go from there for it to change by about itself; up to twice that far in the tail,
    /// where little of the weight is.
    float scale_sq(float distance_sq) const {
        const float scale_sq = distance_sq + 4 * alpha_sq;
        return std::min(scale_sq * std::min(std::sqrt(scale_sq / (4 * alpha_sq)), 4.0f), 1.0f);
    }
};

uint64_t EnvironmentPyramid::bytes_for(Size2 map, uint32_t columns) {
    const Size2 finest = cells_for(map, columns);
    uint64_t bytes = 0;
    for (uint32_t side = 1;; side *= 2) {
        const Size2 cells{divided_up(finest.width, side), divided_up(finest.height, side)};
        bytes += cells.pixels() * sizeof(Rgb) + cells.height * sizeof(Row) + cells.width * sizeof(Column);
        if (cells.width <= kTopColumns) return bytes;
    }
}

EnvironmentPyramid::EnvironmentPyramid(const Environment& environment, const EnvironmentSampler& sampler,
                                       uint32_t columns)
    : mean_radiance_(sampler.mean_radiance()) {
    const Size2 cells = cells_for(environment.map.size, columns);
    for (uint32_t side = 1; levels_.empty() || levels_.back().size.width > kTopColumns; side *= 2)
        levels_.push_back(make_level(cells, side, environment.rotation));
    parallel_for(cells.height, 4, [&](size_t row) {
        const auto y = static_cast<uint32_t>(row);
        for (uint32_t x = 0; x < cells.width; ++x)
            levels_[0].at(x, y) = mean_of_cell(environment, sampler, cells, x, y);
    });
    for (size_t l = 1; l < levels_.size(); ++l) reduce(levels_[l - 1], levels_[l]);
}

/// Of cells that are `side` of the finest ones wide and high; less at the far borders.
EnvironmentPyramid::Level EnvironmentPyramid::make_level(Size2 cells, uint32_t side, float rotation) {
    Level level;
    level.size = {divided_up(cells.width, side), divided_up(cells.height, side)};
    level.radiance.resize(level.size.pixels());
    const auto edge = [side](uint32_t cell, uint32_t count) {
        return static_cast<float>(std::min(cell * side, count)) / static_cast<float>(count);
    };
    for (uint32_t y = 0; y < level.size.height; ++y) {
        const float top = kPi * edge(y, cells.height), bottom = kPi * edge(y + 1, cells.height);
        const float middle = 0.5f * (top + bottom);
        // cos(top) - cos(bottom), without its cancellation.
        const float cosines = 2 * std::sin(middle) * std::sin(0.5f * (bottom - top));
        level.rows.push_back({std::cos(middle), std::sin(middle), cosines, bottom - top});
    }
    for (uint32_t x = 0; x < level.size.width; ++x) {
        const float left = edge(x, cells.width), right = edge(x + 1, cells.width);
        const vec3 direction = direction_at(0.5f * kPi, kPi * (left + right - 1) - rotation);
        level.columns.push_back({direction.x, direction.z, 2 * kPi * (right - left)});
    }
    return level;
}

void EnvironmentPyramid::reduce(const Level& finer, Level& to) {
    for (uint32_t y = 0; y < to.size.height; ++y)
        for (uint32_t x = 0; x < to.size.width; ++x) {
            vec4 sum(0);
            for (uint32_t v = 2 * y; v < std::min(2 * y + 2, finer.size.height); ++v)
                for (uint32_t u = 2 * x; u < std::min(2 * x + 2, finer.size.width); ++u)
                    sum += finer.solid_angle(u, v) * vec4(finer.at(u, v), 1);
            to.at(x, y) = vec3(sum) / sum.w;
        }
}

Rgb EnvironmentPyramid::blurred(const vec3& direction, float alpha) const {
    const Lobe lobe{direction, sqr(alpha)};
    const size_t top = levels_.size() - 1;
    vec4 sum(0);
    for (uint32_t y = 0; y < levels_[top].size.height; ++y)
        for (uint32_t x = 0; x < levels_[top].size.width; ++x) add(lobe, top, x, y, sum);
    return vec3(sum) / sum.w;
}

/// Adds a cell's radiance and weight: at once, where it is small on the scale of the weight, and the smaller the more
/// it shines, as a light within it may be anywhere; else those of the cells within.
void EnvironmentPyramid::add(const Lobe& lobe, size_t level, uint32_t x, uint32_t y, vec4& sum) const {
    const Level& here = levels_[level];
    const Row& row = here.rows[y];
    const Column& column = here.columns[x];
    const vec3 apart = vec3(row.radius * column.x, row.height, row.radius * column.z) - lobe.direction;
    const float distance_sq = glm::dot(apart, apart);
    const float side = std::max(row.angle, row.radius * column.angle);
    if (distance_sq > 2 + 2 * side) return;  // all of it below the horizon
    const Rgb& radiance = here.at(x, y);
    const float brightness = mean_radiance_ > 0 ? std::max(mean(radiance) / mean_radiance_, 1.0f) : 1.0f;
    if (level == 0 || sqr(side) * brightness <= sqr(kMostCellOfScale) * lobe.scale_sq(distance_sq)) {
        sum += here.solid_angle(x, y) * lobe.weight(distance_sq) * vec4(radiance, 1);
        return;
    }
    const Size2 finer = levels_[level - 1].size;
    for (uint32_t v = 2 * y; v < std::min(2 * y + 2, finer.height); ++v)
        for (uint32_t u = 2 * x; u < std::min(2 * x + 2, finer.width); ++u) add(lobe, level - 1, u, v, sum);
}

}  // namespace photond
