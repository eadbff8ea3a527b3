#pragma once
#include <atomic>
#include <functional>

namespace photond {

/// Asked for by one thread, looked at by the threads that render. A method that sees it leaves its pass unfinished.
class CancelToken {
public:
    CancelToken() = default;
    /// Cancelled when `other` is, and from `deadline` on by the clock `now`, in seconds. Both are borrowed.
    CancelToken(const CancelToken& other, const std::function<double()>& now, double deadline)
        : other_(&other), now_(&now), deadline_(deadline) {}

    void cancel() { cancelled_.store(true, std::memory_order_relaxed); }
    /// Once true, always true.
    bool cancelled() const {
        if (seen()) return true;
        if (!other_ || !(other_->cancelled() || (*now_)() >= deadline_)) return false;
        cancelled_.store(true, std::memory_order_relaxed);
        return true;
    }
    /// Whether anybody was told so. A pass during which nobody was is whole, though its deadline has passed since.
    bool seen() const { return cancelled_.load(std::memory_order_relaxed); }

private:
    const CancelToken* other_ = nullptr;
    const std::function<double()>* now_ = nullptr;
    double deadline_ = 0;
    mutable std::atomic<bool> cancelled_{false};
};

}  // namespace photond
