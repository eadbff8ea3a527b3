#include "renderer/gbuffer/geometry_filter.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <vector>

#include "renderer/core/lanes.h"
#include "renderer/core/parallel.h"

namespace photond {

namespace {

using std::experimental::element_aligned;

bool is_filtered(const gpu::GBufferPoint& point) {
    return (point.kind & (GBUFFER_POINT | GBUFFER_GENERAL)) == GBUFFER_POINT;
}

constexpr size_t kRowGrain = 4;
constexpr int kMostWidth = 32;
/// Columns before the first and after the last that may be read: half a window, and lanes past the row's end.
constexpr size_t kMargin = kMostWidth / 2 + kLanes;
constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();  // compares false with any place

/// A number a pixel, row by row, and margins.
class Numbers {
public:
    Numbers(Size2 size, float margin) : stride_(size.width + 2 * kMargin), values_(stride_ * size.height, margin) {}

    float& at(size_t x, size_t y) { return values_[y * stride_ + kMargin + x]; }
    /// Pixels from column x >= -kMostWidth / 2 on.
    FloatLanes load(ptrdiff_t x, size_t y) const {
        return {values_.data() + ptrdiff_t(y * stride_ + kMargin) + x, element_aligned};
    }

private:
    size_t stride_;
    std::vector<float> values_;
};

struct Vectors {
    Vectors(Size2 size, float margin) : x(size, margin), y(size, margin), z(size, margin) {}

    void set(size_t column, size_t row, const vec3& v) {
        x.at(column, row) = v.x, y.at(column, row) = v.y, z.at(column, row) = v.z;
    }
    Vec3Lanes load(ptrdiff_t column, size_t row) const {
        return {x.load(column, row), y.load(column, row), z.load(column, row)};
    }

    Numbers x, y, z;
};

/// Lambert points in the image's order; what is none lies nowhere.
struct Image {
    explicit Image(Size2 size)
        : position(size, kNowhere), normal(size, 0), plane(size, 0), irradiance(size, 0), most_m(size, 0) {}

    void set(size_t x, size_t y, const gpu::GBufferPoint& point, const vec3& arriving, float distance_relative) {
        if (!is_filtered(point)) return;
        position.set(x, y, point.position);
        normal.set(x, y, point.normal);
        plane.set(x, y, point.geometric_normal);
        irradiance.set(x, y, arriving);
        most_m.at(x, y) = distance_relative * point.depth_m;
    }

    Vectors position, normal, plane, irradiance;
    Numbers most_m;
};

/// Means of as many pixels of a row as there are lanes, from column x on.
Vec3Lanes filter_lanes(const Image& image, Size2 size, const GeometryFilter& settings, size_t x, size_t y) {
    const auto width = static_cast<ptrdiff_t>(settings.width), column = static_cast<ptrdiff_t>(x);
    const auto before = static_cast<ptrdiff_t>(y) - width / 2;
    const auto first_row = static_cast<size_t>(std::max<ptrdiff_t>(before, 0)),
               end_row = std::min(static_cast<size_t>(before + width), size_t{size.height});
    const Vec3Lanes position = image.position.load(column, y), normal = image.normal.load(column, y),
                    plane = image.plane.load(column, y);
    const FloatLanes most_m = image.most_m.load(column, y);
    Vec3Lanes sum = image.irradiance.load(column, y);
    FloatLanes count = 1;
    for (size_t row = first_row; row < end_row; ++row) {
        for (ptrdiff_t k = -(width / 2); k < width - width / 2; ++k) {
            if (k == 0 && row == y) continue;
            const Vec3Lanes apart = image.position.load(column + k, row) - position;
            const FloatMask same = dot(normal, image.normal.load(column + k, row)) >= settings.normal_cosine &&
                                   abs(dot(plane, apart)) <= most_m;
            const Vec3Lanes arriving = image.irradiance.load(column + k, row);
            where(same, sum.x) += arriving.x, where(same, sum.y) += arriving.y, where(same, sum.z) += arriving.z;
            where(same, count) += 1;
        }
    }
    return (1 / count) * sum;
}

}  // namespace

void filter_geometry_aware(const SplitLayout& layout, std::span<const gpu::GBufferPoint> points,
                           std::span<const vec3> irradiance, const GeometryFilter& settings, std::span<vec3> filtered) {
    assert(points.size() == layout.points() && irradiance.size() == points.size() && filtered.size() == points.size() &&
           "one element a place of the split buffer");
    assert(settings.width >= 1 && settings.width <= kMostWidth);
    const Size2 size = layout.size;
    Image image(size);
    parallel_for(size.height, kRowGrain, [&](size_t y) {
        for (size_t x = 0; x < size.width; ++x) {
            const uint32_t point = layout.point_of(static_cast<uint32_t>(x), static_cast<uint32_t>(y));
            image.set(x, y, points[point], irradiance[point], settings.distance_relative);
        }
    });
    std::copy(irradiance.begin(), irradiance.end(), filtered.begin());
    parallel_for(size.height, kRowGrain, [&](size_t y) {
        std::array<std::array<float, kLanes>, 3> means;
        for (size_t x = 0; x < size.width; x += kLanes) {
            const Vec3Lanes mean = filter_lanes(image, size, settings, x, y);
            mean.x.copy_to(means[0].data(), element_aligned);
            mean.y.copy_to(means[1].data(), element_aligned);
            mean.z.copy_to(means[2].data(), element_aligned);
            for (size_t lane = 0; lane < std::min(kLanes, size.width - x); ++lane) {
                const uint32_t point = layout.point_of(static_cast<uint32_t>(x + lane), static_cast<uint32_t>(y));
                if (is_filtered(points[point])) filtered[point] = {means[0][lane], means[1][lane], means[2][lane]};
            }
        }
    });
}

}  // namespace photond
