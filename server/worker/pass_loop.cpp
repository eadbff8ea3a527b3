#include "server/worker/pass_loop.h"

namespace photond {

PassLoop::Result PassLoop::run(Stats& stats) {
    const Size2 size = context.view.film_size;
    const LayerSet layers = context.view.layers;
    if (!film) {
        context.budget.require("film", Film::bytes_for(size, layers));
        film.emplace(size, layers, first_pass);
    }
    Result result{*std::exchange(film, std::nullopt), seconds_before, false, 0};
    context.budget.record("film", result.film.bytes());

    const auto stop_met = [&] {
        const uint32_t done = result.film.passes();
        return (stop.passes && done >= *stop.passes) ||
               (stop.seconds && done > 0 && result.render_seconds >= *stop.seconds);
    };
    if (stop_met()) return result;
    double start = now();
    method.begin(context, stats);
    result.render_seconds += now() - start;
    double last_pass_seconds = 0;
    while (!stop_met()) {
        start = now();
        if (!cancel.cancelled()) method.run_pass(result.film.next_pass(), stats, cancel);
        if (cancel.cancelled()) {
            result.cancelled = true;  // the pass may be unfinished: nothing of it reaches the film
            break;
        }
        const uint32_t done = result.film.passes() + 1;
        const double guessed_seconds = result.render_seconds + last_pass_seconds;  // when this one is folded
        if (!(stop.passes && done >= *stop.passes) && !(stop.seconds && guessed_seconds >= *stop.seconds))
            method.expect_pass(result.film.next_pass() + 1);
        {
            const StageTimer timer(stats, "combine");
            method.resolve(result.film);
        }
        if (pauses && pauses(result.film, result.render_seconds + (now() - start))) method.settle();
        last_pass_seconds = now() - start;
        result.render_seconds += last_pass_seconds;
        ++result.passes_rendered;
        if (after_pass && after_pass(result.film, result.render_seconds)) break;
    }
    return result;
}

}  // namespace photond
