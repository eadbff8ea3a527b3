#pragma once
#include <string>

#include "server/routes/exchange.h"

namespace photond::http {

/// A bound address. Whoever connects waits until the server answers.
class Listener {
public:
    /// Port 0 picks a free one. Throws Error (Unavailable) when the address cannot be had.
    Listener(const std::string& address, int port);

    int port() const { return port_; }  // really bound
    FileDescriptor take() { return std::move(socket_); }

private:
    FileDescriptor socket_;
    int port_ = 0;
};

}  // namespace photond::http
