#pragma once
// VplTracer::trace() on a device: the same texels, the same choice, the same paths.

#include <optional>

#include "renderer/backends/gpu/device_scene.h"
#include "renderer/backends/gpu/prefix_sum.h"
#include "renderer/backends/gpu/radix_sort.h"
#include "renderer/many_lights/flux_map_gpu.h"
#include "renderer/many_lights/vpl_tracer.h"
#include "renderer/many_lights/vpl_tracer_shared.h"
#include "renderer/photons/reflected_photon_shared.h"
#include "renderer/photons/texel_map.h"

namespace photond {

/// How light paths find their hits after the first.
struct VplBounceShader {
    /// A shader that defines `Hit bounce_hit(Ray ray)` and includes vpl_paths.glsl; bindings of its own in set 0 start
    /// at VPL_BOUNCE_BINDING (vpl_tracer_shared.h).
    std::string name = "renderer/many_lights/vpl_paths.comp";
    std::vector<gpu::Binding> bindings;  // those
};

/// One pass's lights at a time, without anything read back: the commands of a pass follow one another. Borrows the
/// scene, the emission and the counters (backends/gpu/counters.h), which it adds to.
///
/// Light i of the pass, in VplTracer's order, is photons()[order()[i]]; i below the word REFLECTION_PHOTONS of state().
/// There is room for as many as there can be.
class VplTracerGpu {
public:
    /// `weighted`: importance() is changed between record_map() and record_vpls(), as VplTracer::trace()'s `importance`
    /// does.
    VplTracerGpu(const gpu::DeviceScene& scene, const EmissionSampler& emission, const VplTracing& tracing,
                 gpu::Buffer& counters, bool weighted, VplBounceShader bounces = {});
    /// On the device. `lambert`: every surface is a plain Lambert reflector.
    static uint64_t device_bytes(const VplTracing& tracing, bool weighted, bool lambert, uint64_t lights);

    /// Says which pass is recorded next: a pure function of (scene, settings, seed, pass).
    void start(uint64_t seed, uint32_t pass);
    /// Instead, once: every pass's paths are these, with the numbers of the first pass of that seed
    /// (VplTracer::trace()); there is no map then, and nothing in texels() and importance().
    void start(uint64_t seed, const ChosenPaths& paths);
    /// Traces the texels, stage `rsm`. Leaves texels() and importance(), both in the map's order.
    void record_map(gpu::CommandList& commands);
    /// The rest, stage `vpl_generation`.
    void record_vpls(gpu::CommandList& commands);

    /// Instead of that, where others choose the paths (path_selection_gpu.h): first the sums, ...
    void record_sums(gpu::CommandList& commands);
    /// ... then, as often as is liked, paths to be looked at, `vpls` at most: those of a list from `first` on, in its
    /// order. Of path i, light j is photons()[order()[first_of_path()[i] + j]].
    void record_rated(gpu::CommandList& commands, gpu::Buffer& paths, uint32_t first, uint32_t count);
    /// ... and the pass's, whose number is in state().
    void record_selected(gpu::CommandList& commands, gpu::Buffer& paths);
    /// Where that is, and what record_rated() leaves of order() beside.
    gpu::DeviceWord path_count() { return {state_, REFLECTION_PATHS}; }
    gpu::Buffer& first_of_path() { return path_counts_; }
    /// Of the pass's: photons' PhotonOwner, and where each path that they name is in the list.
    gpu::Buffer& owners() { return owners_; }
    gpu::Buffer& places() { return places_; }
    const TexelMapPass& texel_pass() const { return *pass_; }

    uint32_t most_lights() const { return static_cast<uint32_t>(most_vpls(tracing_.vpls, tracing_.bounces)); }

    gpu::Buffer& photons() { return photons_; }    // ReflectedPhotonRecord
    gpu::Buffer& order() { return order_; }        // uint
    gpu::Buffer& surfaces() { return surfaces_; }  // ReflectingSurfaceRecord, by the photons' `surface`
    gpu::Buffer& state() { return state_; }        // words, REFLECTION_PHOTONS ...

    /// What each texel of the pass's map saw, as a ReflectedPhotonRecord (TexelImportance says what of it counts); its
    /// power is 0 where the texel met nothing.
    gpu::Buffer& texels() { return texels_; }
    uint32_t map_texels() const { return plain_.texels(); }
    /// What each texel is worth [W], a float. Where `weighted`, it may be multiplied by anything not negative.
    gpu::Buffer& importance() { return weighted_ ? weighted_->sums() : plain_.sums(); }
    /// Whose the texels are: each light's TexelRun (texel_map_shared.h), by their first texels.
    gpu::Buffer& runs() { return runs_; }
    uint32_t run_count() const { return run_count_; }

    /// Samples that were no numbers, once the pass has been waited for.
    void add_to(Counts& counts) const;

private:
    void record_paths(gpu::CommandList& commands, gpu::Buffer& paths, uint32_t first, uint32_t count, bool rated);
    void record_traced(gpu::CommandList& commands, uint32_t count, bool rated);
    void record_state_readback(gpu::CommandList& commands);
    FluxMapGpu& chosen_by() { return weighted_ ? *weighted_ : plain_; }

    gpu::Device& device_;
    const VplTracing tracing_;
    gpu::Buffer& counters_;
    TexelMap map_;
    std::optional<TexelMapPass> pass_;
    bool given_ = false;                  // the paths are
    FluxMapGpu plain_;                    // by the texels' flux
    std::optional<FluxMapGpu> weighted_;  // by the importance too
    uint32_t run_count_ = 0;
    gpu::Buffer runs_, texels_, state_, host_state_, photons_, owners_, path_counts_, order_, surfaces_;
    gpu::Buffer chosen_texels_, places_;  // of the paths: a uint each
    gpu::Buffer halton_paths_;            // gpu::VplPath
    gpu::Buffer starts_;                  // gpu::VplStart
    const VplBounceShader bounces_;
    gpu::ComputePipeline trace_texels_, mix_, find_points_, choose_, start_paths_, trace_paths_, sort_;
    gpu::RadixSort sort_paths_;
    gpu::PrefixSum sum_;
};

}  // namespace photond
