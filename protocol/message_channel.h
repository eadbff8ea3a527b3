#pragma once
// How the daemon and its worker processes reach each other: one JSON object a line over a socket pair. What the objects
// say is in worker_messages.h and helper_messages.h.
//
// The worker's command line: photond-worker --device cpu|gpu:N|none --memory-limit BYTES --threads N (0: all cores),
// and for a GPU --pipeline-cache FILE. photond-worker --device list says DevicesMessage and ends.
// photond-worker --device video --video-program FFMPEG is told once what to do, and ends when it is done
// (video_message.h).
//
// A process whose peer has closed the socket ends at once. The kernel kills a worker when the daemon's THREAD that
// started it ends (PR_SET_PDEATHSIG), so it must be started from a thread that lives as long as the daemon, and
// directly, not by a shell.

#include <atomic>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace photond {

inline constexpr size_t kMaxMessageBytes = size_t{16} << 20;
inline constexpr int kWorkerSocket = 3;      // the worker's end of the socket pair
inline constexpr int kDeviceLostStatus = 3;  // exit status of a worker whose GPU is lost

/// Line-framed JSON over a stream socket. Reads are buffered; writes are whole lines under a lock.
class MessageChannel {
public:
    explicit MessageChannel(int socket) : socket_(socket) {}

    /// Writes one message; false when the peer is gone. Text that is not UTF-8 is replaced.
    bool send(const nlohmann::json& message);
    /// The next message, waiting at most `timeout_ms` (-1: for ever). Empty on timeout; `closed()` tells the end.
    /// A line that is not a JSON object, or longer than 16 MiB, closes the channel.
    std::optional<nlohmann::json> receive(int timeout_ms);
    bool closed() const { return closed_; }
    int socket() const { return socket_; }

private:
    int socket_;
    std::atomic<bool> closed_{false};
    std::string buffer_;
    std::mutex write_mutex_;
};

}  // namespace photond
