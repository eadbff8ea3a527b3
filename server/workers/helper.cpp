#include "server/workers/helper.h"

#include <spdlog/spdlog.h>

#include "protocol/error.h"
#include "protocol/worker_messages.h"
#include "server/helper_wait.h"
#include "server/processor_time.h"

namespace photond {

namespace {

using Clock = std::chrono::steady_clock;

constexpr int kAttempts = 3;                       // of a request whose helper is killed from outside
constexpr uint64_t kServedBeforeRecycling = 5000;  // small leaks in image libraries end here
constexpr std::chrono::seconds kStartPatience{20};
constexpr std::chrono::milliseconds kBetweenLooks{500};  // at the processor time that a request has taken

}  // namespace

Helper::Helper(ProcessOptions options, double request_timeout_seconds, std::function<void()> answered,
               std::function<void(const ProcessExit&)> exited)
    : timeout_seconds_(request_timeout_seconds),
      background_(options.priority.background),
      memory_limit_bytes_(options.memory_limit_bytes),
      answered_(std::move(answered)),
      exited_(std::move(exited)) {
    process_ = std::make_unique<WorkerProcess>(
        std::move(options),
        WorkerProcess::Callbacks{.message = [this](const nlohmann::json& text) { message(text); },
                                 .exited = [this](const ProcessExit& exit) { process_exited(exit); },
                                 .tick = [] {}});
}

Helper::~Helper() {
    begin_stop(Clock::now());
    join();
}

bool Helper::ready() const {
    const std::lock_guard lock(mutex_);
    return ready_;
}

uint64_t Helper::restarts() const {
    const std::lock_guard lock(mutex_);
    return restarts_;
}

void Helper::begin_stop(Clock::time_point deadline) {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    changed_.notify_all();
    process_->begin_stop(deadline);
}

void Helper::message(const nlohmann::json& message) {
    const bool hello = is_message<HelloMessage>(message);
    auto reply = message_as<ReplyMessage>(message);
    if (reply && !reply->failure && !reply->result.is_object())
        throw Error(ErrorCode::WrongType, "/result", "a reply has neither a result nor a failure");
    {
        const std::lock_guard lock(mutex_);
        if (hello) ready_ = true;
        // A reply to a request that has been given up is nobody's.
        if (reply && reply->request == request_) reply_ = std::move(reply);
    }
    changed_.notify_all();
    if (hello) answered_();
}

void Helper::process_exited(const ProcessExit& exit) {
    {
        const std::lock_guard lock(mutex_);
        ready_ = false;
        served_ = 0;
        exit_ = exit;
        ++restarts_;
    }
    changed_.notify_all();
    exited_(exit);
}

std::optional<double> Helper::busy_seconds() const {
    const int64_t asked_at = asked_at_;
    if (asked_at == 0) return std::nullopt;
    return std::chrono::duration<double>(Clock::now() - Clock::time_point(Clock::duration(asked_at))).count();
}

Helper::Patience Helper::patience(std::optional<double> most_processor_seconds) const {
    Patience patience{timeout_seconds_, most_processor_seconds};
    if (background_) {
        patience.clock_seconds *= kBackgroundPatience;
        patience.processor_seconds = std::min(timeout_seconds_, most_processor_seconds.value_or(timeout_seconds_));
    }
    return patience;
}

std::optional<ReplyMessage> Helper::attempt(std::unique_lock<std::mutex>& lock, nlohmann::json& request,
                                            const Patience& patience) {
    const auto start_patience = (background_ ? kBackgroundPatience : 1) * kStartPatience;
    if (!changed_.wait_for(lock, start_patience, [this] { return ready_ || stopping_; }) || stopping_)
        throw Error(ErrorCode::Unavailable, stopping_ ? "the daemon is stopping" : "the helper process is not ready");
    add_members(request, RequestNumber{++request_});
    reply_.reset();
    exit_.reset();
    lock.unlock();
    const bool sent = process_->send(request);
    lock.lock();
    if (!sent && !exit_) {
        // Its end is about to be reported.
        changed_.wait_for(lock, kStartPatience, [this] { return exit_ || stopping_; });
        return std::nullopt;
    }
    const std::string exceeded = wait_for_end(lock, patience);
    ++request_;  // whatever is said about it from now on is ignored
    if (reply_) {
        if (++served_ >= kServedBeforeRecycling) {
            ready_ = false;
            lock.unlock();
            process_->recycle();
            lock.lock();
        }
        return std::move(reply_);
    }
    if (!exceeded.empty()) {
        ready_ = false;
        lock.unlock();
        process_->kill();
        lock.lock();
        throw Error(ErrorCode::TimedOut, "not done within " + exceeded);
    }
    if (stopping_) throw Error(ErrorCode::Unavailable, "the daemon is stopping");
    switch (exit_->cause) {
        case ExitCause::Lost:
        case ExitCause::Ordered: return std::nullopt;
        case ExitCause::OutOfMemory:
            throw Error(ErrorCode::OutOfMemory,
                        "takes more memory than the " + std::to_string(memory_limit_bytes_) + " bytes allowed");
        case ExitCause::NoSpace: throw Error(ErrorCode::NoSpace, "the helper process passed its file size limit");
        case ExitCause::Hung: throw Error(ErrorCode::TimedOut, "the helper process hung: " + exit_->text);
        case ExitCause::DeviceLost:  // it has none
        case ExitCause::Crashed: break;
    }
    throw Error(ErrorCode::WorkerCrashed, "the helper process " + exit_->text);
}

std::string Helper::wait_for_end(std::unique_lock<std::mutex>& lock, const Patience& patience) {
    const auto over = [this] { return reply_ || exit_ || stopping_; };
    const auto seconds = [](double seconds) { return nlohmann::json(seconds).dump() + " s"; };
    const auto deadline = Clock::now() + std::chrono::milliseconds(static_cast<int64_t>(patience.clock_seconds * 1000));
    if (!patience.processor_seconds)
        return changed_.wait_until(lock, deadline, over) ? "" : seconds(patience.clock_seconds);
    const pid_t process = pid();
    const double before = processor_seconds_of(process).value_or(0);
    while (!changed_.wait_for(lock, kBetweenLooks, over)) {
        if (processor_seconds_of(process).value_or(before) - before >= *patience.processor_seconds)
            return seconds(*patience.processor_seconds) + " of processor time";
        if (Clock::now() >= deadline) return seconds(patience.clock_seconds);
    }
    return "";
}

void Helper::distrust(const Error& error) {
    {
        const std::lock_guard lock(mutex_);
        ready_ = false;
    }
    process_->kill();
    throw Error(ErrorCode::WorkerCrashed, std::string("the helper process gave a wrong answer: ") + error.what());
}

nlohmann::json Helper::call(nlohmann::json request, std::optional<double> most_processor_seconds) {
    if (!may_wait_for_helper()) throw NeedsHelper();
    std::unique_lock lock(mutex_);
    const uint64_t ticket = next_ticket_++;
    changed_.wait(lock, [&] { return serving_ == ticket; });
    // Whoever is next is let in whatever happens here.
    struct Turn {
        Helper& helper;
        ~Turn() {
            helper.asked_at_ = 0;
            ++helper.serving_;
            helper.changed_.notify_all();
        }
    } const turn{*this};
    asked_at_ = Clock::now().time_since_epoch().count();
    for (int i = 0; i < kAttempts; ++i) {
        auto reply = attempt(lock, request, patience(most_processor_seconds));
        if (!reply) continue;
        if (reply->failure) throw error_of(reply->failure);
        return std::move(reply->result);
    }
    throw Error(ErrorCode::WorkerLost, "the helper process was lost " + std::to_string(kAttempts) + " times");
}

}  // namespace photond
