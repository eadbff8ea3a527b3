#include "clients/cli/session.h"

#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <iostream>

namespace photond::cli {

namespace {

std::string environment(const char* name) {
    const char* value = std::getenv(name);
    return value ? value : "";
}

std::string token_in(const std::string& file) {
    std::ifstream in(file);
    std::string token;
    if (!in || !(in >> token)) throw Failure(ExitCode::Usage, "cannot read a token from " + file);
    return token;
}

}  // namespace

Session::Session()
    : error_is_terminal_(isatty(STDERR_FILENO) == 1),
      colours_(isatty(STDOUT_FILENO) == 1 && environment("NO_COLOR").empty() && environment("TERM") != "dumb") {
    if (const std::string url = environment("PHOTOND_URL"); !url.empty()) server.url = url;
    server.token = environment("PHOTOND_TOKEN");
}

DaemonClient& Session::daemon() {
    if (!daemon_) {
        if (!token_file.empty()) server.token = token_in(token_file);
        daemon_ = std::make_unique<DaemonClient>(server, interrupt_);
    }
    return *daemon_;
}

void Session::print_json(const nlohmann::json& object) const {
    std::cout << object.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) << std::endl;
}

void Session::remark(const std::string& line) const { std::cerr << line << std::endl; }

std::string Session::bold(const std::string& text) const { return colours_ ? "\033[1m" + text + "\033[0m" : text; }

std::string Session::coloured_state(const std::string& state, const std::string& padded) const {
    if (!colours_) return padded;
    const bool good = state == "succeeded" || state == "ready" || state == "ok";
    const bool bad = state == "failed" || state == "fail";
    return (good ? "\033[32m" : bad ? "\033[31m" : "\033[33m") + padded + "\033[0m";
}

}  // namespace photond::cli
