#pragma once
// What the helper (photond-worker --device none) does: judge uploads, unpack, picture and bake scenes, encode films.
// The only place where bytes from outside become scenes and images.

#include <nlohmann/json.hpp>

#include "server/worker/scene_cache.h"

namespace photond {

/// Memory that the helper keeps from one task to the next (keep_free_memory()).
inline constexpr int kHelperKeptBytes = 512 << 20;

struct HelperLimits {
    uint64_t memory_bytes = UINT64_MAX;
    unsigned threads = 1;
};

/// Answers one request (helper_messages.h) with its ReplyMessage, whatever happens. The last scene that a picture was
/// made of stays in `scenes` for the next one where it takes little of the limit. It counts: the other tasks have what
/// it leaves, those that load scenes have all of it, and so has any task that is short of memory.
nlohmann::json run_helper_task(const nlohmann::json& message, const HelperLimits& limits, SceneCache& scenes) noexcept;

}  // namespace photond
