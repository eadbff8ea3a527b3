#pragma once
// The bytes of answers that are in memory, over all clients: those being made and those that nobody has read yet.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>
#include <unordered_map>
#include <utility>

namespace photond::http {

/// Thread-safe; outlives its shares.
class AnswerMemory {
public:
    explicit AnswerMemory(uint64_t most_bytes) : most_bytes_(most_bytes) {}

    /// What one answer holds.
    class Share {
    public:
        Share(AnswerMemory& memory, std::string client) : memory_(memory), client_(std::move(client)) {}
        Share(const Share&) = delete;
        Share& operator=(const Share&) = delete;
        ~Share() { give_back(bytes_); }

        /// Throws TryLater where there is no room (nothing taken: where there is none to begin with). No client may
        /// fill more than half of it, so that it stands in nobody else's way; but an answer beside which there is
        /// little else may be as long as it is.
        void take(uint64_t bytes);
        /// The same where there has to be room.
        void hold(uint64_t bytes);
        void give_back(uint64_t bytes) noexcept;
        uint64_t bytes() const { return bytes_; }

    private:
        void add(uint64_t bytes);  // under the lock

        AnswerMemory& memory_;
        const std::string client_;
        uint64_t bytes_ = 0;
    };

    uint64_t bytes() const;
    uint64_t most_bytes() const { return most_bytes_; }
    /// Whether an answer found no room since this was asked last.
    bool was_short() { return was_short_.exchange(false); }
    /// Gives back to the system what answers have freed, where that is worth the while: the allocator would keep it.
    /// To be called now and then.
    void trim();

private:
    struct Client {
        uint64_t bytes = 0;
        std::chrono::steady_clock::time_point full_until{};
    };

    const uint64_t most_bytes_;
    mutable std::mutex mutex_;
    uint64_t bytes_ = 0;
    uint64_t freed_bytes_ = 0;  // since the last trim()
    std::chrono::steady_clock::time_point full_until_{};
    std::unordered_map<std::string, Client> clients_;  // those that have any
    std::atomic<bool> was_short_{false};
};

}  // namespace photond::http
