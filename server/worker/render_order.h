#pragma once
#include <filesystem>
#include <optional>
#include <string>

#include "protocol/job.h"
#include "protocol/worker_messages.h"
#include "renderer/core/rng.h"
#include "server/worker/film_identity.h"
#include "server/worker/scene_cache.h"

namespace photond {

/// A RenderMessage as understood.
struct RenderOrder {
    std::string job;
    int64_t attempt = 0;
    JobRequest request;
    SceneSource source;
    SceneVariant variant;
    SceneMoment moment;
    std::filesystem::path film;
    std::string origin;
    std::optional<std::filesystem::path> resume;
    std::optional<RenderMessage::FrameBefore> before;
    std::optional<ReferenceSource> reference;
    RandomStreams streams = RandomStreams::Job;
    std::optional<double> save_seconds;
    uint64_t memory_bytes = 0;
    unsigned threads = 1;

    /// Within what the worker has. Throws photond::Error with pointers into the request.
    static RenderOrder of(const RenderMessage& message, uint64_t most_memory_bytes, unsigned most_threads);
    uint64_t seed() const { return streams == RandomStreams::Reference ? reference_seed(request.seed) : request.seed; }
};

}  // namespace photond
