#pragma once
// A scene on a device, and a method under way there with a job's clock.

#include <filesystem>
#include <map>
#include <memory>

#include "renderer/backends/gpu/device_intersector.h"
#include "renderer/error/error_meter.h"
#include "renderer/frame/method.h"
#include "renderer/scene/scene.h"
#include "tests/benchmarks/gpu_bench/bench_list.h"

namespace photond::bench {

/// Path-traced images that errors are measured against, by layer.
struct Reference {
    std::map<std::string, std::unique_ptr<ErrorMeter>> meters;  // beauty, direct, indirect
    /// The relative_mse of its own noise to be expected, from the variance between its passes as if these were
    /// independent: too large for low-discrepancy ones.
    std::map<std::string, std::optional<double>> own_relative_mse;
    double seconds = 0;

    /// Throws ErrorCode::UnknownName for another layer.
    const ErrorMeter& meter(const std::string& layer) const;
};

/// A scene where it is rendered: on the host, on the device, or both; and what it was seen to look like.
class Place {
public:
    /// `device`: null where there is no GPU. A `scene` that ends with .baked is a file of `folder`.
    Place(const std::string& scene, const std::filesystem::path& folder, gpu::Device* device);

    /// What a method's begin() is given.
    RenderContext context(bool on_gpu, const Rendering& rendering, uint64_t seed);
    /// Made once, on the GPU where there is one, with random numbers of its own.
    const Reference& reference(const Rendering& view, const ReferenceWanted& wanted);

    const Scene& scene() const { return scene_; }
    gpu::Device* device() { return device_; }
    const gpu::DeviceScene& device_scene();
    const Stats& load() const { return load_; }

private:
    const Scene scene_;
    gpu::Device* const device_;
    Stats load_;
    MemoryBudget budget_;
    std::optional<gpu::DeviceScene> device_scene_;
    std::optional<gpu::DeviceIntersector> device_rays_;
    std::unique_ptr<Intersector> host_rays_;
    std::map<std::string, Reference> references_;
};

class Run {
public:
    Run(const Rendering& rendering, Place& place, bool on_gpu, uint64_t seed = 1);

    /// Passes and what folds them into the film are on the clock, nothing else.
    void pass(bool more_follow);
    /// A pass that nothing is done beside: wall seconds until its image is on the host.
    double pass_alone();
    /// Before something that is off the clock.
    void settle();
    /// An empty film, for the passes that follow.
    void begin_film();
    std::vector<float> image(const std::string& layer) const;

private:
    std::unique_ptr<Method> method_;

public:
    Film film;
    Stats stats;
    double begin_seconds = 0, seconds = 0;
};

}  // namespace photond::bench
