#pragma once
// Videos are encoded by the system's ffmpeg, which a worker's process becomes inside the sandbox: it reads the pictures
// and writes the video, and reaches nothing else.

#include <filesystem>
#include <functional>
#include <optional>

#include "protocol/video_message.h"
#include "server/workers/worker_process.h"

namespace photond {

/// Where this system has it, by PATH.
std::optional<std::filesystem::path> system_ffmpeg();

/// Runs it to its end, in the lowest scheduling class. `process`: program, folders and limits. Throws TimedOut after so
/// many seconds, Unavailable where `given_up` says so, which is asked many times a second, Unsupported at
/// /format where it fails: its own words are on standard error, the daemon's log.
void encode_video(ProcessOptions process, const std::filesystem::path& ffmpeg, const EncodeVideoMessage& order,
                  double timeout_seconds, const std::function<bool()>& given_up);

}  // namespace photond
