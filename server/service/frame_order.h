#pragma once
// Frames of a sequence that follow from the one before: they are rendered in their order.

#include <optional>

#include "protocol/worker_messages.h"
#include "server/service/service_core.h"

namespace photond {

/// All under the lock.
class FrameOrder {
public:
    explicit FrameOrder(ServiceCore& core) : core_(core) {}

    /// The frame before, while it is not over, of a frame that follows from it.
    std::optional<int64_t> waits_for(const JobRow& row);
    /// What is known of it once it is over: none of a frame that stands alone, of the first, and where that one left no
    /// film, because it failed or was cancelled.
    std::optional<RenderMessage::FrameBefore> before(const JobRow& row);

private:
    std::optional<JobRow> frame_before(const JobRow& row);

    ServiceCore& core_;
};

}  // namespace photond
