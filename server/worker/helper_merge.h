#pragma once
#include <cstdint>

#include "protocol/helper_messages.h"

namespace photond {

/// Joins films of unlike passes of one image to the film of all of
/// them, with what they took together. Holds two films at a time. Throws ErrorCode::Conflict at /films/i for one that
/// is of another scene, other settings, another class of devices or version, or that has a pass of those before it;
/// other faults of a film at the same place.
MergeFilmsReply merge_films(const MergeFilmsRequest& asked, uint64_t memory_bytes);

}  // namespace photond
