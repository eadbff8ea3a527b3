#include "server/routes/hub.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/sendfile.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <mutex>
#include <system_error>
#include <thread>
#include <unordered_map>

#include "server/routes/answerer.h"
#include "server/steady_seconds.h"

namespace photond::http {
namespace {

using State = Connection::State;

constexpr int kTick_ms = 200;               // resolution of deadlines
constexpr size_t kReadBytes = 64 << 10;     // at once
constexpr int kReadsAnEvent = 4;            // then the next connection has its turn
constexpr size_t kSendFileBytes = 1 << 20;  // likewise
constexpr double kLinger_seconds = 2;
constexpr double kSurplusHead_seconds = 1;   // for a connection beyond the limit to say what it wants
constexpr double kIdleWhenFull_seconds = 5;  // a connection between requests, while others find no place

std::string address_text(const sockaddr_storage& address) {
    std::array<char, INET6_ADDRSTRLEN> text{};
    if (address.ss_family == AF_INET)
        inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in&>(address).sin_addr, text.data(), text.size());
    else if (address.ss_family == AF_INET6)
        inet_ntop(AF_INET6, &reinterpret_cast<const sockaddr_in6&>(address).sin6_addr, text.data(), text.size());
    return text.data();
}

}  // namespace

// One thread with its epoll set. Connections move between loops and pools by their unique_ptr; a connection is in the
// epoll set only while a loop owns it.
class Hub::Loop {
public:
    Loop(Hub& hub, FileDescriptor listener) : hub_(hub), listener_(std::move(listener)) {
        epoll_ = FileDescriptor(epoll_create1(EPOLL_CLOEXEC));
        wake_ = FileDescriptor(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC));
        if (!epoll_ || !wake_) throw std::system_error(errno, std::generic_category(), "epoll");
        watch(wake_.get(), EPOLLIN, EPOLL_CTL_ADD);
        if (listener_) watch(listener_.get(), EPOLLIN, EPOLL_CTL_ADD), keep_reserve();
    }
    ~Loop() { stop(); }

    void begin() {
        thread_ = std::thread([this] { run(); });
    }

    void post(std::unique_ptr<Connection> connection) {
        {
            const std::lock_guard lock(mutex_);
            inbox_.push_back(std::move(connection));
        }
        wake();
    }
    void wake() {
        const uint64_t one = 1;
        (void)!write(wake_.get(), &one, sizeof one);
    }
    void stop() {
        stopping_ = true;
        wake();
        if (thread_.joinable()) thread_.join();
    }

