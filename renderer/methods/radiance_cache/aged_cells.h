#pragma once
// Cells that a frame of an animation takes over from the one before. Their samples count for less from frame to frame,
// by (age - 1) / age, so that those of a cell which each frame finds as often come to `age` frames' at most: a running
// mean. What has had no sample for so many frames is dropped.
//
// Biased: light that changes lags. The grid stays where it is as long as cells are taken over, so that they name the
// same places.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/frame/followed_frame.h"
#include "renderer/frame/frame_before.h"
#include "renderer/methods/radiance_cache/cache_training.h"
#include "renderer/methods/radiance_cache/cell_grid.h"
#include "renderer/methods/radiance_cache/params.h"

namespace photond {

/// A cell as a frame leaves it.
struct LeftCell {
    uint32_t bucket;
    uint32_t fingerprint;
    vec3 radiance;  // mean of its samples [W m^-2 sr^-1]
    uint32_t samples;
    uint32_t frames_unseen;  // in which it had none, up to this one
};

/// What a frame leaves: cells by their bucket, in the order of its places.
struct LeftCells {
    uint32_t buckets = 0;
    vec3 origin{0};  // CellGrid's
    float coarsest_m = 1;
    std::vector<LeftCell> cells;

    std::string encode() const;
    /// Throws ErrorCode::Conflict unless they are of a table of that many buckets.
    static LeftCells decode(std::string_view text, uint32_t buckets);
    static uint64_t bytes_for(uint32_t cells);
};

/// A cell as a table begins with it.
struct AgedCell {
    uint32_t slot;
    uint32_t fingerprint;
    uint64_t units[3];  // sums
    uint32_t samples;
    uint32_t last_round;
};

struct AgedCells {
    /// `key`: of the numbers by which counts are rounded, so that cells of few samples age as the others do.
    AgedCells(const LeftCells& before, uint32_t age, uint32_t key);

    uint32_t round;  // the last before the frame's own
    float unit = 0;  // of the sums; 0: all are black
    std::vector<AgedCell> cells;
};

/// What both devices' methods keep from frame to frame. Does nothing unless the parameters ask for it.
class CellsBetweenFrames {
public:
    explicit CellsBetweenFrames(const RadianceCacheParams& params);
    static uint64_t bytes_for(const RadianceCacheParams& params);

    /// As those of Method.
    void follow(const FrameBefore& before);
    void go_on_from(const std::string& state) const { followed_.go_on_from(state); }
    std::string state() const { return followed_.state(); }
    std::string left_to_next() const { return left_; }

    /// What a block's table begins with; nothing where cells are not aged.
    std::optional<AgedCells> aged(uint64_t seed) const;
    /// Puts the grid where the cells of the frame before are.
    void place(CellGrid& grid) const;
    /// Whether what the frame leaves is yet to be made of that block, whose pass is done: the last one's is left.
    bool lacks(const CacheBlock& block) const { return aged_ && left_of_ != block.first; }
    /// `leave(cells)` appends the cells of a table of that block, by append().
    template <class Leave>
    void leave(const CacheBlock& block, const CellGrid& grid, const Leave& leave_cells) {
        LeftCells cells{.buckets = buckets_, .origin = grid.origin, .coarsest_m = grid.coarsest_m, .cells = {}};
        leave_cells(cells);
        left_ = cells.encode(), left_of_ = block.first;
    }
    /// Appends a cell, in the order of places, unless it is to be dropped.
    void append(LeftCells& to, uint32_t slot, uint32_t fingerprint, const vec3& radiance, uint32_t samples,
                uint32_t last_round) const;

private:
    const bool aged_;
    const uint32_t age_, buckets_;
    LeftCells before_;
    FollowedFrame followed_;
    std::string left_;
    std::optional<uint32_t> left_of_;  // the block's first pass
};

}  // namespace photond
