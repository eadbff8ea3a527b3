#include "server/routes/event_streams.h"

#include <spdlog/spdlog.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>

namespace photond::http {
namespace {

constexpr auto kHeartbeat = std::chrono::seconds(15);  // keeps proxies from closing a quiet stream
constexpr auto kStall = std::chrono::seconds(30);      // a reader that takes nothing for so long is dropped
constexpr auto kTick = std::chrono::seconds(1);
constexpr size_t kMaxBacklog = 256 << 10;  // bytes; a reader further behind is dropped, and may resume
constexpr size_t kPage = 256;              // events at once for one that catches up

}  // namespace

std::string event_text(const Event& event) {
    return "event: " + event.type + "\nid: " + std::to_string(event.id) + "\ndata: " + event.data + "\n\n";
}

std::string status_event_text(const nlohmann::json& status) {
    return "event: status\ndata: " + status.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n\n";
}

struct EventStreams::Stream {
    std::unique_ptr<Connection> connection;
    std::string job;
    uint64_t last_id = 0;
    bool live = false;  // has all events up to spread_
    std::string out;
    bool waits_to_write = false;
    Clock::time_point last_sent = Clock::now();
    Clock::time_point last_status = Clock::now();  // it begins with one
};

EventStreams::EventStreams(EventHub& events, std::function<void(int)> clients_changed,
                           std::function<nlohmann::json()> status)
    : events_(events),
      clients_changed_(std::move(clients_changed)),
      status_(std::move(status)),
      epoll_(epoll_create1(EPOLL_CLOEXEC)),
      wake_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
      news_(events.make_wake_fd()) {
    if (!epoll_ || !wake_) throw std::system_error(errno, std::generic_category(), "epoll");
}

EventStreams::~EventStreams() { stop(); }

void EventStreams::start() {
    for (const int file : {wake_.get(), news_}) {
        epoll_event event{};
        event.events = EPOLLIN;
        event.data.fd = file;
        epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, file, &event);
    }
    spread_ = events_.last_id();
    thread_ = std::thread([this] { run(); });
}

void EventStreams::adopt(std::unique_ptr<Connection> connection) {
    {
        const std::lock_guard lock(mutex_);
        inbox_.push_back(std::move(connection));
    }
    const uint64_t one = 1;
    (void)!write(wake_.get(), &one, sizeof one);
}

void EventStreams::stop() {
    stopping_ = true;
    const uint64_t one = 1;
    (void)!write(wake_.get(), &one, sizeof one);
    if (thread_.joinable()) thread_.join();
    for (size_t i = 0; i < streams_.size(); ++i) clients_changed_(-1);
    streams_.clear();
}

void EventStreams::run() {
    std::array<epoll_event, 256> ready{};
    auto next_tick = Clock::now() + kTick;
    while (!stopping_) {
        const int n = epoll_wait(epoll_.get(), ready.data(), static_cast<int>(ready.size()), 1000);
        bool news = false;
        for (int i = 0; i < n; ++i) {
            const epoll_event& event = ready[static_cast<size_t>(i)];
            const int file = event.data.fd;
            uint64_t count = 0;
            if (file == wake_.get() || file == news_) {
                (void)!read(file, &count, sizeof count);
                news = news || file == news_;
                continue;
            }
            const auto found = streams_.find(file);
            if (found == streams_.end()) continue;
            if (event.events & EPOLLIN) {  // clients have nothing to say here; most often this is the end
                std::array<char, 1024> ignored{};
                const ssize_t got = recv(file, ignored.data(), ignored.size(), MSG_DONTWAIT);
                if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) {
                    drop(file);
                    continue;
                }
            }
            if (event.events & (EPOLLERR | EPOLLHUP)) {
                drop(file);
                continue;
            }
            if (event.events & EPOLLOUT) flush(*found->second);
        }
        take_inbox();
        if (news) spread_new_events();
        if (Clock::now() >= next_tick) {
            next_tick = Clock::now() + kTick;
            tick();
            spread_status();
        }
    }
}

void EventStreams::take_inbox() {
    std::vector<std::unique_ptr<Connection>> arrived;
    {
        const std::lock_guard lock(mutex_);
        arrived.swap(inbox_);
    }
    for (auto& connection : arrived) {
        auto stream = std::make_unique<Stream>();
        stream->out = std::move(connection->exchange->wire);
        stream->job = connection->exchange->reply.events->job;
        stream->last_id = connection->exchange->reply.events->last_id;
        connection->exchange.reset();
        connection->in = {};
        stream->connection = std::move(connection);
        const int socket = stream->connection->socket.get();
        epoll_event event{};
        event.events = EPOLLIN;
        event.data.fd = socket;
        epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, socket, &event);
        Stream& held = *stream;
        streams_[socket] = std::move(stream);
        clients_changed_(+1);
        flush(held);
    }
}

