#pragma once
// The two passes of methods that gather light from photon maps: photons from the lights into maps, and the image as the
// eye sees it. What becomes of the ends of gather rays is the method's own (RayEndLookups).

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "renderer/core/thread_local.h"
#include "renderer/frame/method_info.h"
#include "renderer/gathering/eye_pass.h"
#include "renderer/gathering/photon_plan.h"
#include "renderer/photons/photon_guides.h"
#include "renderer/photons/photon_tracer.h"

namespace photond {

/// The artefact that `keep_photon_map` leaves.
inline constexpr const char* kPhotonMapFile = "photon_map.glb";

class PhotonGathering {
public:
    /// Builds what the passes share. `params` and what `context` borrows are borrowed.
    PhotonGathering(const RenderContext& context, const GatheringParams& params, Stats& stats);
    /// What the constructor and the passes will record, to a few percent: most of it are the photons.
    static uint64_t estimate_bytes(const GatheringParams& params, const Workload& workload);

    /// Pass 1: the maps. Cancelled: they are empty.
    void trace_photons(uint32_t pass, Stats& stats, const CancelToken& cancel);
    /// Pass 2: the image. `ends_of_thread` is what the calling thread does with the ends of gather rays; `finish_ends`,
    /// unless empty, is called when all tiles are traced, and says how many processor seconds it took.
    void look_from_eye(uint32_t pass, const std::function<RayEndLookups&()>& ends_of_thread,
                       const std::function<double()>& finish_ends, Stats& stats, const CancelToken& cancel);
    /// As Method::end_pass(). With `keep_photon_map` the pass's maps are kept.
    PassImage* end_pass();
    /// With `keep_photon_map`: the photons of the last whole pass.
    std::vector<MethodArtefact> artefacts() const;

    const GatheringScene& shared() const { return shared_; }
    const PassMaps& maps() const { return maps_; }
    PassImage& image() { return image_; }
    /// A structure of this pass: what is reported is the greatest of all passes.
    void record(const std::string& structure, uint64_t bytes);

private:
    struct PerThread {
        EyePass eye;
        Counts counts;
        EyeSeconds seconds;
    };

    PhotonTracing tracing(PhotonMapKind kind, uint32_t photons, uint32_t most_scatterings) const;
    void note_skipped(Stats& stats) const;
    PhotonMap make_map(const std::optional<PhotonTracer>& tracer, const std::string& structure, uint32_t nearest,
                       uint32_t pass, Stats& stats, const CancelToken& cancel);

    const GatheringScene shared_;
    const GatheringParams& params_;
    MemoryBudget& budget_;
    PhotonPlan plan_{params_, 0, false, false};
    std::optional<EmissionSampler> emission_;
    PhotonGuides guides_;
    std::optional<PhotonTracer> global_tracer_, caustic_tracer_;
    ThreadLocal<PerThread> threads_;
    std::map<std::string, uint64_t> most_bytes_;

    PassMaps maps_;  // of the pass
    PassImage image_;
    bool pass_complete_ = false;  // image_ holds a whole pass
    PhotonMap kept_global_, kept_caustic_;
};

/// What estimates are made of, of a scene that is there.
Workload workload_of(const RenderContext& context);

/// Which known answers (scene/hard_cases.h) their estimates miss.
std::vector<KnownLimit> limits_of_density_estimates();

/// About the bytes of the file of the photons that keeping maps of so many bytes adds to the memory.
uint64_t photon_map_file_bytes(uint64_t map_bytes);
/// The same of a method, by what it says of its memory.
template <class M>
uint64_t photon_map_file_bytes_of(const MethodParams& params, const Workload& workload) {
    typename M::Params kept = dynamic_cast<const typename M::Params&>(params);
    if (!kept.keep_photon_map) return 0;
    typename M::Params thrown_away = kept;
    thrown_away.keep_photon_map = false;
    return photon_map_file_bytes(M::estimate_bytes(kept, workload) - M::estimate_bytes(thrown_away, workload));
}

}  // namespace photond
