#include "server/service/process_meter.h"

#include <utility>

#include "server/processor_time.h"

namespace photond {

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

}  // namespace photond
