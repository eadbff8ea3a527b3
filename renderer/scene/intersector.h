#pragma once
// The one ray interface. Behind it stands Embree (backends/cpu) or, later, another structure; nothing else in the
// renderer knows which.

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "renderer/core/geometry.h"
#include "renderer/core/memory_budget.h"

namespace photond {

struct Scene;

inline constexpr uint32_t kNoHit = ~0u;

/// Where a ray met a triangle. Barycentrics: p = (1-u-v) p0 + u p1 + v p2.
struct Hit {
    float t = kInfinity;
    uint32_t instance = kNoHit;
    uint32_t triangle = 0;
    float u = 0;
    float v = 0;

    bool valid() const { return instance != kNoHit; }
};

/// How alike the rays of a batch are; a hint for speed, never for the answer.
enum class Coherence : uint8_t { Coherent, Incoherent };

/// Closest hits of a batch that was begun. Its going waits.
class HitsToCome {
public:
    virtual ~HitsToCome() = default;
    /// Waits for them; asked once.
    virtual std::vector<Hit> take() = 0;
};

/// Closest hit and occlusion against one scene. Masked texels are no surface; blended surfaces are hit or passed with
/// their alpha as probability, decided by a hash of the ray and the triangle (so the answer is a pure function of the
/// ray). Surfaces are hit from both sides. Thread-safe.
class Intersector {
public:
    virtual ~Intersector() = default;

    /// The nearest hit with 0 < t < ray.t_max.
    virtual Hit closest_hit(const Ray& ray) const = 0;
    /// Whether anything opaque lies in (0, ray.t_max).
    virtual bool occluded(const Ray& ray) const = 0;

    /// Batches: hits[i] answers rays[i]; occluded[i] is 1 or 0. A ray with t_max <= 0 is not traced: no hit, not
    /// occluded.
    virtual void closest_hits(std::span<const Ray> rays, std::span<Hit> hits, Coherence coherence) const = 0;
    virtual void occluded(std::span<const Ray> rays, std::span<uint8_t> occluded, Coherence coherence) const = 0;

    /// closest_hits(), begun: where another device traces, the caller goes on meanwhile. All threads work on it
    /// otherwise. It may not outlive the intersector, nor may the scene move before it is gone.
    virtual std::unique_ptr<HitsToCome> begin_closest_hits(std::vector<Ray> rays, Coherence coherence) const;

    virtual uint64_t bytes() const = 0;
};

}  // namespace photond
