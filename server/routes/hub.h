#pragma once
// Owns every connection while it is not being answered, so that clients that are slow, idle or malicious hold a few
// kilobytes and never a thread (reliability.md, "Measured on Debian 12's packages").

#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "server/routes/connection.h"
#include "server/routes/listener.h"

namespace photond::http {

struct HubSettings {
    HeadLimits head;
    uint32_t max_connections = 4096;
    uint32_t max_surplus = 256;  // connections beyond them that are told so
    double head_timeout_seconds = 10;
    double body_timeout_seconds = 600;
    double idle_timeout_seconds = 60;          // between requests of one connection
    double stall_timeout_seconds = 20;         // a body or an answer that does not move at all
    double short_stall_seconds = 2;            // the same for an answer in memory while others find no room there
    double write_bytes_per_second = 16 << 10;  // a reader slower than that over a whole answer is cut
};

/// What the hub asks of the rest. All but `finished` are called on a hub thread and must not wait.
struct HubCallbacks {
    /// Finds the route, judges everything a head can be judged by; throws Error or Refusal.
    std::function<void(Exchange&)> judge;
    /// A fresh path to spool a body to.
    std::function<std::filesystem::path()> spool_path;
    /// Takes a complete request to the threads that answer it; false when too many wait there.
    std::function<bool(std::unique_ptr<Connection>&)> dispatch;
    /// An answer that became an event stream, `exchange->wire` still to be sent.
    std::function<void(std::unique_ptr<Connection>)> stream;
    /// For the metrics: an exchange is over. Route may be nullptr.
    std::function<void(const Exchange&, double seconds)> finished;
    /// Where answers lie until they are read (answer_memory.h).
    AnswerMemory& memory;
};

class Hub {
public:
    Hub(HubSettings settings, HubCallbacks callbacks, Listener listener);
    ~Hub();
    Hub(const Hub&) = delete;
    Hub& operator=(const Hub&) = delete;

    void start();
    int port() const;
    /// From any thread: an answered connection comes back.
    void answered(std::unique_ptr<Connection> connection);
    /// Accepts nothing more; waits until no answer is under way, at most `grace_seconds`.
    void drain(double grace_seconds);
    /// Closes everything and ends the threads.
    void stop();

private:
    class Loop;
    friend class Loop;

    const HubSettings settings_;
    const HubCallbacks callbacks_;
    std::atomic<int64_t> open_connections_{0};
    std::atomic<int64_t> busy_{0};  // exchanges between head and last byte
    std::atomic<bool> draining_{false};
    const int port_;
    FileDescriptor listener_;      // until start()
    std::unique_ptr<Loop> front_;  // accepts; heads, JSON, small answers
    std::unique_ptr<Loop> bulk_;   // all that touches the disk: uploads and files
};

}  // namespace photond::http
