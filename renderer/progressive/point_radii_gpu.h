#pragma once
// PointRadii (point_radii.h) on a device: the same records, of one set of hit points. A pass reads those that the last
// one left and writes its own beside them (point_radii.glsl), so that it can be made anew.

#include <optional>
#include <string>
#include <vector>

#include "renderer/backends/gpu/command_list.h"
#include "renderer/progressive/point_records.h"

namespace photond {

class PointRadiiGpu {
public:
    /// `photons`: whose maps have points. `state`: what passes before left; empty: none. Throws ErrorCode::Conflict for
    /// one that is not of these.
    PointRadiiGpu(gpu::Device& device, const ProgressiveParams& params, uint64_t pixels,
                  const ProgressivePhotons& photons, const std::string& state);
    static uint64_t device_bytes(uint64_t state_bytes) { return 3 * state_bytes; }
    static uint64_t host_bytes(uint64_t state_bytes) { return 3 * state_bytes; }

    /// Of the map's records in the buffers below.
    uint32_t first_word(PhotonMapKind kind) const { return static_cast<uint32_t>(first_[index_of(kind)]); }
    /// The geometric mean of the known radii that the passes before left; nothing where none is known. [m]
    std::optional<float> mean_radius_m(PhotonMapKind kind) const;

    /// Said before a pass is recorded: another one, or the same again.
    void begin_pass(uint32_t pass);
    gpu::Buffer& before() { return points_[before_]; }
    gpu::Buffer& after() { return points_[1 - before_]; }
    void record_readback(gpu::CommandList& commands);
    /// The pass begun is done: the next one starts from what it left.
    void end_pass();
    /// And it is part of the film.
    void resolve();
    /// As after the last resolve().
    std::string state() const;

private:
    std::span<const float> of(const std::vector<float>& words, PhotonMapKind kind) const;

    const SavedPoints kind_;
    PerMap<size_t> first_{}, words_{};
    std::vector<float> resolved_, last_;  // records after the last resolve(), and after the last end_pass()
    uint32_t begun_ = 0;
    std::optional<uint32_t> ended_;  // its records stand in after(), so long as no other pass is begun
    uint32_t before_ = 0;
    gpu::Buffer points_[2], host_points_;
};

}  // namespace photond
