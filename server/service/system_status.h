#pragma once
// What the daemon says of itself: its devices, its state, its metrics.

#include <nlohmann/json.hpp>
#include <string>

#include "server/service/attempts.h"
#include "server/service/service_core.h"
#include "server/service/service_types.h"
#include "server/service/store_upkeep.h"

namespace photond {

/// All take the lock where they say nothing else.
class SystemStatus {
public:
    SystemStatus(ServiceCore& core, const Pictures& pictures, Attempts& attempts, const StoreUpkeep& upkeep)
        : core_(core), pictures_(pictures), attempts_(attempts), upkeep_(upkeep) {}

    /// May wait, without the lock, for the process that lists them.
    Page devices();
    nlohmann::json status();
    std::string metrics_text();
    /// What /readyz answers. Takes no lock.
    Readiness readiness() const;

private:
    /// Those of attempts that are running included; under the lock.
    nlohmann::json totals_now() const;
    nlohmann::json pictures_now() const;
    nlohmann::json helpers_now() const;

    ServiceCore& core_;
    const Pictures& pictures_;
    Attempts& attempts_;
    const StoreUpkeep& upkeep_;
};

}  // namespace photond
