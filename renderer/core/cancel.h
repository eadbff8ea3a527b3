#pragma once
#include <atomic>

namespace photond {

/// Asked for by one thread, looked at by the threads that render. A method that sees it leaves its pass unfinished.
class CancelToken {
public:
    void cancel() { cancelled_.store(true, std::memory_order_relaxed); }
    bool cancelled() const { return cancelled_.load(std::memory_order_relaxed); }

private:
    std::atomic<bool> cancelled_{false};
};

}  // namespace photond
