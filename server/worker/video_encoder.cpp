#include "server/worker/video_encoder.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/auxv.h>
#include <sys/mman.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>

#include "protocol/error.h"
#include "protocol/video_message.h"

namespace photond {

namespace fs = std::filesystem;

namespace {

constexpr const char* kQuality = "17";  // x264's constant rate factor: hardly to be told from the pictures

[[noreturn]] void fail(const std::string& what) {
    throw Error(ErrorCode::Internal, "the video encoder: " + what + ": " + std::strerror(errno));
}

/// That of this process, which is any other's of this system.
fs::path program_loader() {
    Dl_info info{};
    const auto* const base = std::bit_cast<const void*>(getauxval(AT_BASE));
    if (base == nullptr || dladdr(base, &info) == 0 || info.dli_fname == nullptr)
        throw Error(ErrorCode::Internal, "the video encoder: the loader of programs is not found");
    return info.dli_fname;
}

/// The pictures' names as ffmpeg's concat demuxer reads them.
std::string list_of(const std::vector<fs::path>& pictures) {
    std::string list = "ffconcat version 1.0\n";
    for (const fs::path& picture : pictures) {
        list += "file 'file:";
        for (const char letter : picture.string())
            list += letter == '\'' ? std::string("'\\''") : std::string(1, letter);
        list += "'\n";
    }
    return list;
}

/// Standard input says this from here on.
void put_before(const std::string& text) {
    const int file = memfd_create("pictures", MFD_CLOEXEC);
    if (file < 0) fail("memfd_create");
    for (size_t written = 0; written < text.size();) {
        const ssize_t more = write(file, text.data() + written, text.size() - written);
        if (more < 0) fail("the list of pictures");
        written += static_cast<size_t>(more);
    }
    if (lseek(file, 0, SEEK_SET) != 0 || dup2(file, STDIN_FILENO) < 0) fail("standard input");
}

std::vector<std::string> arguments(const EncodeVideoMessage& asked, const fs::path& program, unsigned threads) {
    return {program.string(), "-nostdin", "-hide_banner", "-loglevel", "error", "-y",
            // what it reads
            "-protocol_whitelist", "file,pipe", "-r", nlohmann::json(asked.fps).dump(), "-f", "concat", "-safe", "0",
            "-i", "pipe:0",
            // what becomes of it
            "-vf",
            "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv:flags=accurate_rnd,format=yuv420p",
            "-color_primaries", "bt709", "-color_trc", "iec61966-2-1", "-colorspace", "bt709", "-color_range", "tv",
            "-c:v", "libx264", "-crf", kQuality, "-threads", std::to_string(threads),
            // what is written: no date and no version, and readable before its end is there
            "-fflags", "+bitexact", "-flags:v", "+bitexact", "-movflags", "+faststart", "-f", "mp4",
            "file:" + asked.out.string()};
}

}  // namespace

std::vector<FileRule> video_encoder_files(const fs::path& program) {
    return {{program, FileUse::Execute, true}, {program_loader(), FileUse::Execute, true}};
}

void become_video_encoder(MessageChannel& channel, const fs::path& program, unsigned threads) {
    const std::optional<nlohmann::json> message = channel.receive(-1);
    if (!message) throw Error(ErrorCode::WorkerLost, "the daemon is gone");
    const auto asked = read_part<EncodeVideoMessage>(*message, EncodeVideoMessage::kType);
    put_before(list_of(asked.pictures));
    std::vector<std::string> words = arguments(asked, program, threads);
    std::vector<char*> pointers;
    pointers.reserve(words.size() + 1);
    for (std::string& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    if (fcntl(channel.socket(), F_SETFD, FD_CLOEXEC) != 0) fail("the daemon's socket");
    execv(program.c_str(), pointers.data());
    fail(program.string());
}

}  // namespace photond
