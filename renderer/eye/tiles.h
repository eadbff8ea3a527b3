#pragma once
// Tiles of the image: the unit of work of a thread.

#include <ctime>
#include <initializer_list>
#include <span>
#include <string_view>
#include <utility>

#include "renderer/core/cancel.h"
#include "renderer/core/parallel.h"
#include "renderer/core/stats.h"
#include "renderer/eye/eye_path.h"
#include "renderer/eye/eye_scene.h"

namespace photond {

/// A rectangle of pixels, traced as one batch by one thread.
struct Tile {
    uint32_t x0, y0, x1, y1;  // half open
    size_t pixels() const { return size_t{x1 - x0} * (y1 - y0); }
};

/// Calls body(tile) for all tiles of an image, in parallel, until cancelled.
template <class Body>
void parallel_over_tiles(Size2 size, uint32_t side, const CancelToken& cancel, const Body& body) {
    const uint32_t columns = (size.width + side - 1) / side, rows = (size.height + side - 1) / side;
    parallel_for(size_t{columns} * rows, 1, [&](size_t index) {
        if (cancel.cancelled()) return;
        const uint32_t x = uint32_t(index % columns) * side, y = uint32_t(index / columns) * side;
        body(Tile{x, y, std::min(x + side, size.width), std::min(y + side, size.height)});
    });
}

/// Starts one path for each pixel of the tile, row by row: its camera ray, its state and its key of the sampler. The
/// spans hold tile.pixels().
void start_eye_paths(const EyeScene& shared, const PassSampler& sampler, const Tile& tile, std::span<Ray> rays,
                     std::span<EyePath> paths, std::span<uint32_t> keys);

/// CPU seconds of the thread between calls. Each is a system call: ask a few times a tile.
class ThreadLaps {
public:
    ThreadLaps() : then_(now()) {}
    /// Adds the time since the last call.
    void lap(double& part) {
        const double time = now();
        part += time - then_;
        then_ = time;
    }

private:
    static double now() {
        timespec time{};
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
        return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
    }
    double then_;
};

/// CPU seconds of threads, by part of the paths (conventions.md, "Paths, layers, bounces").
struct EyeSeconds {
    double camera = 0;    // camera rays and their first hits
    double direct = 0;    // first vertices: their shading and shadow rays
    double indirect = 0;  // further vertices
    double points = 0;    // what a method does with visible points (VisiblePointSink::take())

    EyeSeconds& operator+=(const EyeSeconds& other) {
        camera += other.camera, direct += other.direct, indirect += other.indirect, points += other.points;
        return *this;
    }
};

/// What all threads did since the last call: their `counts` are added to the statistics, their `seconds` returned.
template <class Threads>
EyeSeconds take_work(Threads& threads, Stats& stats) {
    EyeSeconds seconds;
    for (auto& thread : threads) {
        stats.counts += std::exchange(thread.counts, {});
        seconds += std::exchange(thread.seconds, {});
    }
    return seconds;
}

/// Books stages that alternate tile by tile on every thread: each gets the share of the wall time that it has of the
/// CPU seconds.
void add_interleaved_stages(Stats& stats, double wall_seconds,
                            std::initializer_list<std::pair<std::string_view, double>> cpu_seconds);

}  // namespace photond
