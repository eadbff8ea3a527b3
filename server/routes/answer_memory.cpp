#include "server/routes/answer_memory.h"

#include <malloc.h>

#include <algorithm>

#include "server/try_later.h"

namespace photond::http {
namespace {

constexpr uint64_t kWorthTrimming_bytes = 4 << 20;
constexpr std::chrono::duration<int> kRetryAfter{1};

}  // namespace

void AnswerMemory::Share::take(uint64_t bytes) {
    const std::lock_guard lock(memory_.mutex_);
    const auto now = std::chrono::steady_clock::now();
    const auto known = memory_.clients_.find(client_);
    const Client of_client = known == memory_.clients_.end() ? Client{} : known->second;
    const uint64_t most = memory_.most_bytes_, little = most / 8;
    // An answer that is not begun yet waits until there may be room again: what is made of it would be for nothing.
    const bool begun = bytes_ > 0;
    const auto is_full = [&](uint64_t held, uint64_t limit, std::chrono::steady_clock::time_point until) {
        return held - bytes_ > little && (held + bytes > limit || (!begun && now < until));
    };
    const bool full = is_full(memory_.bytes_, most, memory_.full_until_);
    if (!full && !is_full(of_client.bytes, most / 2, of_client.full_until)) return add(bytes);
    memory_.was_short_ = true;
    if (begun && full) memory_.full_until_ = now + kRetryAfter;
    if (begun && !full) memory_.clients_[client_].full_until = now + kRetryAfter;
    throw TryLater("answers that wait to be read fill the memory there is for them", kRetryAfter.count());
}

void AnswerMemory::Share::hold(uint64_t bytes) {
    const std::lock_guard lock(memory_.mutex_);
    add(bytes);
}

void AnswerMemory::Share::add(uint64_t bytes) {
    if (bytes == 0) return;
    memory_.clients_[client_].bytes += bytes;
    memory_.bytes_ += bytes;
    bytes_ += bytes;
}

void AnswerMemory::Share::give_back(uint64_t bytes) noexcept {
    bytes = std::min(bytes, bytes_);
    if (bytes == 0) return;
    const std::lock_guard lock(memory_.mutex_);
    const auto of_client = memory_.clients_.find(client_);
    if ((of_client->second.bytes -= bytes) == 0) memory_.clients_.erase(of_client);
    memory_.bytes_ -= bytes;
    memory_.freed_bytes_ += bytes;
    bytes_ -= bytes;
}

uint64_t AnswerMemory::bytes() const {
    const std::lock_guard lock(mutex_);
    return bytes_;
}

void AnswerMemory::trim() {
    {
        const std::lock_guard lock(mutex_);
        if (freed_bytes_ < kWorthTrimming_bytes) return;
        freed_bytes_ = 0;
    }
    malloc_trim(0);
}

}  // namespace photond::http
