#pragma once
// What the helper (photond-worker --device none) does: judge uploads, unpack, thumbnails, bake scenes, encode films.
// The only place where bytes from outside become scenes and images.

#include <nlohmann/json.hpp>

namespace photond {

struct HelperLimits {
    uint64_t memory_bytes = UINT64_MAX;
    unsigned threads = 1;
};

/// Answers one request of worker_messages.h with its "reply", whatever happens.
nlohmann::json run_helper_task(const nlohmann::json& message, const HelperLimits& limits) noexcept;

}  // namespace photond
