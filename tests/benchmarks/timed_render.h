#pragma once
// Renders within a benchmark, with the seconds that a job's clock would count.

#include "renderer/frame/method.h"

namespace photond {

/// A method begun on a scene, pass after pass into a film; knows its seconds as a job's clock counts them.
template <class M>
class TimedRender {
public:
    TimedRender(const Scene& scene, const Intersector& intersector, Size2 size, const typename M::Params& params,
                uint64_t seed = 1)
        : method_(params), film(size, LayerSet{}) {
        const double start = wall_now_seconds();
        method_.begin({scene, &intersector, View{find_camera(scene, ""), size}, seed, budget}, stats);
        seconds += wall_now_seconds() - start;
    }
    void pass() {
        const double start = wall_now_seconds();
        method_.run_pass(film.passes(), stats, CancelToken{});
        method_.resolve(film);
        seconds += wall_now_seconds() - start;
    }

    MemoryBudget budget;
    Stats stats;
    double seconds = 0;  // wall

private:
    M method_;

public:
    Film film;
};

}  // namespace photond
