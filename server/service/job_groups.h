#pragma once
// What comparisons and sequences have in common: a request and the jobs it means, written in one transaction, and from
// there on read off the jobs.

#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/service/comparison_judgement.h"
#include "server/service/jobs.h"
#include "server/service/purges.h"
#include "server/service/references.h"
#include "server/service/service_core.h"
#include "server/service/service_types.h"

namespace photond {

class JobGroups {
public:
    JobGroups(ServiceCore& core, References& references, Purges& purges, Attempts& attempts, Jobs& jobs, GroupKind kind)
        : core_(core), references_(references), purges_(purges), attempts_(attempts), jobs_(jobs), kind_(kind) {}

    /// One of its jobs, and what is noted of it beside.
    struct Member {
        PreparedJob job;
        ComparisonJob note;  // without the job's seq
    };
    /// What was asked for under a key, and the hash of that.
    struct Key {
        std::string text, body_sha256;
    };
    /// `echo`: the request as understood. Throws OutOfRange for what is no key.
    static std::optional<Key> key_of(const std::optional<std::string>& key, const nlohmann::json& echo);

    /// One of a list's pages, without those that are being removed.
    struct RowPage {
        std::vector<ComparisonRow> rows;
        nlohmann::json next_cursor;
    };

    // --- under the lock
    /// Throws OutOfRange.
    RowPage read_page(uint32_t limit, const std::string& cursor);
    /// Throws NotFound.
    ComparisonRow require(const std::string& id);
    ComparisonState state_of(const ComparisonRow& row);
    /// How far it is by now, where that is less than whole rows of the store say.
    JobProgress progress_now(JobProgress job) const;
    /// The one that the key was used for. Throws IdempotencyMismatch where that was with another body.
    std::optional<ComparisonRow> of_key(const std::optional<Key>& key);
    /// Room is looked for before. `row`: created before its jobs and what they are measured against. Gives it; `queue`
    /// is to be called when nothing is read of it any more.
    ComparisonRow insert(ComparisonRow row, std::vector<Member>& members, const std::optional<Key>& key,
                         std::function<void()>& queue);
    /// Cancels its jobs that are not over, and the reference made for it where nobody else waits for that; with
    /// `remove` all of it goes. `look` sees it before it is gone. Throws WrongState where jobs of others are measured
    /// against one of them.
    void cancel(ComparisonRow row, bool remove, const std::function<void(const ComparisonRow&)>& look);

private:
    ServiceCore& core_;
    References& references_;
    Purges& purges_;
    Attempts& attempts_;
    Jobs& jobs_;
    const GroupKind kind_;
};

}  // namespace photond
