#pragma once
// One request and its answer, on their way through the hub (sockets), the pool (threads) and the routes (meaning).

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "protocol/error.h"
#include "server/auth.h"
#include "server/routes/answer_memory.h"
#include "server/routes/request_head.h"

namespace photond::http {

using Clock = std::chrono::steady_clock;

class FileDescriptor {
public:
    FileDescriptor() = default;
    explicit FileDescriptor(int number) : number_(number) {}
    FileDescriptor(FileDescriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
    FileDescriptor& operator=(FileDescriptor&& other) noexcept {
        if (this != &other) reset(), number_ = std::exchange(other.number_, -1);
        return *this;
    }
    ~FileDescriptor() { reset(); }
    void reset() {
        if (number_ >= 0) ::close(number_);
        number_ = -1;
    }
    int get() const { return number_; }
    explicit operator bool() const { return number_ >= 0; }

private:
    int number_ = -1;
};

/// An upload on disk; the file is removed with the object unless it was handed on.
class Spool {
public:
    Spool() = default;
    explicit Spool(std::filesystem::path path) : path_(std::move(path)) {}
    Spool(Spool&& other) noexcept : path_(std::exchange(other.path_, {})) {}
    Spool& operator=(Spool&& other) noexcept {
        remove();
        path_ = std::exchange(other.path_, {});
        return *this;
    }
    ~Spool() { remove(); }
    const std::filesystem::path& path() const { return path_; }
    /// The caller owns the file from here on.
    std::filesystem::path release() { return std::exchange(path_, {}); }

private:
    void remove() noexcept {
        std::error_code ignored;  // an orphan is swept at the next start
        if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
    }
    std::filesystem::path path_;
};

/// A part of a file to send after the head, straight from disk.
struct FileBody {
    FileDescriptor file;
    uint64_t offset = 0;
    uint64_t length = 0;
    std::shared_ptr<const void> pin;  // keeps the artefact from being evicted meanwhile
};

/// Turns the connection into an event stream once the head is out.
struct EventSubscription {
    std::string job;       // empty: all jobs
    uint64_t last_id = 0;  // events with a greater id follow
    std::string first;     // text sent at once, for example the state now
};

struct Reply {
    int status = 200;
    std::map<std::string, std::string> headers;
    std::string media_type;
    std::string body;
    std::deque<std::string> pieces;  // follow the body, where an answer is too long for one text
    std::optional<FileBody> file;
    std::optional<EventSubscription> events;
};

/// Thrown by a handler in place of waiting for a job: its request begins anew, with Call::awaited, once the job is over
/// or the time is. Meanwhile it holds no thread (awaited_jobs.h).
struct AwaitJob {
    std::string job;
    uint64_t after_event = 0;  // the greatest event id before the job was seen not to be over
    Clock::time_point until{};
    std::function<void()> client_left;  // called where the client goes before that; may be empty
};

/// What a request that begins anew has waited for.
struct Awaited {
    std::string job;
    Clock::time_point until{};
};

/// What a route's handler sees of its request.
struct Call {
    RequestHead head;
    std::string peer;                               // address of the client
    std::vector<std::string> path_parameters;       // decoded, in the order of the pattern
    std::multimap<std::string, std::string> query;  // decoded
    std::string body;                               // JSON routes
    Spool spool;                                    // upload routes
    std::optional<Grant> grant;                     // none without authentication
    std::optional<Awaited> awaited;                 // none at first
    /// Asked before each piece of a long answer is kept: throws ClientGone, and TryLater where the answer takes too
    /// long or finds no room in memory.
    std::function<void(uint64_t bytes)> before_piece;
};

/// Who shares of the lanes, the memory and the rate are counted by: the token, else the address.
inline std::string client_of(const Call& call) {
    return call.grant ? "token " + call.grant->name : "address " + call.peer;
}

/// Nobody is there any more to be answered.
struct ClientGone {};

enum class BodyKind : uint8_t {
    None,
    Json,    // application/json, in memory
    Upload,  // spooled to a file
};

/// Which threads run a handler. One that throws NeedsHelper (helper_wait.h) begins anew in Lane::Helper.
enum class Lane : uint8_t {
    Instant,  // takes no lock and waits for nothing: on the hub's own thread
    Quick,    // the store at most
    List,     // reads much of the store, in pieces
    Long,     // a film or a study: takes a while
    Helper,   // waits for the helper of images and pictures
    Bulk,     // waits for the helper of uploads and other long work
};

struct Route {
    std::string method;   // GET also answers HEAD
    std::string pattern;  // "/v1/jobs/{id}"
    BodyKind body = BodyKind::None;
    Lane lane = Lane::Quick;
    std::optional<Lane> lane_of_json;      // of an upload that is JSON, where that is another
    bool open = false;                     // needs no token
    bool missing_page = false;             // what a browser is shown where there is no page; its pattern is a name
    std::vector<std::string> media_types;  // of an upload
    std::function<Reply(Call&)> handle;    // throws Error
};

/// An answer that needs no route: a fault seen by the hub.
struct Refusal {
    Error error;
    std::map<std::string, std::string> headers;
    double held_seconds = 0;  // before it is said, to slow whoever tries again at once
};

inline Refusal too_many_waiting() {
    return {Error(ErrorCode::Unavailable, "too many requests are waiting for an answer"), {{"Retry-After", "1"}}};
}

/// Adds 1 to a number for as long as it lives.
class Counted {
public:
    explicit Counted(std::atomic<int64_t>& number) : number_(number) { ++number_; }
    ~Counted() { --number_; }
    Counted(const Counted&) = delete;
    Counted& operator=(const Counted&) = delete;

private:
    std::atomic<int64_t>& number_;
};

struct Exchange {
    explicit Exchange(std::atomic<int64_t>& under_way) : counted(under_way) {}

    Counted counted;
    Call call;
    const Route* route = nullptr;
    std::optional<Refusal> refusal;
    Clock::time_point begun{};

    std::optional<AnswerMemory::Share> memory;  // of what a lane's threads answer; none for what the hub says itself

    // Filled by Answerer.
    std::string wire;                // head and body as they go out
    Reply reply;                     // its pieces, its file and its event subscription are still to be served
    bool client_gone = false;        // nothing was made
    bool needs_helper = false;       // nothing was made: a thread that may wait for a helper is to answer it
    std::optional<AwaitJob> awaits;  // nothing was made: it is to be answered when that is over
};

Reply json_reply(int status, const nlohmann::json& body);
/// 200 with the JSON text that `make` hands to its sink in pieces.
Reply json_text_reply(Call& call, const std::function<void(const std::function<void(std::string)>&)>& make);
Reply problem_reply(const Error& error, const std::string& instance);

}  // namespace photond::http
