#include "server/routes/listener.h"

#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>

namespace photond::http {

constexpr int kBacklog = 4096;

Listener::Listener(const std::string& address, int port) {
    addrinfo hints{};
    hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV | AI_PASSIVE;
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* found = nullptr;
    const std::string name = address == "localhost" ? "127.0.0.1" : address;
    if (getaddrinfo(name.c_str(), std::to_string(port).c_str(), &hints, &found) != 0)
        throw Error(ErrorCode::Unavailable, "cannot listen on \"" + address + "\": not a numeric address");
    const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> addresses(found, &freeaddrinfo);
    socket_ = FileDescriptor(socket(found->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    const int on = 1;
    setsockopt(socket_.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (bind(socket_.get(), found->ai_addr, found->ai_addrlen) != 0 || listen(socket_.get(), kBacklog) != 0)
        throw Error(ErrorCode::Unavailable,
                    "cannot listen on " + address + " port " + std::to_string(port) + ": " + std::strerror(errno));
    sockaddr_storage bound{};
    socklen_t length = sizeof bound;
    getsockname(socket_.get(), reinterpret_cast<sockaddr*>(&bound), &length);
    port_ = ntohs(bound.ss_family == AF_INET6 ? reinterpret_cast<sockaddr_in6&>(bound).sin6_port
                                              : reinterpret_cast<sockaddr_in&>(bound).sin_port);
}

}  // namespace photond::http
