#pragma once
// The one ray interface, answered by a device: for the little that is worked out on the host while a scene is on a GPU
// (projection maps, pilots). Methods on the GPU trace rays in their own shaders.

#include <mutex>

#include "renderer/backends/gpu/device_scene.h"
#include "renderer/scene/intersector.h"

namespace photond::gpu {

/// Batches make a way to the device and back each: ask for many rays at once. One batch runs at a time. Borrows the
/// scene.
class DeviceIntersector final : public Intersector {
public:
    explicit DeviceIntersector(const DeviceScene& scene);
    ~DeviceIntersector() override;

    Hit closest_hit(const Ray& ray) const override;
    bool occluded(const Ray& ray) const override;
    void closest_hits(std::span<const Ray> rays, std::span<Hit> hits, Coherence coherence) const override;
    void occluded(std::span<const Ray> rays, std::span<uint8_t> occluded, Coherence coherence) const override;
    /// Submits them, before whatever is submitted next. Takes 48 bytes of the device's memory a ray until they are
    /// taken.
    std::unique_ptr<HitsToCome> begin_closest_hits(std::vector<Ray> rays, Coherence coherence) const override;

    /// Its buffers, once there are any; the rays' structure is the scene's.
    uint64_t bytes() const override;
    /// What they take of the device's memory.
    static uint64_t batch_bytes();

private:
    struct Batch;
    class HitsUnderWay;

    Batch& batch() const;
    void trace(std::span<const Ray> rays, bool any) const;

    const DeviceScene& scene_;
    mutable std::mutex mutex_;
    mutable std::unique_ptr<Batch> batch_;  // made when first asked for a ray: most methods never do
};

}  // namespace photond::gpu
