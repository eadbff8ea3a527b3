#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "protocol/job.h"
#include "renderer/core/rng.h"
#include "server/worker/film_identity.h"
#include "server/worker/scene_cache.h"

namespace photond {

/// A "render" message (worker_messages.h) as read.
struct RenderOrder {
    nlohmann::json job, attempt;
    JobRequest request;
    SceneSource source;
    SceneVariant variant;
    std::filesystem::path film;
    std::optional<std::filesystem::path> resume;
    nlohmann::json reference = nullptr;  // a SOURCE
    RandomStreams streams = RandomStreams::Job;
    std::optional<double> save_seconds;
    uint64_t memory_bytes = 0;
    unsigned threads = 1;

    /// Within what the worker has. Throws photond::Error with pointers into the request.
    static RenderOrder from_json(const nlohmann::json& order, uint64_t most_memory_bytes, unsigned most_threads);
    uint64_t seed() const { return streams == RandomStreams::Reference ? reference_seed(request.seed) : request.seed; }
};

}  // namespace photond
