#pragma once
// What a start does before any process runs: an earlier daemon may have ended at any point.

#include "server/service/attempts.h"
#include "server/service/purges.h"
#include "server/service/service_core.h"

namespace photond {

/// Takes the lock. Opens the events, records what was running as lost, finishes removals and fills the queue.
void recover(ServiceCore& core, Attempts& attempts, Purges& purges);
/// Takes the lock. Removes files that no row names.
void sweep_orphans(ServiceCore& core);

}  // namespace photond
