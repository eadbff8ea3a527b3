#include "clients/cli/interrupt.h"

#include <unistd.h>
#include <csignal>

#include "clients/cli/failure.h"

namespace photond::cli {

namespace {

using Clock = std::chrono::steady_clock;

// A handler may touch little: it counts; the watcher looks at the count.
volatile std::sig_atomic_t g_signals = 0;

extern "C" void note_signal(int) {
    if (g_signals != 0) _exit(static_cast<int>(ExitCode::Interrupted));
    g_signals = 1;
}

void handle_signals_with(void (*handler)(int)) {
    struct sigaction action {};
    action.sa_handler = handler;
    action.sa_flags = SA_RESTART;
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
}

constexpr std::chrono::milliseconds kLookEvery{50};  // the delay between Ctrl-C and its effect

}  // namespace

Interrupt::Interrupt() : watcher_([this] { watch(); }) {
    g_signals = 0;
    handle_signals_with(note_signal);
}

Interrupt::~Interrupt() {
    handle_signals_with(SIG_DFL);
    {
        const std::lock_guard lock(mutex_);
        closing_ = true;
    }
    changed_.notify_all();
    watcher_.join();
}

void Interrupt::set_deadline(std::chrono::duration<double> span) {
    const std::lock_guard lock(mutex_);
    deadline_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(span);
}

void Interrupt::acknowledge() {
    const std::lock_guard lock(mutex_);
    deadline_.reset();
    g_signals = 0;
    cause_ = Cause::None;
}

bool Interrupt::sleep(std::chrono::duration<double> span) {
    std::unique_lock lock(mutex_);
    return !changed_.wait_for(lock, span, [this] { return cause_ != Cause::None; });
}

void Interrupt::watch() {
    std::unique_lock lock(mutex_);
    while (!closing_) {
        if (cause_ == Cause::None) {
            if (g_signals != 0)
                cause_ = Cause::Signal;
            else if (deadline_ && Clock::now() >= *deadline_)
                cause_ = Cause::Deadline;
            if (cause_ != Cause::None) changed_.notify_all();
        }
        // Repeated, because an exchange that had not quite begun would miss a single call.
        if (cause_ != Cause::None && stopper_) stopper_->stop_();
        changed_.wait_for(lock, kLookEvery, [this] { return closing_; });
    }
}

Interrupt::Stopper::Stopper(Interrupt& interrupt, std::function<void()> stop)
    : interrupt_(interrupt), stop_(std::move(stop)) {
    const std::lock_guard lock(interrupt_.mutex_);
    outer_ = interrupt_.stopper_;
    interrupt_.stopper_ = this;
}

Interrupt::Stopper::~Stopper() {
    const std::lock_guard lock(interrupt_.mutex_);
    interrupt_.stopper_ = outer_;
}

}  // namespace photond::cli
