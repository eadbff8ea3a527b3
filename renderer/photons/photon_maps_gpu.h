#pragma once
// The photon maps of a pass on a device: traced in pieces that are short enough for a submit, and sorted into grids of
// cells that share their arrays (hash_grid.glsl searches them).

#include <array>
#include <optional>
#include <span>

#include "renderer/backends/gpu/command_list.h"
#include "renderer/photons/hash_grid_gpu.h"
#include "renderer/photons/photon_upload_gpu.h"

namespace photond {

/// Cells for searches of the `nearest` of so many photons of a map, within `most_m`: less than the radius of their disc
/// where the photons spread over the walls of the scene's box. Searches go farther where there are fewer; to have begun
/// with too many costs more. [m]
float cell_for_nearest(const Bounds3& bounds, PhotonMapKind kind, uint64_t photons, uint32_t nearest, float most_m);

class PhotonMapsGpu {
public:
    static constexpr size_t kMost = 4;  // maps; which is which is the caller's

    /// Borrows the scene.
    explicit PhotonMapsGpu(const gpu::DeviceScene& scene);
    /// Photons that there is room for where so many are expected: a quarter more.
    static uint64_t room_for(double expected) { return static_cast<uint64_t>(1.25 * expected) + 1024; }
    /// Of one map, and beside all of them: its largest one's photons as they were traced.
    static uint64_t map_bytes(uint64_t expected, uint64_t room, uint64_t records = 0) {
        return GridPhotons::bytes_for(grid_starts_for(expected), room, records);
    }
    static uint64_t shared_bytes(uint64_t most_room) { return UnsortedPhotons::bytes_for(most_room); }

    /// One more, without cells so far. `expected`: the photons that it is laid out for, whatever a pass stores: their
    /// order must be the same each time. `tracing.guide` is read here alone.
    /// `bounce_map_texels`: as PhotonTracerGpu has it.
    void add(size_t map, const PhotonTracing& tracing, uint64_t expected, uint32_t bounce_map_texels = 0);
    /// The same of photons that the host traces.
    void add_traced_on_host(size_t map, uint64_t expected);
    bool has(size_t map) const { return maps_[map].expected.has_value(); }
    uint64_t room(size_t map) const { return maps_[map].room; }
    PhotonTracerGpu& tracer(size_t map) { return *maps_[map].tracer; }

    /// Makes room for the maps' photons, and behind the grids' own for `words` and for `records` of 16 bytes, the
    /// caller's. What was traced is gone. Throws ErrorCode::OutOfMemory for more than can be sorted or numbered.
    void make_room(std::span<const uint32_t> words = {}, uint64_t records = 0);
    uint32_t first_word() const { return first_word_; }      // of the caller's: in photons().starts
    uint32_t first_record() const { return first_record_; }  // the same: in photons().powers

    /// The map's grid with cells for searches of radius `cell_m` > 0, from the next trace on.
    const gpu::HashGridConstants& cut_cells(size_t map, float cell_m);
    const gpu::HashGridConstants& grid(size_t map) const { return maps_[map].grid; }

    /// A pass's photons come in that many pieces, 0 ...; 0 where there is no such map.
    uint32_t pieces(size_t map) const;
    /// Scopes `rsm` (the bounce map), `photon_tracing` and `photon_map_build`. True: that was the last one, and the map
    /// is built.
    bool record(gpu::CommandList& commands, size_t map, uint64_t seed, uint32_t pass, uint32_t piece);
    /// The one piece of photons that the host has traced; scope `photon_map_build`.
    void record_traced_on_host(gpu::CommandList& commands, size_t map, std::span<const Photon> photons);
    /// Of a whole pass: true where there was too little room for its photons. make_room() makes it now.
    bool is_short();
    void add_to(Counts& counts, size_t map) const { maps_[map].tracer->add_to(counts, state(map)); }

    GridPhotons& photons() { return *grid_photons_; }

private:
    struct Map {
        std::optional<uint64_t> expected;  // none: there is no such map
        uint64_t room = 0;
        std::optional<PhotonTracerGpu> tracer;  // null: the host traces
        std::optional<PhotonUploadGpu> upload;
        gpu::HashGridConstants grid{};
    };
    /// So many rays or paths come in that many.
    uint32_t pieces_of(uint32_t paths) const {
        const uint32_t most = device_.paths_per_submit();
        return paths / most + (paths % most > 0 ? 1 : 0);
    }
    std::span<const uint32_t> state(size_t map) const {
        return host_states_.as<const uint32_t>().subspan(map * PHOTON_STATE_WORDS, PHOTON_STATE_WORDS);
    }

    void add_room(size_t map, uint64_t expected);
    void record_state(gpu::CommandList& commands, size_t map, gpu::Buffer& state);

    const gpu::DeviceScene& scene_;
    gpu::Device& device_;
    HashGridGpu hash_grid_;
    std::array<Map, kMost> maps_;
    std::optional<UnsortedPhotons> unsorted_;
    std::optional<GridPhotons> grid_photons_;
    uint32_t first_word_ = 0, first_record_ = 0;
    gpu::Buffer host_states_;  // of the tracers
};

}  // namespace photond
