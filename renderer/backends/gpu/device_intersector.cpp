#include "renderer/backends/gpu/device_intersector.h"

#include <algorithm>
#include <cstring>

#include "renderer/backends/gpu/command_list.h"
#include "renderer/backends/gpu/trace_rays_shared.h"

namespace photond::gpu {

namespace {

constexpr std::string_view kShader = "renderer/backends/gpu/trace_rays.comp";
constexpr size_t kMostRays = 1u << 16;  // of a batch on the device
// The shader's structures, scalar layout.
static_assert(sizeof(Ray) == 28 && sizeof(Hit) == 20);

std::vector<Specialization> with_any(const DeviceScene& scene, bool any) {
    const Specialization mine = specialize(TRACE_RAYS_ANY_ID, any);
    return scene.specialization({&mine, 1});
}

}  // namespace

struct DeviceIntersector::Batch {
    explicit Batch(const DeviceScene& scene)
        : closest(scene.device(), kShader, sizeof(TraceRaysPush), &scene.set(), with_any(scene, false)),
          any(scene.device(), kShader, sizeof(TraceRaysPush), &scene.set(), with_any(scene, true)),
          rays(scene.device(), "ray_batches", kMostRays * sizeof(Ray), MemoryKind::Upload),
          hits(scene.device(), "ray_batches", kMostRays * sizeof(Hit), MemoryKind::Readback),
          commands(scene.device()) {}

    const ComputePipeline closest, any;
    Buffer rays, hits;
    CommandList commands;
};

DeviceIntersector::DeviceIntersector(const DeviceScene& scene) : scene_(scene) {}
DeviceIntersector::~DeviceIntersector() = default;

/// Traces at most kMostRays; the answers are in batch_->hits.
void DeviceIntersector::trace(std::span<const Ray> rays, bool any) const {
    if (!batch_) batch_ = std::make_unique<Batch>(scene_);
    Batch& batch = *batch_;
    std::memcpy(batch.rays.mapped(), rays.data(), rays.size_bytes());
    batch.commands.reset();
    batch.commands.bind(any ? batch.any : batch.closest, {read("rays", batch.rays), write("hits", batch.hits)});
    batch.commands.push(TraceRaysPush{static_cast<uint32_t>(rays.size())});
    batch.commands.dispatch_threads(rays.size(), TRACE_RAYS_GROUP);
    batch.commands.host_reads(batch.hits);
    batch.commands.submit();
    batch.commands.wait();
}

void DeviceIntersector::closest_hits(std::span<const Ray> rays, std::span<Hit> hits, Coherence) const {
    const std::scoped_lock lock(mutex_);
    for (size_t first = 0; first < rays.size(); first += kMostRays) {
        const size_t count = std::min(kMostRays, rays.size() - first);
        trace(rays.subspan(first, count), false);
        std::memcpy(hits.data() + first, batch_->hits.mapped(), count * sizeof(Hit));
    }
}

void DeviceIntersector::occluded(std::span<const Ray> rays, std::span<uint8_t> occluded, Coherence) const {
    const std::scoped_lock lock(mutex_);
    for (size_t first = 0; first < rays.size(); first += kMostRays) {
        const size_t count = std::min(kMostRays, rays.size() - first);
        trace(rays.subspan(first, count), true);
        const std::span<const Hit> answers = batch_->hits.as<const Hit>();
        for (size_t i = 0; i < count; ++i) occluded[first + i] = answers[i].valid() ? 1 : 0;
    }
}

Hit DeviceIntersector::closest_hit(const Ray& ray) const {
    Hit hit;
    closest_hits({&ray, 1}, {&hit, 1}, Coherence::Incoherent);
    return hit;
}

bool DeviceIntersector::occluded(const Ray& ray) const {
    uint8_t met = 0;
    occluded({&ray, 1}, {&met, 1}, Coherence::Incoherent);
    return met != 0;
}

uint64_t DeviceIntersector::bytes() const {
    const std::scoped_lock lock(mutex_);
    return batch_ ? batch_->rays.bytes() + batch_->hits.bytes() : 0;
}

uint64_t DeviceIntersector::batch_bytes() { return kMostRays * (sizeof(Ray) + sizeof(Hit)); }

}  // namespace photond::gpu
