#include "server/routes/awaited_jobs.h"

#include <spdlog/spdlog.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>

#include "server/routes/job_wait.h"

namespace photond::http {

namespace {

constexpr size_t kEventsAtOnce = 256;

/// Whether an event says that its job is over.
bool ends_job(const Event& event) {
    if (event.type != "state") return false;
    const nlohmann::json data = nlohmann::json::parse(event.data, nullptr, false);
    return data.is_object() && says_that_it_is_over(data);
}

}  // namespace

AwaitedJobs::AwaitedJobs(EventHub& events, AwaitedJobsCallbacks callbacks)
    : events_(events),
      callbacks_(std::move(callbacks)),
      epoll_(epoll_create1(EPOLL_CLOEXEC)),
      wake_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
      news_(events.make_wake_fd()) {
    if (!epoll_ || !wake_) throw std::system_error(errno, std::generic_category(), "epoll");
}

AwaitedJobs::~AwaitedJobs() { stop(); }

void AwaitedJobs::start() {
    for (const int file : {wake_.get(), news_}) {
        epoll_event event{};
        event.events = EPOLLIN;
        event.data.fd = file;
        epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, file, &event);
    }
    seen_ = events_.last_id();
    thread_ = std::thread([this] { run(); });
}

void AwaitedJobs::wake() {
    const uint64_t one = 1;
    (void)!write(wake_.get(), &one, sizeof one);
}

void AwaitedJobs::hold(std::unique_ptr<Connection> connection) {
    {
        const std::lock_guard lock(mutex_);
        inbox_.push_back(std::move(connection));
    }
    wake();
}

void AwaitedJobs::let_go() {
    letting_go_ = true;
    wake();
}

void AwaitedJobs::stop() {
    stopping_ = true;
    wake();
    if (thread_.joinable()) thread_.join();
    held_.clear();
    inbox_.clear();
}

void AwaitedJobs::run() {
    std::array<epoll_event, 256> ready{};
    while (!stopping_) {
        const int n =
            epoll_wait(epoll_.get(), ready.data(), static_cast<int>(ready.size()), milliseconds_to_next_end());
        for (int i = 0; i < n; ++i) {
            const int file = ready[static_cast<size_t>(i)].data.fd;
            uint64_t count = 0;
            if (file == wake_.get() || file == news_)
                (void)!read(file, &count, sizeof count);
            else
                client_left(file);
        }
        take_inbox();
        see_new_events();
        const auto now = Clock::now();
        std::vector<int> over;
        for (const auto& [socket, connection] : held_)
            if (letting_go_ || connection->exchange->awaits->until <= now) over.push_back(socket);
        for (const int socket : over) begin_anew(socket);
    }
}

/// What happened before they came here is asked for one by one.
void AwaitedJobs::take_inbox() {
    std::vector<std::unique_ptr<Connection>> arrived;
    {
        const std::lock_guard lock(mutex_);
        arrived.swap(inbox_);
    }
    for (auto& connection : arrived) {
        const int socket = connection->socket.get();
        epoll_event event{};
        event.events = EPOLLRDHUP;
        event.data.fd = socket;
        epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, socket, &event);
        connection->exchange->memory.reset();
        const AwaitJob& awaits = *(held_[socket] = std::move(connection))->exchange->awaits;
        for (uint64_t after = awaits.after_event;;) {
            const std::vector<Event> page = events_.after(after, awaits.job, kEventsAtOnce);
            if (std::any_of(page.begin(), page.end(), ends_job)) {
                begin_anew(socket);
                break;
            }
            if (page.size() < kEventsAtOnce) break;
            after = page.back().id;
        }
    }
}

void AwaitedJobs::see_new_events() {
    for (;;) {
        const std::vector<Event> page = events_.after(seen_, "", kEventsAtOnce);
        if (page.empty()) return;
        seen_ = page.back().id;
        for (const Event& event : page) {
            if (held_.empty() || !ends_job(event)) continue;
            std::vector<int> over;
            for (const auto& [socket, connection] : held_)
                if (connection->exchange->awaits->job == event.job) over.push_back(socket);
            for (const int socket : over) begin_anew(socket);
        }
    }
}

void AwaitedJobs::begin_anew(int socket) {
    std::unique_ptr<Connection> connection = std::move(held_.extract(socket).mapped());
    epoll_ctl(epoll_.get(), EPOLL_CTL_DEL, socket, nullptr);
    Exchange& exchange = *connection->exchange;
    exchange.call.awaited = Awaited{exchange.awaits->job, letting_go_ ? Clock::now() : exchange.awaits->until};
    exchange.awaits.reset();
    if (callbacks_.again(connection)) return;
    exchange.refusal.emplace(too_many_waiting());
    refuses_.answer(exchange, !connection->close_after);
    callbacks_.answered(std::move(connection));
}

void AwaitedJobs::client_left(int socket) {
    const auto found = held_.find(socket);
    if (found == held_.end()) return;
    const std::unique_ptr<Connection> connection = std::move(found->second);
    held_.erase(found);
    callbacks_.gone();
    if (!connection->exchange->awaits->client_left) return;
    try {
        connection->exchange->awaits->client_left();
    } catch (const std::exception& error) {  // most often it is over meanwhile
        spdlog::info("a job whose client has left: {}", error.what());
    }
}

int AwaitedJobs::milliseconds_to_next_end() const {
    if (held_.empty()) return -1;
    Clock::time_point next = Clock::time_point::max();
    for (const auto& [socket, connection] : held_) next = std::min(next, connection->exchange->awaits->until);
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(next - Clock::now()).count();
    return static_cast<int>(std::clamp<int64_t>(left, 0, 3'600'000));
}

}  // namespace photond::http
