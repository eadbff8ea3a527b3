#pragma once
// Jobs and comparisons removed, with their files.

#include <cstdint>
#include <string>

#include "server/service/service_core.h"

namespace photond {

/// All under the lock where they say nothing else.
class Purges {
public:
    explicit Purges(ServiceCore& core) : core_(core) {}

    /// Removes a job that is over, and what waited for its end to be removed.
    void purge(const JobRow& row);
    /// Removes those of a comparison's jobs that are over, and the comparison with the last one.
    void finish_purge(const ComparisonRow& row);
    /// Likewise for all comparisons that are to be removed.
    void finish_purges();
    /// Throws WrongState: a job of a comparison is not removed by itself.
    void check_not_compared(const JobRow& row);
    /// Inside the transaction from which on no row names that film (empty: none): a daemon that ends before
    /// remove_film() removes it at its next start.
    void note_removal(const std::string& film);
    /// The film of an attempt (empty: none) and whatever artefacts lie beside it.
    void remove_film(const std::string& film);
    /// What a killed worker was writing for it. Without the lock.
    void remove_parts(const std::string& film) const;

private:
    ServiceCore& core_;
};

}  // namespace photond
