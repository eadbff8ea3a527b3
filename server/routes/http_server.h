#pragma once
// The daemon's HTTP side. Everything about HTTP lives in this folder; the rest of the server speaks through Service.

#include <memory>
#include <string>

#include "server/auth.h"
#include "server/routes/listener.h"
#include "server/service.h"

namespace photond {

class HttpServer {
public:
    /// `tokens` is nullptr where no authentication is asked for; it and `service` must outlive the server. Limits come
    /// from service.options().
    HttpServer(Service& service, const TokenList* tokens, http::Listener listener);
    /// stop()s if that has not been done.
    ~HttpServer();
    HttpServer(const HttpServer&) = delete;
    HttpServer& operator=(const HttpServer&) = delete;

    /// Begins to answer, on threads of its own, whoever has connected meanwhile too.
    void start();
    /// Where it listens: "http://127.0.0.1:8080", with the port really bound.
    std::string url() const;
    /// Accepts nothing more, lets answers under way go out for at most `grace_seconds`, closes all connections.
    void stop(double grace_seconds);

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace photond