private:
    void watch(int file, uint32_t events, int operation) {
        epoll_event event{};
        event.events = events;
        event.data.fd = file;
        epoll_ctl(epoll_.get(), operation, file, &event);
    }
    void set_interest(Connection& connection, uint32_t events) {
        if (connection.interest == events) return;
        watch(connection.socket.get(), events, connection.interest == 0 ? EPOLL_CTL_ADD : EPOLL_CTL_MOD);
        connection.interest = events;
    }

    void run() {
        std::array<epoll_event, 256> events{};
        Clock::time_point next_tick = Clock::now();
        while (!stopping_) {
            const int ready = epoll_wait(epoll_.get(), events.data(), static_cast<int>(events.size()), kTick_ms);
            for (int i = 0; i < ready; ++i) {
                const int file = events[static_cast<size_t>(i)].data.fd;
                if (file == wake_.get()) {
                    uint64_t count = 0;
                    (void)!read(file, &count, sizeof count);
                } else if (file == listener_.get()) {
                    accept_some();
                } else if (const auto found = connections_.find(file); found != connections_.end()) {
                    serve(*found->second);
                }
            }
            take_inbox();
            if (const auto now = Clock::now(); now >= next_tick) {
                next_tick = now + std::chrono::milliseconds(kTick_ms);
                tick(now);
            }
        }
    }

    void take_inbox() {
        std::vector<std::unique_ptr<Connection>> arrived;
        {
            const std::lock_guard lock(mutex_);
            arrived.swap(inbox_);
        }
        for (auto& connection : arrived) {
            Connection& held = *connection;
            connections_[held.socket.get()] = std::move(connection);
            if (held.state == State::Body) {
                body_arrived(held);
            } else if (held.state == State::Write) {
                begin_write(held);
            } else {
                expect_head(held, hub_.settings_.idle_timeout_seconds);
                if (!held.in.empty()) head_arrived(held);
            }
        }
    }

    void tick(Clock::time_point now) {
        if (listener_ && !reserve_) keep_reserve();
        if (listener_ && hub_.draining_) {
            listener_.reset();  // leaves the epoll set by closing
        } else if (listener_ && !accepting_) {
            accepting_ = true;
            watch(listener_.get(), EPOLLIN, EPOLL_CTL_ADD);
        }
        // Answers in memory are all sent by the front.
        const bool memory_is_short = this == hub_.front_.get() && hub_.callbacks_.memory.was_short();
        if (this == hub_.bulk_.get()) hub_.callbacks_.memory.trim();
        std::vector<Connection*> late;
        const bool full = hub_.open_connections_ >= hub_.settings_.max_connections;
        for (const auto& [file, connection] : connections_) {
            const bool idle = connection->state == State::Head && connection->in.empty();
            const bool in_the_way = full && now - connection->since >= steady_seconds(kIdleWhenFull_seconds);
            if (now >= connection->deadline || now >= connection->stall_limit ||
                (idle && (hub_.draining_ || in_the_way)) || (memory_is_short && stands_in_the_way(*connection, now)))
                late.push_back(connection.get());
        }
        for (Connection* connection : late) {
            if (connection->state == State::Held) {
                begin_write(*connection);
                continue;
            }
            if (connection->surplus && connection->state == State::Head) {
                refuse_surplus(*connection);
                continue;
            }
            const bool asked =
                connection->state == State::Body || (connection->state == State::Head && !connection->in.empty());
            if (!asked) {
                close(*connection);
                continue;
            }
            refuse(*connection, Error(ErrorCode::RequestTimeout, connection->state == State::Head
                                                                     ? "the request's head did not arrive in time"
                                                                     : "the request's body did not arrive in time"));
        }
    }

    void keep_reserve() { reserve_ = FileDescriptor(open("/dev/null", O_RDONLY | O_CLOEXEC)); }

    // Whether it holds an answer that nobody reads.
    bool stands_in_the_way(const Connection& connection, Clock::time_point now) const {
        if (connection.state != State::Write || !connection.exchange->memory) return false;
        const auto unread_since = connection.stall_limit - steady_seconds(hub_.settings_.stall_timeout_seconds);
        return connection.exchange->memory->bytes() > 0 &&
               now - unread_since >= steady_seconds(hub_.settings_.short_stall_seconds);
    }

    // --- taking connections in

    void accept_some() {
        for (int i = 0; i < 64; ++i) {
            const int64_t open = hub_.open_connections_;
            const int64_t places = hub_.settings_.max_connections;
            if (open >= places + hub_.settings_.max_surplus && !close_surplus()) return stop_accepting();
            sockaddr_storage address{};
            socklen_t length = sizeof address;
            const auto accepted = [&] {
                return FileDescriptor(accept4(listener_.get(), reinterpret_cast<sockaddr*>(&address), &length,
                                              SOCK_NONBLOCK | SOCK_CLOEXEC));
            };
            if (!reserve_) keep_reserve();
            FileDescriptor socket = accepted();
            if (!socket && (errno == EMFILE || errno == ENFILE)) {
                if (!is_pending()) return;  // the system says so before it looks
                if (reserve_)
                    reserve_.reset();
                else if (!close_surplus())
                    return stop_accepting();
                socket = accepted();
            }
            if (!socket) {
                if (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM) stop_accepting();
                return;
            }
            const int on = 1;
            setsockopt(socket.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
            const int file = socket.get();
            auto owned = std::make_unique<Connection>(std::move(socket), address_text(address), hub_.open_connections_);
            Connection& connection = *owned;
            connections_[file] = std::move(owned);
            connection.surplus = open >= places || !reserve_;
            if (connection.surplus) surplus_.push_back(&connection);
            expect_head(connection, connection.surplus ? kSurplusHead_seconds : hub_.settings_.head_timeout_seconds);
        }
    }

    bool is_pending() const {
        pollfd watched{listener_.get(), POLLIN, 0};
        return poll(&watched, 1, 0) > 0;
    }

    // The listener would be ready for ever. Until the next tick, others may close.
    void stop_accepting() {
        watch(listener_.get(), 0, EPOLL_CTL_DEL);
        accepting_ = false;
    }

    // The oldest of those beyond the limit that is not being answered makes room for a new one. False: there is none.
    bool close_surplus() {
        for (Connection* connection : surplus_) {
            if (connection->state != State::Head && connection->state != State::Linger) continue;
            if (connection->state == State::Head) refuse_surplus(*connection);
            // What was said lies with the socket, which sends it after this too, unless the client goes on talking.
            if (std::find(surplus_.begin(), surplus_.end(), connection) != surplus_.end()) close(*connection);
            return true;
        }
        return false;
    }

    void refuse_surplus(Connection& connection) {
        refuse(connection,
               Error(ErrorCode::Unavailable,
                     "all " + std::to_string(hub_.settings_.max_connections) + " connections are taken"),
               {{"Retry-After", "1"}});
    }

    void expect_head(Connection& connection, double timeout_seconds) {
        connection.state = State::Head;
        connection.since = Clock::now();
        connection.deadline = connection.since + steady_seconds(timeout_seconds);
        connection.stall_limit = Clock::time_point::max();
        set_interest(connection, EPOLLIN);
    }

    void close(Connection& connection) {
        if (connection.surplus) std::erase(surplus_, &connection);
        connections_.erase(connection.socket.get());
    }

    std::unique_ptr<Connection> release(Connection& connection) {
        if (connection.interest != 0) watch(connection.socket.get(), 0, EPOLL_CTL_DEL);
        connection.interest = 0;
        auto node = connections_.extract(connection.socket.get());
        return std::move(node.mapped());
    }

    // --- reading

    void serve(Connection& connection) {
        if (connection.state == State::Write) return send_some(connection);
        if (connection.state == State::Held) return close(connection);  // its client has gone
        const int socket = connection.socket.get();
        for (int i = 0; i < kReadsAnEvent; ++i) {
            // A body in memory never grows past what its head declared, a head not past its limit.
            const ssize_t n = recv(socket, buffer_.data(), buffer_.size(), 0);
            if (n < 0 && errno == EINTR) continue;
            if (n < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return;
            if (n <= 0) return close(connection);
            if (connection.state == State::Linger) continue;
            connection.stall_limit = Clock::time_point::max();
            connection.in.append(buffer_.data(), static_cast<size_t>(n));
            if (connection.state == State::Head) {
                head_arrived(connection);
            } else {
                body_arrived(connection);
            }
            // The connection may be closed, moved elsewhere, or writing by now.
            const auto found = connections_.find(socket);
            if (found == connections_.end() || found->second.get() != &connection) return;
            if (connection.state == State::Write) return;
            if (static_cast<size_t>(n) < buffer_.size()) return;
        }
    }

    void head_arrived(Connection& connection) {
        std::optional<size_t> length;
        try {
            length = connection.scanner.scan(connection.in, hub_.settings_.head);
        } catch (const Error& error) {
            return refuse(connection, error);
        }
        if (!length) {
            if (!connection.exchange) {  // the first bytes of this head: its clock begins
                begin_exchange(connection);
                if (!connection.surplus)
                    connection.deadline = Clock::now() + steady_seconds(hub_.settings_.head_timeout_seconds);
            }
            return;
        }
        if (!connection.exchange) begin_exchange(connection);
        Exchange& exchange = *connection.exchange;
        exchange.call.peer = connection.peer;
        try {
            exchange.call.head = parse_head(std::string_view(connection.in).substr(0, *length));
            connection.in.erase(0, *length);
            connection.scanner.restart();
            connection.close_after = !exchange.call.head.keep_alive || hub_.draining_ || connection.surplus;
            hub_.callbacks_.judge(exchange);
        } catch (const Error& error) {
            return refuse(connection, error);
        } catch (const Refusal& refusal) {
            return refuse(connection, refusal.error, refusal.headers, refusal.held_seconds);
        }
        if (connection.surplus && exchange.route->lane != Lane::Instant) return refuse_surplus(connection);
        connection.body_left = exchange.call.head.content_length;
        if (connection.body_left == 0 && exchange.route->body != BodyKind::Upload) return dispatch(connection);
        expect_body(connection);
    }

    void begin_exchange(Connection& connection) {
        connection.exchange = std::make_unique<Exchange>(hub_.busy_);
        connection.exchange->begun = Clock::now();
        connection.close_after = false;
    }

    void expect_body(Connection& connection) {
        connection.state = State::Body;
        connection.deadline = Clock::now() + steady_seconds(hub_.settings_.body_timeout_seconds);
        connection.stall_limit = Clock::now() + steady_seconds(hub_.settings_.stall_timeout_seconds);
        if (connection.exchange->call.head.expects_continue && connection.in.empty()) {
            constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";
            // Twenty-five bytes fit the empty send buffer of a connection that only read so far.
            (void)!send(connection.socket.get(), kContinue.data(), kContinue.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
        }
        if (connection.exchange->route->body == BodyKind::Upload && this == hub_.front_.get())
            return hub_.bulk_->post(release(connection));
        body_arrived(connection);
    }

    void body_arrived(Connection& connection) {
        Exchange& exchange = *connection.exchange;
        connection.stall_limit = Clock::now() + steady_seconds(hub_.settings_.stall_timeout_seconds);
        const size_t n = std::min<uint64_t>(connection.in.size(), connection.body_left);
        if (exchange.route->body == BodyKind::Upload) {
            if (!spool(connection, n)) return;
        } else {
            exchange.call.body.append(connection.in, 0, n);
        }
        connection.in.erase(0, n);
        connection.body_left -= n;
        if (connection.body_left > 0) return set_interest(connection, EPOLLIN);
        connection.spool_file.reset();
        dispatch(connection);
    }

    // False when the connection was refused instead.
    bool spool(Connection& connection, size_t n) {
        Exchange& exchange = *connection.exchange;
        if (!connection.spool_file) {
            exchange.call.spool = Spool(hub_.callbacks_.spool_path());
            connection.spool_file = FileDescriptor(
                open(exchange.call.spool.path().c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC | O_NOFOLLOW, 0600));
        }
        for (size_t written = 0; written < n || !connection.spool_file;) {
            const ssize_t w = !connection.spool_file
                                  ? -1
                                  : write(connection.spool_file.get(), connection.in.data() + written, n - written);
            if (w < 0 && errno == EINTR) continue;
            if (w < 0) {
                const bool full = errno == ENOSPC || errno == EDQUOT || errno == EFBIG;
                spdlog::error("an upload cannot be written: {}", std::strerror(errno));
                refuse(connection, full ? Error(ErrorCode::NoSpace, "the disk is full")
                                        : Error(ErrorCode::Unavailable, "the upload cannot be written to disk"));
                return false;
            }
            written += static_cast<size_t>(w);
        }
        return true;
    }

    // --- answering

    void dispatch(Connection& connection) {
        if (connection.exchange->route->lane == Lane::Instant) {
            answerer_.answer(*connection.exchange, !connection.close_after);
            return begin_write(connection);
        }
        std::unique_ptr<Connection> owned = release(connection);
        if (hub_.callbacks_.dispatch(owned)) return;
        Connection& back = *owned;
        connections_[back.socket.get()] = std::move(owned);
        const Refusal refusal = too_many_waiting();
        refuse(back, refusal.error, refusal.headers);
    }

    void refuse(Connection& connection, const Error& error, std::map<std::string, std::string> headers = {},
                double held_seconds = 0) {
        if (!connection.exchange) begin_exchange(connection);
        Exchange& exchange = *connection.exchange;
        exchange.refusal.emplace(Refusal{error, std::move(headers), held_seconds});
        exchange.call.peer = connection.peer;
        // What follows a head that was refused with its body still to come, or that could not be read, has no meaning.
        const bool head_was_read = !exchange.call.head.method.empty();
        if (!head_was_read || exchange.call.head.content_length > 0 || connection.state == State::Body ||
            connection.surplus)
            connection.close_after = true;
        connection.spool_file.reset();
        exchange.call.spool = {};
        answerer_.answer(exchange, !connection.close_after);
        if (held_seconds <= 0) return begin_write(connection);
        connection.state = State::Held;
        connection.deadline = Clock::now() + steady_seconds(held_seconds);
        connection.stall_limit = Clock::time_point::max();
        set_interest(connection, EPOLLRDHUP);
    }

    void begin_write(Connection& connection) {
        Exchange& exchange = *connection.exchange;
        if (exchange.reply.events) {
            hub_.callbacks_.finished(exchange, elapsed(exchange));
            return hub_.callbacks_.stream(release(connection));
        }
        if (exchange.wire.empty()) return close(connection);
        connection.state = State::Write;
        if (exchange.reply.file && this == hub_.front_.get()) return hub_.bulk_->post(release(connection));
        connection.wire_sent = 0;
        connection.pieces_begun = false;
        connection.file_sent = 0;
        double bytes =
            static_cast<double>(exchange.wire.size() + (exchange.reply.file ? exchange.reply.file->length : 0));
        for (const std::string& piece : exchange.reply.pieces) bytes += static_cast<double>(piece.size());
        connection.deadline = Clock::now() + steady_seconds(hub_.settings_.stall_timeout_seconds +
                                                            bytes / hub_.settings_.write_bytes_per_second);
        connection.stall_limit = Clock::now() + steady_seconds(hub_.settings_.stall_timeout_seconds);
        send_some(connection);
    }

    void send_some(Connection& connection) {
        Exchange& exchange = *connection.exchange;
        const bool has_file = exchange.reply.file.has_value();
        std::deque<std::string>& pieces = exchange.reply.pieces;
        for (;;) {
            while (connection.wire_sent < exchange.wire.size()) {
                const bool more = has_file || !pieces.empty();
                const ssize_t n =
                    send(connection.socket.get(), exchange.wire.data() + connection.wire_sent,
                         exchange.wire.size() - connection.wire_sent, MSG_NOSIGNAL | (more ? MSG_MORE : 0));
                if (!sent(connection, n)) return;
                connection.wire_sent += static_cast<size_t>(n);
            }
            if (pieces.empty()) break;
            if (exchange.memory && connection.pieces_begun) exchange.memory->give_back(exchange.wire.size());
            exchange.wire = std::move(pieces.front());
            pieces.pop_front();
            connection.wire_sent = 0;
            connection.pieces_begun = true;
        }
        if (has_file) {
            FileBody& body = *exchange.reply.file;
            size_t budget = kSendFileBytes;
            while (connection.file_sent < body.length) {
                if (budget == 0) return set_interest(connection, EPOLLOUT);
                off_t from = static_cast<off_t>(body.offset + connection.file_sent);
                const size_t most = std::min<uint64_t>(budget, body.length - connection.file_sent);
                const ssize_t n = sendfile(connection.socket.get(), body.file.get(), &from, most);
                if (n == 0) return close(connection);  // the file is shorter than was promised
                if (!sent(connection, n)) return;
                connection.file_sent += static_cast<size_t>(n);
                budget -= static_cast<size_t>(n);
            }
        }
        finish(connection);
    }

    // False when nothing more can be sent now.
    bool sent(Connection& connection, ssize_t n) {
        if (n > 0) {
            connection.stall_limit = Clock::now() + steady_seconds(hub_.settings_.stall_timeout_seconds);
            return true;
        }
        if (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR) {
            set_interest(connection, EPOLLOUT);
        } else {
            close(connection);
        }
        return false;
    }

    void finish(Connection& connection) {
        hub_.callbacks_.finished(*connection.exchange, elapsed(*connection.exchange));
        connection.exchange.reset();
        if (connection.close_after) {
            shutdown(connection.socket.get(), SHUT_WR);
            connection.state = State::Linger;
            connection.in = {};
            connection.deadline = Clock::now() + steady_seconds(kLinger_seconds);
            connection.stall_limit = Clock::time_point::max();
            return set_interest(connection, EPOLLIN);
        }
        connection.state = State::Head;
        // The next request is the front's. A pipelined one takes its turn by way of the inbox, not of the stack.
        if (this != hub_.front_.get() || !connection.in.empty()) return hub_.front_->post(release(connection));
        expect_head(connection, hub_.settings_.idle_timeout_seconds);
    }

    static double elapsed(const Exchange& exchange) {
        return std::chrono::duration<double>(Clock::now() - exchange.begun).count();
    }

    Hub& hub_;
    FileDescriptor listener_, epoll_, wake_;
    FileDescriptor reserve_;  // of the front: given up for a connection when there is no other
    bool accepting_ = true;
    std::unordered_map<int, std::unique_ptr<Connection>> connections_;
    std::deque<Connection*> surplus_;  // the oldest first; they stay with the front
    std::vector<char> buffer_ = std::vector<char>(kReadBytes);
    Answerer answerer_;
    std::mutex mutex_;
    std::vector<std::unique_ptr<Connection>> inbox_;
    std::atomic<bool> stopping_{false};
    std::thread thread_;
};

Hub::Hub(HubSettings settings, HubCallbacks callbacks, Listener listener)
    : settings_(settings), callbacks_(std::move(callbacks)), port_(listener.port()), listener_(listener.take()) {}

Hub::~Hub() { stop(); }

void Hub::start() {
    front_ = std::make_unique<Loop>(*this, std::move(listener_));
    bulk_ = std::make_unique<Loop>(*this, FileDescriptor());
    bulk_->begin();
    front_->begin();
}

int Hub::port() const { return port_; }

void Hub::answered(std::unique_ptr<Connection> connection) {
    connection->state = State::Write;
    Loop& loop = connection->exchange->reply.file ? *bulk_ : *front_;
    loop.post(std::move(connection));
}

void Hub::drain(double grace_seconds) {
    draining_ = true;
    if (front_) front_->wake();
    const auto until = Clock::now() + steady_seconds(grace_seconds);
    while (busy_ > 0 && Clock::now() < until) std::this_thread::sleep_for(std::chrono::milliseconds(10));
}

void Hub::stop() {
    if (front_) front_->stop();
    if (bulk_) bulk_->stop();
    front_.reset();
    bulk_.reset();
}

}  // namespace photond::http
