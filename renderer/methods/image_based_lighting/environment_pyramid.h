#pragma once
// Sums over an environment, weighed by the lobe of a GGX surface looked at straight on: over few large parts of it
// where the weight hardly changes, over its texels where it does.

#include <vector>

#include "renderer/core/rgb.h"

namespace photond {

struct Environment;
class EnvironmentSampler;

/// Means of radiance over the cells of equirectangular grids, each of half the resolution of the one before. In the
/// map's own turn, so that texels are cells.
class EnvironmentPyramid {
public:
    /// With `columns` cells around the horizon at least, and not many more where the map has: whole texels to a cell,
    /// or whole cells to a texel. In parallel.
    EnvironmentPyramid(const Environment& environment, const EnvironmentSampler& sampler, uint32_t columns);
    static uint64_t bytes_for(Size2 map, uint32_t columns);

    /// Mean radiance about a direction, weighed by D(h) max(0, cos), h being halfway between it and what is weighed, D
    /// the GGX distribution [Karis 2013, with n = v = r]. With alpha = 1 by the cosine alone: irradiance over pi.
    Rgb blurred(const vec3& direction, float alpha) const;

private:
    struct Row {
        float height, radius;  // of the unit sphere, at the row's middle
        float cosines;         // between its edges: with a column's angle the solid angle
        float angle;
    };
    struct Column {
        float x, z;  // on the horizon
        float angle;
    };
    struct Level {
        Size2 size;
        std::vector<Row> rows;
        std::vector<Column> columns;
        std::vector<Rgb> radiance;

        Rgb& at(uint32_t x, uint32_t y) { return radiance[size_t{y} * size.width + x]; }
        const Rgb& at(uint32_t x, uint32_t y) const { return radiance[size_t{y} * size.width + x]; }
        float solid_angle(uint32_t x, uint32_t y) const { return rows[y].cosines * columns[x].angle; }
    };
    struct Lobe;

    static Level make_level(Size2 cells, uint32_t side, float rotation);
    static void reduce(const Level& finer, Level& to);
    void add(const Lobe& lobe, size_t level, uint32_t x, uint32_t y, vec4& sum) const;

    const float mean_radiance_;
    std::vector<Level> levels_;  // finest first
};

}  // namespace photond
