#pragma once
// To whom a job lost processor time: "shared" of its statistics.

#include <sys/types.h>

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "protocol/worker_messages.h"

namespace photond {

/// A job that had less than this share of the processor time that it wanted was disturbed.
inline constexpr double kUndisturbedShare = 0.98;
/// But where it lost less than this, that cannot be told: what ran outside is counted in ticks of the kernel's clock.
inline constexpr double kLeastLoss_s = 0.01;

/// Processor time by who had it: "helper", "photond", "job J12", "worker gpu:0" between its jobs, "others".
using ProcessorSeconds = std::map<std::string, double>;

/// What processes of ours take of the processors.
class ProcessMeter {
public:
    struct Process {
        std::string who;  // what it has taken since the last reading was for
        pid_t pid = -1;   // -1: there is none now
    };
    /// Since the last reading; of a process that was not there, since it began.
    ProcessorSeconds read(const std::vector<Process>& processes);

private:
    std::map<pid_t, double> last_;
};

struct LostTo {
    std::string who;
    double seconds = 0;
};
/// Shares out what a job lost by what each of ours took while it ran; the rest of what ran outside is others'. The
/// greatest first; what is less than a hundredth is left out.
std::vector<LostTo> lost_to(const CoreUse& use, const ProcessorSeconds& ours);

/// "2.1 s of its processor time (14 %) were lost to others: its clock cannot be compared; run it again."
std::string loss_text(const CoreUse& use, const std::vector<LostTo>& to);

/// {"share", "lost_seconds", "to": [{"who", "seconds"}], "warning"}; null for a job that was not disturbed, or of which
/// that is not known.
nlohmann::json shared_json(const CoreUse& use, const ProcessorSeconds& ours);

}  // namespace photond
