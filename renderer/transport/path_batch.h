#pragma once
// Paths that are traced together, vertex by vertex: all rays, then all shading, then all shadow rays, so that packets
// of rays are full and what one path asks of memory comes while others are shaded.
//
// Paths that go on, shadow rays and what waits for them are written where they stay, number by number: a struct that is
// pieced together and then copied is read by wider loads than it was written, for which the processor waits (5 % of a
// whole pass of path tracing).

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "renderer/scene/intersector.h"

namespace photond {

/// One thread's. `State`: of a path between two of its vertices.
template <class State>
class PathBatch {
public:
    explicit PathBatch(size_t most_paths = 0) { make_room(most_paths); }
    static constexpr uint64_t bytes_for(size_t most_paths) {
        return most_paths * (2 * sizeof(Ray) + 2 * sizeof(State) + 2 * sizeof(uint32_t) + sizeof(Hit));
    }

    /// For that many paths under way at once; what is there stays.
    void make_room(size_t most_paths) {
        if (most_paths <= hits.size()) return;
        for (auto* list : {&rays, &next_rays_}) list->resize(most_paths);
        for (auto* list : {&paths, &next_paths_}) list->resize(most_paths);
        for (auto* list : {&keys, &next_keys_}) list->resize(most_paths);
        hits.resize(most_paths);
    }
    size_t room() const { return hits.size(); }

    /// Where each ray under way ends.
    void find_hits(const Intersector& intersector, Coherence coherence) {
        intersector.closest_hits({rays.data(), count}, {hits.data(), count}, coherence);
    }

    /// The place of the next path that goes on. What is written there counts once keep_next() was said.
    State& next_path() { return next_paths_[next_count_]; }
    Ray& next_ray() { return next_rays_[next_count_]; }
    void keep_next(uint32_t key) { next_keys_[next_count_++] = key; }
    /// Those that go on are under way now.
    void advance() {
        rays.swap(next_rays_);
        paths.swap(next_paths_);
        keys.swap(next_keys_);
        count = std::exchange(next_count_, 0);
    }

    /// Path i as it was before advance(), until another goes on.
    const State& former_path(size_t i) const { return next_paths_[i]; }
    uint32_t former_key(size_t i) const { return next_keys_[i]; }

    // Of each path under way, the first `count` of room().
    size_t count = 0;
    std::vector<Ray> rays;
    std::vector<State> paths;
    std::vector<uint32_t> keys;  // by which its numbers are drawn
    std::vector<Hit> hits;

private:
    size_t next_count_ = 0;
    std::vector<Ray> next_rays_;
    std::vector<State> next_paths_;
    std::vector<uint32_t> next_keys_;
};

/// Light samples of a batch, each with the shadow ray that judges it. One thread's. `Waiting`: what is added where the
/// ray is free.
template <class Waiting>
class ShadowBatch {
public:
    explicit ShadowBatch(size_t most_rays = 0) { make_room(most_rays); }
    static constexpr uint64_t bytes_for(size_t most_rays) {
        return most_rays * (sizeof(Ray) + sizeof(Waiting) + sizeof(uint8_t));
    }

    /// For that many rays at once; those that wait stay.
    void make_room(size_t most_rays) {
        if (most_rays <= rays_.size()) return;
        rays_.resize(most_rays);
        waiting_.resize(most_rays);
        occluded_.resize(most_rays);
    }
    bool has_room_for(size_t rays) const { return count_ + rays <= rays_.size(); }

    /// Inlined always: else both are pieced together before they are copied.
    [[gnu::always_inline]] void add(const Ray& ray, const Waiting& waiting) {
        rays_[count_] = ray;
        waiting_[count_++] = waiting;
    }

    /// Traces all that wait and calls visit(waiting) for those whose ray is free, in the order in which they were
    /// added. Then none wait. Returns how many rays there were.
    template <class Visit>
    size_t trace(const Intersector& intersector, Coherence coherence, const Visit& visit) {
        intersector.occluded({rays_.data(), count_}, {occluded_.data(), count_}, coherence);
        for (size_t i = 0; i < count_; ++i)
            if (!occluded_[i]) visit(waiting_[i]);
        return std::exchange(count_, 0);
    }

private:
    size_t count_ = 0;
    std::vector<Ray> rays_;
    std::vector<Waiting> waiting_;
    std::vector<uint8_t> occluded_;
};

}  // namespace photond
