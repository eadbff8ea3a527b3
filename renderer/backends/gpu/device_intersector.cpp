#include "renderer/backends/gpu/device_intersector.h"

#include <algorithm>
#include <cstring>
#include <deque>

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

/// A submission for each kMostRays, so that whoever waits for the device's other work is not kept by all of them.
class DeviceIntersector::HitsUnderWay final : public HitsToCome {
public:
    HitsUnderWay(const DeviceScene& scene, const ComputePipeline& closest, std::span<const Ray> rays)
        : count_(rays.size()),
          rays_(scene.device(), "ray_batches", std::max<uint64_t>(rays.size_bytes(), sizeof(Ray)), MemoryKind::Upload),
          hits_(scene.device(), "ray_batches", std::max<uint64_t>(count_ * sizeof(Hit), sizeof(Hit)),
                MemoryKind::Readback) {
        if (!rays.empty()) std::memcpy(rays_.mapped(), rays.data(), rays.size_bytes());
        for (size_t first = 0; first < count_; first += kMostRays) {
            const size_t count = std::min(kMostRays, count_ - first);
            Binding from = read("rays", rays_), to = write("hits", hits_);
            from.offset = first * sizeof(Ray), from.bytes = count * sizeof(Ray);
            to.offset = first * sizeof(Hit), to.bytes = count * sizeof(Hit);
            CommandList& commands = lists_.emplace_back(scene.device());
            commands.bind(closest, {from, to});
            commands.push(TraceRaysPush{static_cast<uint32_t>(count)});
            commands.dispatch_threads(count, TRACE_RAYS_GROUP);
            commands.host_reads(hits_);
            commands.submit();
        }
    }

    std::vector<Hit> take() override {
        for (CommandList& commands : lists_) commands.wait();
        const std::span<const Hit> hits = hits_.as<const Hit>().first(count_);
        return {hits.begin(), hits.end()};
    }

private:
    static_assert(kMostRays * sizeof(Ray) % 256 == 0 && kMostRays * sizeof(Hit) % 256 == 0, "as bindings ask");

    const size_t count_;
    Buffer rays_, hits_;
    std::deque<CommandList> lists_;  // last: their going waits for work that uses the others
};

DeviceIntersector::DeviceIntersector(const DeviceScene& scene) : scene_(scene) {}
DeviceIntersector::~DeviceIntersector() = default;

/// Under the mutex.
DeviceIntersector::Batch& DeviceIntersector::batch() const {
    if (!batch_) batch_ = std::make_unique<Batch>(scene_);
    return *batch_;
}

/// Traces at most kMostRays; the answers are in batch_->hits.
void DeviceIntersector::trace(std::span<const Ray> rays, bool any) const {
    Batch& batch = this->batch();
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

std::unique_ptr<HitsToCome> DeviceIntersector::begin_closest_hits(std::vector<Ray> rays, Coherence) const {
    const std::scoped_lock lock(mutex_);
    return std::make_unique<HitsUnderWay>(scene_, batch().closest, rays);
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
