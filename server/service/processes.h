#pragma once
// The processes of the daemon: the helpers, the one that draws pictures beside jobs, and a worker for each device, from
// their start to their end.

#include <mutex>
#include <thread>

#include "server/service/attempts.h"
#include "server/service/pictures.h"
#include "server/service/scenes.h"
#include "server/service/service_core.h"

namespace photond {

class Processes {
public:
    Processes(ServiceCore& core, Pictures& pictures, Scenes& scenes, Attempts& attempts)
        : core_(core), pictures_(pictures), scenes_(scenes), attempts_(attempts) {}
    /// Ends the helpers, which call back what is destroyed after this.
    ~Processes();
    Processes(const Processes&) = delete;
    Processes& operator=(const Processes&) = delete;

    /// Takes the lock. Throws DeviceUnavailable.
    void start();
    /// Takes the lock, and waits for the processes' ends without it. Nothing happens the second time.
    void stop();

private:
    void prewarm();

    ServiceCore& core_;
    Pictures& pictures_;
    Scenes& scenes_;
    Attempts& attempts_;
    std::thread prewarm_;  // has the built-in scenes judged before anybody asks
    std::once_flag stopped_;
};

}  // namespace photond
