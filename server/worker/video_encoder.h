#pragma once
// A worker's process that becomes the system's ffmpeg.

#include <filesystem>
#include <vector>

#include "protocol/message_channel.h"
#include "server/worker/file_rules.h"

namespace photond {

/// What may be executed for it: the program, and the loader of programs that are linked to libraries. Throws
/// photond::Error (Internal) where that loader is not known.
std::vector<FileRule> video_encoder_files(const std::filesystem::path& program);

/// Waits for an EncodeVideoMessage and becomes the program: H.264 in MP4, 4:2:0, colours as BT.709 says them, sides
/// made even by a black line. Throws photond::Error where the message cannot be read or the program not executed.
[[noreturn]] void become_video_encoder(MessageChannel& channel, const std::filesystem::path& program, unsigned threads);

}  // namespace photond
