#pragma once
// Photons of a pass to come, traced on the host's cores while a device draws those of the pass at hand: the way of
// [McGuire and Luebke 2009], who traced on the cores what the graphics card had emitted.

#include <array>
#include <future>
#include <optional>

#include "renderer/photons/photon_tracer.h"

namespace photond {

class PhotonsAhead {
public:
    explicit PhotonsAhead(uint64_t seed) : seed_(seed) {}
    ~PhotonsAhead() { stop(); }
    PhotonsAhead(const PhotonsAhead&) = delete;
    PhotonsAhead& operator=(const PhotonsAhead&) = delete;

    /// One more map, before the first pass. Borrows all of them, and the guide.
    void add(const Scene& scene, const Intersector& intersector, const EmissionSampler& emission,
             const PhotonTracing& tracing);
    /// Of a map that stores so many photons a pass: those of two passes.
    static uint64_t bytes_for(double stored) { return static_cast<uint64_t>(2.2 * stored) * sizeof(Photon); }

    /// What they take now, once a pass has arrived: the next one takes about as much again.
    uint64_t bytes() const;

    /// Begins the pass's photons beside what the caller goes on with. What is under way for another pass is given up.
    void begin(uint32_t pass);
    /// Whether the pass's photons are here; does not wait.
    bool arrived(uint32_t pass);
    /// Until they are, begun now if they were not. False: cancelled.
    bool wait(uint32_t pass, const CancelToken& cancel);
    /// Gives up what is under way, at once or nearly so.
    void stop();

    /// Of the pass that arrived last.
    const TracedPhotons& photons(PhotonMapKind kind) const { return here_->of_map[static_cast<size_t>(kind)]; }

private:
    static constexpr size_t kMaps = 2;  // PhotonMapKind
    struct Pass {
        uint32_t index = 0;
        std::array<TracedPhotons, kMaps> of_map;
    };

    const uint64_t seed_;
    std::array<std::optional<PhotonTracer>, kMaps> tracers_;
    std::optional<Pass> here_;
    std::optional<uint32_t> begun_;  // the pass that is under way
    std::optional<CancelToken> given_up_;
    std::future<Pass> under_way_;
};

}  // namespace photond
