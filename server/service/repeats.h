#pragma once
// Jobs of comparisons that are rendered again because they were disturbed: the same request as a new job in the same
// place. Which of a place's jobs counts follows from them all (comparisons/repeats.h).

#include <optional>
#include <vector>

#include "server/service/service_core.h"

namespace photond {

/// All under the lock.
class Repeats {
public:
    explicit Repeats(ServiceCore& core) : core_(core) {}

    /// The jobs in the place of one of a comparison's: the one that was planned first, then its repeats. Empty where
    /// there is no such place.
    std::vector<ComparisonJob> runs_in_place_of(const JobRow& row);
    /// Inside a transaction: puts a new job in the place of those.
    void put_in_place(const JobRow& repeat, const std::vector<ComparisonJob>& runs);
    /// Inside the transaction in which a job ends: the repeat that the daemon makes by itself, to be queued after the
    /// commit. None where it makes none.
    std::optional<JobRow> repeat_if_disturbed(const JobRow& ended, Outbox& outbox);

private:
    ServiceCore& core_;
};

}  // namespace photond
