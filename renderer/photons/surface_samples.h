#pragma once
// The share of a kernel that lies on surfaces, by points spread over them beforehand: where so many boundary edges lie
// within one disc that the exact sum over them (SurfaceBoundary) would take too long.
//
// A level of samples is for discs of radii from r / 2 to r, the level after it for half of these. Each sample stands
// for about pi r^2 / 128 of surface, so that a disc that lies whole on one surface holds 32 to 128 of them, whatever
// the triangles. They are made only where DenseCells finds edges crowded, and about there: on all surface that a disc
// with its centre in a dense cell may hold.

#include <span>
#include <vector>

#include "renderer/photons/dense_cells.h"
#include "renderer/photons/hash_grid.h"
#include "renderer/photons/kernel.h"

namespace photond {

struct Scene;

class SurfaceSamples {
public:
    /// For discs of at most `radius_m`; dense is where more than `most_edges` of the edges lie within a radius of a
    /// cell. Triangles thinner than `error_m` are left out. The same for any number of threads.
    SurfaceSamples(const Scene& scene, std::span<const BoundaryEdge> edges, float radius_m, float error_m,
                   size_t most_edges);

    /// Whether mass() knows all surface of a disc about p.
    bool cover(const vec3& p, float radius_m) const {
        if (levels_.empty()) return false;
        const size_t level = level_of(radius_m);
        return level < levels_.size() && cells_.dense(level, p);
    }

    struct Mass {
        float mass;        // may be more than 1
        uint32_t samples;  // that were looked at
    };
    /// Sum over the samples nearer to p than the radius, within `thickness_m` of the tangent plane and with normals
    /// within 60 degrees of `normal` or its opposite, of the kernel times the area in that plane. Surfaces seen from
    /// the front and from behind are two layers, of which only the one nearer to p counts, unless both are about
    /// equally near: then they are one sheet of mixed winding. Only where cover() is true.
    Mass mass(const Kernel& kernel, const vec3& p, const vec3& normal, float radius_m, float thickness_m) const;

    /// The most samples of one of the cells, two radii wide, that are kept; mass() looks at eight cells at most. Flat
    /// surface through a cell has 163.
    static constexpr size_t kMostOfCell = 1024;

    size_t size() const;
    uint64_t bytes() const;

private:
    struct Sample {
        vec3 normal;  // unit, by the winding
        float area_m2;
    };
    struct Level {
        HashGrid grid;
        std::vector<Sample> samples;  // in the grid's order
    };
    size_t level_of(float radius_m) const;

    DenseCells cells_;
    std::vector<Level> levels_;
};

}  // namespace photond
