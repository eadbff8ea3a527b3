#pragma once
// A sequence of frames as the wire says it (protocol.md, "Sequences"): one job asked for many times, at moments of an
// animation, from along a path of the camera, or both.

#include <nlohmann/json.hpp>
#include <vector>

#include "protocol/job.h"

namespace photond {

inline constexpr size_t kMaxFrames = 10'000;

struct SequenceRequest {
    std::vector<JobRequest> frames;
    nlohmann::json echo;  // the request as understood, every default filled in; parsing it gives the same request
};

/// Reads a body: a job's members but `time` and `first_pass`, and from (0, s), fps (24) and either frames, their
/// number, or to (s), after which none comes; noise, "fresh" (each frame has a seed of its own, counted up from `seed`)
/// or "still"; camera_path, {"turns"} about the vertical axis through look_at's target or {"keys": [{time, eye, target,
/// up, yfov}]}. Frame i is at from + i / fps. Without an animation named it is the scene's first, or none along a path.
/// Throws photond::Error with all faults, each with its pointer into this body.
SequenceRequest parse_sequence_request(const nlohmann::json& body, const JobVocabulary& vocabulary);

}  // namespace photond
