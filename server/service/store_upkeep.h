#pragma once
// What is done for the store beside the serving: all of its file is checked once, and a recovery that found no room is
// tried again.

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "server/service/recovery.h"
#include "server/service/service_core.h"

namespace photond {

class StoreUpkeep {
public:
    StoreUpkeep(ServiceCore& core, Recovery& recovery) : core_(core), recovery_(recovery) {}
    ~StoreUpkeep();

    void start();
    /// Under the service's lock. {"id", "bytes", "check": {"state": "waiting", "running", "ok", "damaged" or "failed",
    /// "detail"}, "recovered", "quarantine": {"files", "bytes"}}.
    nlohmann::json status() const;

private:
    void run();
    /// False where it is to be tried again.
    bool check();
    void note(const char* state, std::string detail);

    ServiceCore& core_;
    Recovery& recovery_;
    std::string check_state_ = "waiting", check_detail_;  // under the service's lock
    std::mutex mutex_;
    std::condition_variable woken_;
    std::atomic<bool> stopping_ = false;
    std::thread thread_;
};

}  // namespace photond
