#include "server/service/core_loss.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "server/comparisons/report_text.h"
#include "server/processor_time.h"

namespace photond {

using nlohmann::json;

namespace {

constexpr double kLeastNamed = 0.01;  // of what was lost
constexpr double kLeastSaid = 0.1;    // likewise, in the sentence

std::string spoken(const std::string& who) {
    if (who == "helper") return "our helper";
    return who == "photond" ? "photond itself" : who;
}

}  // namespace

ProcessorSeconds ProcessMeter::read(const std::vector<Process>& processes) {
    ProcessorSeconds taken;
    std::map<pid_t, double> now;
    for (const Process& process : processes) {
        const auto seconds = processor_seconds_of(process.pid);
        if (!seconds) continue;
        const auto before = last_.find(process.pid);
        const bool same = before != last_.end() && before->second <= *seconds;  // else another got its number
        taken[process.who] += same ? *seconds - before->second : *seconds;
        now[process.pid] = *seconds;
    }
    last_ = std::move(now);
    return taken;
}

std::vector<LostTo> lost_to(const CoreUse& use, const ProcessorSeconds& ours) {
    const double lost = use.lost_seconds.value_or(0);
    const double of_ours = std::accumulate(ours.begin(), ours.end(), 0.0,
                                           [](double sum, const auto& taken) { return sum + taken.second; });
    // Ours are read from an attempt's beginning to its end, which is more than its clock.
    const double outside = std::max(use.host_busy_outside_seconds.value_or(of_ours + lost), of_ours);
    std::vector<LostTo> to;
    const auto add = [&](const std::string& who, double taken) {
        const double seconds = outside > 0 ? lost * taken / outside : 0;
        if (seconds > kLeastNamed * lost) to.push_back({who, seconds});
    };
    for (const auto& [who, taken] : ours) add(who, taken);
    add("others", outside - of_ours);
    std::stable_sort(to.begin(), to.end(), [](const LostTo& a, const LostTo& b) { return a.seconds > b.seconds; });
    return to;
}

std::string loss_text(const CoreUse& use, const std::vector<LostTo>& to) {
    const double lost = use.lost_seconds.value_or(0);
    std::vector<std::string> named;
    const bool several = to.size() > 1 && to[1].seconds >= kLeastSaid * lost;
    for (const LostTo& taker : to)
        if (named.empty() || taker.seconds >= kLeastSaid * lost)
            named.push_back(spoken(taker.who) + (several ? " (" + short_seconds(taker.seconds) + ")" : ""));
    std::string names;
    for (size_t i = 0; i < named.size(); ++i)
        names += (i == 0 ? "" : i + 1 == named.size() ? " and " : ", ") + named[i];
    return short_seconds(lost) + " of its processor time (" +
           std::to_string(std::lround(100 * (1 - use.share.value_or(1)))) + " %) were lost to " + names +
           ": its clock cannot be compared; run it again.";
}

json shared_json(const CoreUse& use, const ProcessorSeconds& ours) {
    if (!use.share || !use.lost_seconds || *use.share >= kUndisturbedShare || *use.lost_seconds < kLeastLoss_s)
        return nullptr;
    const std::vector<LostTo> to = lost_to(use, ours);
    json list = json::array();
    for (const LostTo& taker : to) list.push_back({{"who", taker.who}, {"seconds", taker.seconds}});
    return {{"share", *use.share},
            {"lost_seconds", *use.lost_seconds},
            {"to", std::move(list)},
            {"warning", loss_text(use, to)}};
}

}  // namespace photond
