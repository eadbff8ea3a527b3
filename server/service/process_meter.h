#pragma once
#include <sys/types.h>

#include <map>
#include <string>
#include <vector>

#include "server/core_loss.h"

namespace photond {

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

}  // namespace photond
