#include "server/workers/video_process.h"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <string>
#include <string_view>
#include <thread>

#include "protocol/error.h"
#include "protocol/message_channel.h"
#include "server/steady_seconds.h"

namespace photond {

namespace fs = std::filesystem;

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kLook{20};  // how often it is asked whether the encoder has ended

/// A child that ends with this object at the latest.
class Encoder {
public:
    explicit Encoder(const Child& child) : child_(child) {}
    ~Encoder() {
        close(child_.socket);
        if (child_.pid < 0) return;
        ::kill(child_.pid, SIGKILL);
        waitpid(child_.pid, nullptr, 0);
    }
    Encoder(const Encoder&) = delete;
    Encoder& operator=(const Encoder&) = delete;

    void tell(const EncodeVideoMessage& order) const { MessageChannel(child_.socket).send(message_json(order)); }
    /// As waitpid(2) has it; nothing while it runs.
    std::optional<int> status() {
        int status = 0;
        if (waitpid(child_.pid, &status, WNOHANG) != child_.pid) return std::nullopt;
        child_.pid = -1;
        return status;
    }

private:
    Child child_;
};

}  // namespace

std::optional<fs::path> system_ffmpeg() {
    const char* const path = std::getenv("PATH");
    for (std::string_view rest = path ? path : ""; !rest.empty();) {
        const std::string_view folder = rest.substr(0, rest.find(':'));
        const fs::path program = fs::path(folder) / "ffmpeg";
        if (program.is_absolute() && access(program.c_str(), X_OK) == 0) return program;
        rest.remove_prefix(std::min(rest.size(), folder.size() + 1));
    }
    return std::nullopt;
}

void encode_video(ProcessOptions process, const fs::path& ffmpeg, const EncodeVideoMessage& order,
                  double timeout_seconds, const std::function<bool()>& given_up) {
    process.device = "video";
    process.more_arguments = {"--video-program", ffmpeg.string()};
    process.priority.background = true;
    Encoder encoder(spawn_child(process.program, worker_arguments(process), process.priority));
    encoder.tell(order);
    const auto deadline = Clock::now() + steady_seconds(timeout_seconds);
    std::optional<int> status;
    while (!(status = encoder.status())) {
        if (given_up()) throw Error(ErrorCode::Unavailable, "the daemon is ending");
        if (Clock::now() > deadline)
            throw Error(ErrorCode::TimedOut,
                        "encoding the video took more than " + std::to_string(timeout_seconds) + " s");
        std::this_thread::sleep_for(kLook);
    }
    if (*status != 0)
        throw Error(ErrorCode::Unsupported, "/format",
                    "ffmpeg (" + ffmpeg.string() + ") " +
                        (WIFSIGNALED(*status) ? "was ended by signal " + std::to_string(WTERMSIG(*status))
                                              : "ended with status " + std::to_string(WEXITSTATUS(*status))) +
                        "; the daemon's log has what it says. format=png needs none");
}

}  // namespace photond
