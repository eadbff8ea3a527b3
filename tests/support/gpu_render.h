#pragma once
// Renders with any method of the GPU from within a test.

#include <gtest/gtest.h>

#include <cctype>
#include <string>

#include "renderer/backends/gpu/device_intersector.h"
#include "tests/support/gpu_twin.h"
#include "tests/support/render.h"

namespace photond::test {

/// A scene on the tests' device.
struct SceneOnDevice {
    explicit SceneOnDevice(const Scene& host_scene)
        : scene(host_scene), device_scene(gpu_device(), host_scene), intersector(device_scene) {}

    const Scene& scene;
    const gpu::DeviceScene device_scene;
    const gpu::DeviceIntersector intersector;

    /// For a method that traces on the host too; else null.
    template <class M>
    const Intersector* host_intersector(const typename M::Params& params) const {
        if constexpr (requires { M::traces_on_host(params); }) {
            MemoryBudget budget;
            Stats stats;
            if (M::traces_on_host(params) && !host_intersector_)
                host_intersector_ = make_embree_intersector(scene, budget, stats);
            return host_intersector_.get();
        }
        return nullptr;
    }

private:
    mutable std::unique_ptr<Intersector> host_intersector_;
};

/// run_passes() of render.h, there.
template <class M, class AfterPass>
void run_passes(const SceneOnDevice& where, const RenderSettingsOf<M>& settings, const AfterPass& after_pass,
                Stats* stats = nullptr) {
    MemoryBudget budget;
    Stats own_stats;
    const RenderContext context{where.scene,
                                &where.intersector,
                                view_of(where.scene, settings),
                                settings.seed,
                                budget,
                                &where.device_scene,
                                where.host_intersector<M>(settings.params)};
    run_passes_in(
        context, settings,
        [&](M& method, uint32_t pass) {
            method.expect_pass(pass + 1);  // as a job does; the last one comes to nothing
            after_pass(method, pass);
        },
        stats ? *stats : own_stats);
}

/// render() of render.h, there.
template <class M>
Film render(const SceneOnDevice& where, const RenderSettingsOf<M>& settings, Stats* stats = nullptr) {
    Film film(settings.size, settings.layers, settings.first_pass);
    run_passes(
        where, settings, [&](M& method, uint32_t) { method.resolve(film); }, stats);
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

/// Share of values that differ by more than `tolerance` of the layer's mean.
inline double share_apart(const std::vector<float>& a, const std::vector<float>& b, double tolerance) {
    const double mean = mean_of(a);
    size_t apart = 0;
    for (size_t i = 0; i < a.size(); ++i) apart += std::fabs(a[i] - b[i]) > tolerance * std::fabs(mean);
    return double(apart) / double(a.size());
}

/// What begin() takes of the device's memory is what the method says beforehand, to a factor of 1.5.
template <class M>
void expect_device_bytes_as_estimated(const SceneOnDevice& where, const RenderSettingsOf<M>& settings) {
    const uint64_t before = gpu_device().memory().used_bytes();
    MemoryBudget budget;
    Stats stats;
    M method(settings.params);
    method.begin({where.scene, &where.intersector, view_of(where.scene, settings), settings.seed, budget,
                  &where.device_scene, where.host_intersector<M>(settings.params)},
                 stats);
    const Workload workload = workload_of(where.scene, settings);
    const auto estimate = static_cast<double>(M::estimate_device_bytes(settings.params, workload));
    const auto taken = static_cast<double>(gpu_device().memory().used_bytes() - before);
    EXPECT_LE(taken, 1.5 * estimate);
    EXPECT_GE(1.5 * taken, estimate);
}

}  // namespace photond::test
