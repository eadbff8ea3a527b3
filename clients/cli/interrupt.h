#pragma once
// Ctrl-C and --timeout: both cut short whatever waits, and leave it to the command to say what becomes of its job.

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

namespace photond::cli {

/// While it lives, the first SIGINT or SIGTERM is noted instead of ending the program; a second ends it at once with
/// exit code 130. One at a time.
class Interrupt {
public:
    enum class Cause : unsigned char { None, Signal, Deadline };

    Interrupt();
    ~Interrupt();
    Interrupt(const Interrupt&) = delete;
    Interrupt& operator=(const Interrupt&) = delete;

    Cause cause() const { return cause_; }
    /// Ends every wait once this span has passed; counted from now.
    void set_deadline(std::chrono::duration<double> span);
    /// Forgets the interrupt (and the deadline), so that requests work again: to cancel a job, say.
    void acknowledge();
    /// Waits; false when it was cut short.
    bool sleep(std::chrono::duration<double> span);

    /// Calls `stop` (from another thread, again and again) while an interrupt stands unacknowledged and this lives.
    class Stopper {
    public:
        Stopper(Interrupt& interrupt, std::function<void()> stop);
        ~Stopper();
        Stopper(const Stopper&) = delete;
        Stopper& operator=(const Stopper&) = delete;

    private:
        Interrupt& interrupt_;
        std::function<void()> stop_;
        Stopper* outer_;
        friend class Interrupt;
    };

private:
    void watch();

    std::atomic<Cause> cause_ = Cause::None;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::optional<std::chrono::steady_clock::time_point> deadline_;
    Stopper* stopper_ = nullptr;  // the innermost one
    bool closing_ = false;
    std::thread watcher_;
};

}  // namespace photond::cli
