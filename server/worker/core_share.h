#pragma once
// Whether a job had the processors that it wanted while its clock ran.

#include <functional>
#include <map>
#include <optional>

#include "protocol/worker_messages.h"
#include "server/processor_time.h"

namespace photond {

/// What is known at one moment, all of it rising; empty where the kernel lacks it.
struct CoreSample {
    double process_seconds = 0;                   // processor time of this process, ended threads included
    std::optional<std::map<int, double>> delays;  // of its threads: how long each had to wait for a processor
    std::optional<HostTime> host;
    std::optional<double> pressure_seconds;
};
CoreSample core_sample_now();

/// Adds up, over the intervals in which a job's clock runs, what its threads got and had to wait for, and what the
/// host's processors did meanwhile. A look takes some ten microseconds a thread: it is taken where the clock stands
/// still, and a few times a second.
class CoreShare {
public:
    explicit CoreShare(std::function<CoreSample()> sample = core_sample_now) : sample_(std::move(sample)) {}

    /// The clock begins to run; what was before is not the job's.
    void begin();
    /// Around what is off the clock. Nothing happens before begin() and after end().
    void pause();
    void resume();
    void end();
    /// Reads the threads' waiting so far. Called often, so that little is lost of what threads waited that then end.
    void look();
    /// The sums over all intervals so far, without what CoreUse::derive() adds.
    const CoreUse& sums() {
        look();
        return sums_;
    }

private:
    enum class State { Idle, Running, Paused };

    const std::function<CoreSample()> sample_;
    State state_ = State::Idle;
    CoreSample last_;
    CoreUse sums_ = CoreUse::of_nothing();
};

}  // namespace photond
