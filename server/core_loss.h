#pragma once
// To whom a job lost processor time: "shared" of its statistics.

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

/// Processor time by who had it: "helper", "pictures" (those drawn beside it), "photond", "job J12", "worker gpu:0"
/// between its jobs, "others".
using ProcessorSeconds = std::map<std::string, double>;

struct LostTo {
    std::string who;
    double seconds = 0;
};
/// What a disturbed job lost.
struct CoreLoss {
    double share = 1;          // of the processor time that it wanted, which it had
    double seconds = 0;        // of processors
    double clock_seconds = 0;  // by which its clock is too long, at most
    std::vector<LostTo> to;    // the greatest first

    /// None for a job that was not disturbed, or of which that is not known. What it lost is shared out by what each of
    /// ours took while it ran; the rest of what ran outside is others'. Less than a hundredth is left out.
    static std::optional<CoreLoss> of(const CoreUse& use, const ProcessorSeconds& ours);
    /// As to_json() wrote it into statistics.
    static std::optional<CoreLoss> of_statistics(const nlohmann::json& statistics);

    /// "2.1 s of its processor time (14 %) to others"
    std::string what() const;
    /// "2.1 s of its processor time (14 %) were lost to others: its clock cannot be compared; run it again."
    std::string warning() const;
};
/// {"share", "lost_seconds", "clock_seconds", "to": [{"who", "seconds"}], "warning"}, or null.
nlohmann::json to_json(const std::optional<CoreLoss>& loss);

}  // namespace photond
