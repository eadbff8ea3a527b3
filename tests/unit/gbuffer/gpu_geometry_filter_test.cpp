// The geometry-aware filter on the device against the host's.

#include <gtest/gtest.h>

#include "renderer/gbuffer/geometry_filter.h"
#include "renderer/gbuffer/split_shared.h"
#include "tests/support/gbuffer_parts.h"
#include "tests/support/gpu_twin.h"

namespace photond::gpu_geometry_filter_test {
namespace {

struct Settings {
    gpu::SplitRecord split;
    GeometryFilter filter;
};

// Sums are of up to 289 terms in one order; a neighbour within rounding of a limit may count on one side alone, which
// changes a mean of few neighbours a lot: such pixels are few.
TEST(GpuGeometryFilter, IsTheHosts) {
    for (const uint32_t side : {1u, 3u, 4u}) {
        for (const uint32_t width : {1u, 4u, 8u, 17u}) {
            const test::SplitImage image = test::rough_image({67, 41}, side, side + width);
            const Settings settings{gpu::device_record(image.layout), {width, 0.93f, 0.02f}};
            std::vector<vec3> expected(image.points.size());
            filter_geometry_aware(image.layout, image.points, image.irradiance, settings.filter, expected);
            const std::vector<vec3> filtered = test::run_twin<vec3>(
                "tests/gpu/geometry_filter.comp", image.points.size(),
                {{"settings", std::span(&settings, 1)}, {"points", image.points}, {"sums", image.irradiance}});
            size_t apart = 0;
            for (size_t i = 0; i < filtered.size(); ++i)
                apart += glm::length(filtered[i] - expected[i]) > 1e-5f ? 1 : 0;
            EXPECT_LE(apart, filtered.size() / 1000) << side << " a side, " << width << " across";
        }
    }
}

}  // namespace
}  // namespace photond::gpu_geometry_filter_test
