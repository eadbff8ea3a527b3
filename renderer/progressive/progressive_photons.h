#pragma once
// The light's side of progressive photon mapping: which photons a scene needs, and the maps of each pass.

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "renderer/frame/render_context.h"
#include "renderer/photons/photon_map.h"
#include "renderer/photons/photon_tracer.h"
#include "renderer/progressive/progressive_params.h"

namespace photond {

/// The two maps of a pass (photon_tracer.h).
inline constexpr std::array<PhotonMapKind, 2> kPhotonMapKinds{PhotonMapKind::Global, PhotonMapKind::Caustic};
template <class T>
using PerMap = std::array<T, kPhotonMapKinds.size()>;
constexpr size_t index_of(PhotonMapKind kind) { return static_cast<size_t>(kind); }
constexpr std::string_view name_of(PhotonMapKind kind) { return kind == PhotonMapKind::Global ? "global" : "caustic"; }

/// Borrows the context's scene and intersector.
class ProgressivePhotons {
public:
    /// Finds what the scene needs and traces the projection map's pilot: stage `photon_emission`. What is not needed
    /// stands among what was skipped.
    ProgressivePhotons(const RenderContext& context, const ProgressiveParams& params, Stats& stats);
    ~ProgressivePhotons();

    bool wanted(PhotonMapKind kind) const { return tracers_[index_of(kind)] != nullptr; }
    bool any() const { return wanted(PhotonMapKind::Global) || wanted(PhotonMapKind::Caustic); }
    uint32_t paths(PhotonMapKind kind) const { return paths(kind, params_); }
    static uint32_t paths(PhotonMapKind kind, const ProgressiveParams& params) {
        return kind == PhotonMapKind::Global ? params.photons : params.caustic_photons.value_or(params.photons);
    }
    /// As the passes' photons of that kind, which is wanted, are traced; its guide is kept here.
    PhotonTracing tracing(PhotonMapKind kind) const;
    uint64_t pilot_seed() const;

    /// One pass's map: a pure function of (scene, parameters, seed, pass). Stages `photon_tracing` and
    /// `photon_map_build`; its bytes go to the budget. Empty where it is not wanted, or cancelled.
    PhotonMap trace(PhotonMapKind kind, uint32_t pass, const PhotonSearch& search, Stats& stats,
                    const CancelToken& cancel);
    /// So many passes' photons that no pass has: a pure function of the seed. In the same stages.
    std::vector<Photon> trace_pilot(PhotonMapKind kind, uint32_t passes, Stats& stats) const;

    /// Of what stands before the first pass: the emission, its guide, and room to trace in.
    static uint64_t estimate_emission_bytes(const ProgressiveParams& params, const Workload& workload);
    /// Of all that these record, at most.
    static uint64_t estimate_bytes(const ProgressiveParams& params, const Workload& workload);
    /// Photons that a pass stores, as far as that is known.
    static uint64_t expected_photons(PhotonMapKind kind, const ProgressiveParams& params, const Workload& workload);

private:
    struct Emission;

    const RenderContext context_;
    const ProgressiveParams& params_;
    std::unique_ptr<Emission> emission_;
    PerMap<std::unique_ptr<const PhotonTracer>> tracers_;
    PerMap<uint64_t> most_bytes_{};
    uint64_t most_build_bytes_ = 0;
};

}  // namespace photond
