#pragma once
// The loop over a job's passes: its clock, its stop conditions, and what a cancelled pass leaves.

#include <functional>
#include <optional>
#include <string_view>

#include "protocol/job.h"
#include "renderer/core/cancel.h"
#include "renderer/frame/method.h"

namespace photond {

/// Whoever reads the film from another thread, while passes are rendered.
class FilmReader {
public:
    virtual ~FilmReader() = default;
    /// The film is about to change, or to go: it is not read from here on, until it stands again. Where it is being
    /// read at this moment, waits for that, off the clock, or returns false.
    virtual bool hold(bool wait) = 0;
    /// The film has taken so many seconds, and stays as it is.
    virtual void stands(const Film& film, double render_seconds) = 0;
};

/// Begins a method and runs passes until a stop condition is met or `cancel` is seen. The film's memory and the
/// method's are required of the budget first.
///
/// The first pass of a film is finished whatever the seconds asked for, since an image is worth more than the clock. A
/// later one that is not done by then is cut off and thrown away: pass sizes never depend on the clock.
struct PassLoop {
    Method& method;
    const RenderContext& context;
    StopConditions stop;  // `target` is for after_pass to judge
    const CancelToken& cancel;
    /// Called after each finished pass, off the clock; true ends the loop.
    std::function<bool(const Film& film, double render_seconds)> after_pass = {};

    uint32_t first_pass = 0;                         // index of the film's first pass; not used with `film`
    std::optional<Film> film = {};                   // to go on with, from its next_pass(); taken by run()
    double seconds_before = 0;                       // what that film took so far
    std::function<double()> now = wall_now_seconds;  // called by all threads that render
    /// Whether after_pass will take long, off the clock: the method's device is let come to rest before, on it.
    std::function<bool(const Film& film, double render_seconds)> pauses = {};
    FilmReader* reader = nullptr;  // null: nobody reads the film meanwhile

    struct Result {
        Film film;
        double render_seconds = 0;  // seconds_before + begin + passes + resolve, nothing else
        bool cancelled = false;
        uint32_t passes_rendered = 0;  // here, not before
        double begin_seconds = 0;      // of render_seconds, before the first of them
        double passes_seconds = 0;     // of render_seconds, these passes
        double cut_off_seconds = 0;    // of render_seconds, the pass that was thrown away; 0: none was
    };
    /// A film that meets the stop conditions already is given back without beginning the method.
    /// Time on the clock that no stage of `stats` took is added to the stage "waiting", so that the stages of a render
    /// add up to its seconds.
    Result run(Stats& stats);
};

/// Time of a render that none of its own stages took: for a device to come to rest, for threads to begin and to end.
inline constexpr std::string_view kWaitingStage = "waiting";

}  // namespace photond
