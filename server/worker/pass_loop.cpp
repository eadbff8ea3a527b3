#include "server/worker/pass_loop.h"

#include <algorithm>
#include <limits>

namespace photond {

namespace {

/// Seconds of the render's clock. What the stages did not take of them is the waiting stage's.
class RenderClock {
public:
    RenderClock(const std::function<double()>& now, Stats& stats) : now_(now), stats_(stats) {}

    void start() {
        const double cpu = cpu_now_seconds();
        const Stage staged = all_stages();
        cpu_start_ = cpu - staged.cpu_seconds;
        staged_start_ = staged.wall_seconds;
        start_ = now_();
    }
    double started() const { return start_; }
    double elapsed() const { return now_() - start_; }
    /// Seconds since start().
    double stop() {
        const double seconds = now_() - start_;
        const Stage staged = all_stages();
        const double unstaged = seconds - (staged.wall_seconds - staged_start_);
        const double unstaged_cpu = cpu_now_seconds() - staged.cpu_seconds - cpu_start_;
        if (unstaged > 0) {
            Stage& waiting = stats_.stage(kWaitingStage);
            waiting.wall_seconds += unstaged;
            waiting.cpu_seconds += std::max(unstaged_cpu, 0.0);
        }
        return seconds;
    }

private:
    Stage all_stages() const {
        Stage sum;
        for (const Stage& stage : stats_.stages)
            sum.wall_seconds += stage.wall_seconds, sum.cpu_seconds += stage.cpu_seconds;
        return sum;
    }

    const std::function<double()>& now_;
    Stats& stats_;
    double start_ = 0, staged_start_ = 0, cpu_start_ = 0;
};

/// The film at its end, in whatever way that comes.
class EndOfReading {
public:
    explicit EndOfReading(FilmReader* reader) : reader_(reader) {}
    ~EndOfReading() {
        if (reader_) reader_->hold(true);
    }
    EndOfReading(const EndOfReading&) = delete;
    EndOfReading& operator=(const EndOfReading&) = delete;

private:
    FilmReader* const reader_;
};

}  // namespace

PassLoop::Result PassLoop::run(Stats& stats) {
    const Size2 size = context.view.film_size;
    const LayerSet layers = context.view.layers;
    if (!film) {
        context.budget.require("film", Film::bytes_for(size, layers));
        film.emplace(size, layers, first_pass);
    }
    Result result{.film = *std::exchange(film, std::nullopt), .render_seconds = seconds_before};
    context.budget.record("film", result.film.bytes());

    const auto stop_met = [&] {
        const uint32_t done = result.film.passes();
        return (stop.passes && done >= *stop.passes) ||
               (stop.seconds && done > 0 && result.render_seconds >= *stop.seconds);
    };
    if (stop_met()) return result;
    const EndOfReading end_of_reading(reader);
    if (reader && result.film.passes() > 0) reader->stands(result.film, result.render_seconds);
    RenderClock clock(now, stats);
    clock.start();
    method.begin(context, stats);
    result.begin_seconds = clock.stop();
    result.render_seconds += result.begin_seconds;
    double last_pass_seconds = 0;
    while (!stop_met()) {
        clock.start();
        const bool may_be_cut_off = stop.seconds && result.film.passes() > 0;
        const CancelToken end(cancel, now,
                              may_be_cut_off ? clock.started() + (*stop.seconds - result.render_seconds)
                                             : std::numeric_limits<double>::infinity());
        if (!cancel.cancelled()) method.run_pass(result.film.next_pass(), stats, end);
        if (cancel.cancelled()) {
            result.cancelled = true;  // the pass may be unfinished: nothing of it reaches the film
            break;
        }
        if (end.seen()) {
            result.cut_off_seconds = clock.stop();
            result.render_seconds += result.cut_off_seconds;
            break;
        }
        const uint32_t done = result.film.passes() + 1;
        const double guessed_seconds = result.render_seconds + last_pass_seconds;  // when this one is folded
        if (!(stop.passes && done >= *stop.passes) && !(stop.seconds && guessed_seconds >= *stop.seconds))
            method.expect_pass(result.film.next_pass() + 1);
        double pass_seconds = 0;
        if (reader && !reader->hold(false)) {
            method.settle();
            pass_seconds = clock.stop();
            result.render_seconds += pass_seconds;
            reader->hold(true);
            clock.start();
        }
        {
            const StageTimer timer(stats, "combine");
            method.resolve(result.film);
        }
        if (pauses && pauses(result.film, result.render_seconds + clock.elapsed())) method.settle();
        const double rest_seconds = clock.stop();
        result.render_seconds += rest_seconds;
        last_pass_seconds = pass_seconds + rest_seconds;
        result.passes_seconds += last_pass_seconds;
        ++result.passes_rendered;
        if (reader) reader->stands(result.film, result.render_seconds);
        if (after_pass && after_pass(result.film, result.render_seconds)) break;
    }
    return result;
}

}  // namespace photond
