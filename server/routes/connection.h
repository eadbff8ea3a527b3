#pragma once
// One client's connection. Exactly one thread holds it at a time: a loop of the hub, or a thread of the pool.

#include <atomic>
#include <memory>
#include <string>

#include "server/routes/exchange.h"

namespace photond::http {

struct Connection {
    enum class State : uint8_t {
        Head,    // waiting for, or reading, a request's head
        Body,    // reading its body
        Held,    // a refusal is made and not said yet
        Write,   // sending the answer
        Linger,  // all is said; reading what still comes, so that the answer is not lost to a reset
    };

    Connection(FileDescriptor accepted, std::string address, std::atomic<int64_t>& open_connections)
        : counted(open_connections), socket(std::move(accepted)), peer(std::move(address)) {}

    Counted counted;
    FileDescriptor socket;
    std::string peer;
    State state = State::Head;
    uint32_t interest = 0;  // epoll events asked for
    bool close_after = false;
    bool surplus = false;             // beyond the limit: told so, unless it asks whether the daemon is alive
    Clock::time_point since{};        // of the state Head
    Clock::time_point deadline{};     // of the state
    Clock::time_point stall_limit{};  // Body, Write: without a single byte until then, it is cut

    std::string in;  // bytes that arrived and are not consumed
    HeadScanner scanner;
    std::unique_ptr<Exchange> exchange;  // from the end of the head on

    uint64_t body_left = 0;
    FileDescriptor spool_file;

    size_t wire_sent = 0;
    bool pieces_begun = false;  // the wire is a piece of the answer by now
    uint64_t file_sent = 0;
};

}  // namespace photond::http
