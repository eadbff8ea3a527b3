#pragma once
// Sequences of frames: each frame is a job, in order by the worker of its device, which keeps what does not move.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "protocol/sequence.h"
#include "server/service/job_groups.h"
#include "server/service/scenes.h"
#include "server/service/sequence_view.h"

namespace photond {

/// All take the lock.
class Sequences {
public:
    Sequences(ServiceCore& core, Scenes& scenes, References& references, Purges& purges, Attempts& attempts, Jobs& jobs)
        : core_(core),
          scenes_(scenes),
          jobs_(jobs),
          groups_(core, references, purges, attempts, jobs, GroupKind::Sequence) {}

    /// May wait for the helper before. Durable, with all its frames, when it returns; all are accepted or none. Throws
    /// as Submissions::submit_job() does.
    nlohmann::json submit_sequence(const SequenceRequest& request, const std::optional<std::string>& key);
    /// What submit_sequence() would queue, after all its checks, and what that will take. May wait for the helper
    /// before.
    nlohmann::json estimate_sequence(const SequenceRequest& request);
    /// Throws NotFound, as all do that are given an id.
    nlohmann::json get_sequence(const std::string& id, bool with_frames = true);
    /// Without frames. Throws OutOfRange.
    Page list_sequences(uint32_t limit, const std::string& cursor);
    /// With `remove` its frames and their files go too.
    Cancelled cancel_sequence(const std::string& id, bool remove);

private:
    /// Before the lock; none where there is no such scene.
    std::vector<PreparedJob> draft_frames(const SequenceRequest& request);
    // --- under the lock
    SequenceView look_at(const ComparisonRow& row, bool with_frames);
    /// The one that the key was used for.
    std::optional<SequenceView> of_key(const std::optional<JobGroups::Key>& key);
    SequenceView insert(const SequenceRequest& request, std::vector<PreparedJob> drafts,
                        const std::optional<JobGroups::Key>& key);

    ServiceCore& core_;
    Scenes& scenes_;
    Jobs& jobs_;
    JobGroups groups_;
};

/// Under which a file of a sequence is kept in the cache: it goes with the sequence (Purges::finish_purge()). `content`
/// names what it is made of.
std::string sequence_key(const nlohmann::json& sequence, const std::string& what, const std::string& content);

}  // namespace photond
