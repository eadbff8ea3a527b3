#pragma once
// The light's sub-paths of a pass on a device: the same paths with the same numbers as LightPathTracer's, their
// vertices in its order, and what the camera sees of them.

#include "renderer/bidirectional/bidirectional_plan.h"
#include "renderer/bidirectional/bidirectional_shared.h"
#include "renderer/frame/device_image.h"
#include "renderer/photons/hash_grid_gpu.h"

namespace photond {

class LightPathsGpu {
public:
    /// By a plan that has light paths; its edges are read here. `constants`: the scene's and the image's. Borrows the
    /// scene.
    LightPathsGpu(const gpu::DeviceScene& scene, const BidirectionalPlan& plan, SamplerKind sampler, uint64_t seed,
                  Size2 film_size, std::span<const gpu::Specialization> constants);
    static uint64_t device_bytes(uint32_t paths, double vertices_per_path, bool merges, bool own_path, Size2 film_size);

    /// What the pass's paths and all that are joined with them go by. Its paths come in that many pieces, 0 ...
    uint32_t begin_pass(uint32_t pass, const PassTechniques& techniques);
    /// Before the pass's first piece.
    void record_start(gpu::CommandList& commands);
    void record_paths(gpu::CommandList& commands, gpu::Buffer& eye, uint32_t piece);
    /// After the last one: vertices and what is seen of them are brought into their order.
    void record_order(gpu::CommandList& commands);
    /// Adds what the camera sees of them.
    void record_image(gpu::CommandList& commands, DeviceImage& image, gpu::Buffer& eye);

    /// Of a whole pass: true where there was too little room for its vertices. Now there is.
    bool grow_if_short();
    /// Adds what a whole pass did.
    void add_to(Counts& counts) const;

    gpu::Buffer& techniques() { return techniques_; }  // BidirectionalConstants
    gpu::Buffer& tables() { return *tables_; }         // those that BidirectionalConstants tells of
    gpu::Buffer& vertices() { return *vertices_; }
    gpu::Buffer& order() { return *order_; }
    gpu::Buffer& grid_places() { return *grid_places_; }

private:
    void make_room(uint64_t vertices);
    uint64_t first_element() const { return uint64_t{pass_} * plan_.light_paths; }

    const gpu::DeviceScene& scene_;
    gpu::Device& device_;
    const PassTechniques plan_;  // but for what changes from pass to pass
    const Size2 film_size_;
    const SequenceSampler sampler_;
    const uint64_t seed_;
    const uint64_t expected_;  // vertices that grids are laid out for: their order must be the same in each pass
    const std::vector<uint32_t> edge_words_;
    uint32_t pass_ = 0;
    gpu::BidirectionalConstants constants_{};
    gpu::HashGridConstants splat_grid_;
    HashGridGpu hash_grid_;
    gpu::ComputePipeline trace_, place_, show_;
    gpu::Buffer techniques_, state_, host_state_, splat_starts_;
    // As much as there is room for.
    std::optional<gpu::RadixSort> sort_;
    std::optional<gpu::Buffer> tables_, vertices_, places_, keys_, order_, grid_places_;
    std::optional<gpu::Buffer> splat_places_, splats_, splat_order_;
};

}  // namespace photond
