#pragma once
// Renders with any method of the GPU from within a test, and holds its images against the CPU's.

#include <cctype>
#include <string>

#include "renderer/backends/gpu/device_intersector.h"
#include "tests/support/gpu_twin.h"
#include "tests/support/render.h"
#include "tests/support/statistics.h"

namespace photond::test {

/// A scene on the tests' device.
struct SceneOnDevice {
    explicit SceneOnDevice(const Scene& host_scene)
        : scene(host_scene), device_scene(gpu_device(), host_scene), intersector(device_scene) {}

    const Scene& scene;
    const gpu::DeviceScene device_scene;
    const gpu::DeviceIntersector intersector;
};

/// render() of render.h, there.
template <class M>
Film render(const SceneOnDevice& where, const RenderSettingsOf<M>& settings, Stats* stats = nullptr) {
    MemoryBudget budget;
    Stats own_stats;
    const RenderContext context{where.scene, &where.intersector, view_of(where.scene, settings), settings.seed,
                                budget,      &where.device_scene};
    Film film(settings.size, settings.layers, settings.first_pass);
    run_passes_in(
        context, settings,
        [&](M& method, uint32_t pass) {
            method.expect_pass(pass + 1);  // as a job does; the last one comes to nothing
            method.resolve(film);
        },
        stats ? *stats : own_stats);
    return film;
}

/// A parameterised test's name that does not change from build to build: "cornell_box_3", the scene and the parameter's
/// place.
inline std::string test_name(std::string scene, size_t place) {
    for (char& c : scene)
        if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
    return scene + "_" + std::to_string(place);
}

/// Mean of |a - b| over the mean of a.
inline double mean_relative_difference(const std::vector<float>& a, const std::vector<float>& b) {
    double difference = 0, sum = 0;
    for (size_t i = 0; i < a.size(); ++i) difference += std::fabs(double{a[i]} - double{b[i]}), sum += std::fabs(a[i]);
    return sum > 0 ? difference / sum : difference;
}

/// Two films whose samples are drawn independently, or by the same numbers: blocks of `side` x `side` pixels of their
/// beauty whose means differ by more than their passes' variance explains, at a false-alarm rate of 1e-6 over all
/// blocks (Sidak), as text; empty: none. A block's means over the passes are taken as normal: ask for 16 passes or
/// more.
inline std::string blocks_that_differ(const Film& a, const Film& b, uint32_t side) {
    const Size2 size = a.size();
    const std::vector<float> image_a = a.resolve_beauty(), image_b = b.resolve_beauty();
    const std::vector<float> variance_a = a.pass_variance_beauty(), variance_b = b.pass_variance_beauty();
    const uint32_t columns = size.width / side, rows = size.height / side;
    const double z_limit = two_sided_z(share_of_false_alarm(1e-6, size_t{columns} * rows * 3));
    std::string differing;
    for (uint32_t block = 0; block < columns * rows; ++block) {
        for (uint32_t c = 0; c < 3; ++c) {
            double difference = 0, variance = 0, sum = 0;
            for (uint32_t i = 0; i < side * side; ++i) {
                const uint32_t x = block % columns * side + i % side, y = block / columns * side + i / side;
                const size_t at = 3 * (size_t{y} * size.width + x) + c;
                difference += double{image_a[at]} - double{image_b[at]};
                sum += image_a[at];
                variance += double{variance_a[at]} / a.passes() + double{variance_b[at]} / b.passes();
            }
            // Rounding: 1e-5 of the sum, where passes do not vary at all.
            if (std::fabs(difference) > z_limit * std::sqrt(variance) + 1e-5 * sum)
                differing += "block " + std::to_string(block) + ", channel " + std::to_string(c) + ": " +
                             std::to_string(difference) + " of " + std::to_string(sum) + ", standard error " +
                             std::to_string(std::sqrt(variance)) + "\n";
        }
    }
    return differing;
}

}  // namespace photond::test
