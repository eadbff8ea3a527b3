#pragma once
// Runs one complete request through cpp-httplib, over memory: the library parses the target and writes the answer, and
// never sees a socket, a body or a header of a client.

#include <memory>

#include "server/routes/exchange.h"

namespace photond::http {

/// One a thread; not thread-safe.
class Answerer {
public:
    Answerer();
    ~Answerer();
    Answerer(const Answerer&) = delete;
    Answerer& operator=(const Answerer&) = delete;

    /// Calls the route's handler (or states the refusal) and fills exchange.wire and exchange.reply. Every failure
    /// becomes a problem document; nothing is thrown. `keep_alive` as the answer should state it.
    void answer(Exchange& exchange, bool keep_alive) noexcept;

private:
    class Library;
    std::unique_ptr<Library> library_;
};

}  // namespace photond::http