// Events are asked for once and written out once for all streams that are up to date; one that lags, asks for itself.
void EventStreams::spread_new_events() {
    for (;;) {
        const std::vector<Event> page = events_.after(spread_, "", kPage);
        if (page.empty()) return;
        spread_ = page.back().id;
        std::vector<std::string> texts;
        texts.reserve(page.size());
        for (const Event& event : page) texts.push_back(event_text(event));
        std::vector<int> sockets;
        sockets.reserve(streams_.size());
        for (auto& [socket, stream] : streams_) {
            if (!stream->live) continue;
            bool any = false;
            for (size_t i = 0; i < page.size(); ++i) {
                if (page[i].id <= stream->last_id || (!stream->job.empty() && stream->job != page[i].job)) continue;
                stream->out += texts[i];
                any = true;
            }
            stream->last_id = std::max(stream->last_id, spread_);
            if (any) sockets.push_back(socket);
        }
        for (const int socket : sockets)
            if (const auto found = streams_.find(socket); found != streams_.end()) flush(*found->second);
    }
}

void EventStreams::catch_up(Stream& stream) {
    const std::vector<Event> page = events_.after(stream.last_id, stream.job, kPage);
    for (const Event& event : page) {
        if (event.id > spread_) break;  // the others get these too, all at once
        stream.out += event_text(event);
        stream.last_id = event.id;
    }
    if (page.size() < kPage || page.back().id > spread_) {
        stream.live = true;
        stream.last_id = std::max(stream.last_id, spread_);
    }
}

void EventStreams::flush(Stream& stream) {
    const int socket = stream.connection->socket.get();
    for (;;) {
        if (stream.out.empty()) {
            if (!stream.live) catch_up(stream);
            if (stream.out.empty() && stream.live) break;
            if (stream.out.empty()) continue;
        }
        const ssize_t n = send(socket, stream.out.data(), stream.out.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0 && errno != EAGAIN && errno != EWOULDBLOCK) return drop(socket);
        if (n < 0) break;
        stream.out.erase(0, static_cast<size_t>(n));
        stream.last_sent = Clock::now();
    }
    if (stream.out.size() > kMaxBacklog) return drop(socket);
    if (stream.out.empty() == !stream.waits_to_write) return;
    stream.waits_to_write = !stream.out.empty();
    epoll_event event{};
    event.events = EPOLLIN | (stream.waits_to_write ? static_cast<uint32_t>(EPOLLOUT) : 0u);
    event.data.fd = socket;
    epoll_ctl(epoll_.get(), EPOLL_CTL_MOD, socket, &event);
}

void EventStreams::tick() {
    const auto now = Clock::now();
    std::vector<int> quiet, stalled;
    for (const auto& [socket, stream] : streams_) {
        if (!stream->out.empty() && now - stream->last_sent > kStall) stalled.push_back(socket);
        if (stream->out.empty() && now - stream->last_sent > kHeartbeat) quiet.push_back(socket);
    }
    for (const int socket : stalled) drop(socket);
    for (const int socket : quiet) {
        Stream& stream = *streams_[socket];
        stream.out = ": still here\n\n";
        flush(stream);
    }
}

// To those that have taken all they were sent: for one that lags, the next one will do.
void EventStreams::spread_status() {
    const auto now = Clock::now();
    std::vector<int> due;
    for (const auto& [socket, stream] : streams_)
        if (stream->job.empty() && stream->live && stream->out.empty() && now - stream->last_status >= kTick)
            due.push_back(socket);
    if (due.empty()) return;
    std::string text;
    try {
        text = status_event_text(status_());
    } catch (const std::exception& error) {  // the events themselves go on
        spdlog::warn("the status cannot be told: {}", error.what());
        return;
    }
    for (const int socket : due) {
        Stream& stream = *streams_[socket];
        stream.last_status = now;
        stream.out = text;
        flush(stream);
    }
}

void EventStreams::drop(int socket) {
    streams_.erase(socket);
    clients_changed_(-1);
}

}  // namespace photond::http
