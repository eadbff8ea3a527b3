#include "protocol/message_channel.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <nlohmann/json.hpp>

#include "protocol/error.h"
#include "protocol/strict_json.h"

namespace photond {

using nlohmann::json;

namespace {

/// Messages come from our own processes, but a worker may have been taken over by a scene: bounded all the same.
constexpr JsonLimits kMessageLimits{.max_bytes = kMaxMessageBytes, .max_depth = 32, .max_values = 4'000'000};

bool wait_for(int socket, short events, int timeout_ms) {
    pollfd descriptor{socket, events, 0};
    return poll(&descriptor, 1, timeout_ms) > 0;
}

}  // namespace

bool MessageChannel::send(const json& message) {
    std::string line = message.dump(-1, ' ', false, json::error_handler_t::replace);
    line += '\n';
    const std::lock_guard lock(write_mutex_);
    for (size_t sent = 0; sent < line.size();) {
        if (closed_) return false;
        const ssize_t n = ::send(socket_, line.data() + sent, line.size() - sent, MSG_NOSIGNAL);
        if (n > 0) {
            sent += static_cast<size_t>(n);
        } else if (n < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) {
            wait_for(socket_, POLLOUT, -1);
        } else if (n < 0 && errno != EINTR) {
            closed_ = true;
        }
    }
    return true;
}

std::optional<json> MessageChannel::receive(int timeout_ms) {
    using Clock = std::chrono::steady_clock;
    const Clock::time_point deadline = Clock::now() + std::chrono::milliseconds(timeout_ms);
    size_t searched = 0;
    while (!closed_) {
        const size_t end = buffer_.find('\n', searched);
        if (end != std::string::npos) {
            json message;
            try {
                message = parse_strict_json(std::string_view(buffer_).substr(0, end), kMessageLimits);
            } catch (const Error&) {
                message = nullptr;
            }
            buffer_.erase(0, end + 1);
            if (message.is_object()) return message;
            closed_ = true;
            break;
        }
        searched = buffer_.size();
        if (buffer_.size() > kMaxMessageBytes) {
            closed_ = true;
            break;
        }
        int wait_ms = -1;
        if (timeout_ms >= 0) {
            // Rounded up, so that a wait of less than a millisecond is not a busy loop.
            const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
            wait_ms = static_cast<int>(std::max<int64_t>(0, left.count()));
        }
        if (!wait_for(socket_, POLLIN, wait_ms)) {
            if (timeout_ms >= 0 && Clock::now() >= deadline) return std::nullopt;
            continue;
        }
        char chunk[65536];
        const ssize_t n = recv(socket_, chunk, sizeof chunk, MSG_DONTWAIT);
        if (n > 0)
            buffer_.append(chunk, static_cast<size_t>(n));
        else if (n == 0 || (errno != EINTR && errno != EAGAIN && errno != EWOULDBLOCK))
            closed_ = true;
    }
    return std::nullopt;
}

}  // namespace photond
