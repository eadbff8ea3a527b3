#pragma once
// What every command shares: the global options, the daemon, and where results and remarks go.

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "clients/cli/daemon_client.h"
#include "clients/cli/failure.h"
#include "clients/cli/interrupt.h"

namespace photond::cli {

/// Results go to standard output: for people as text, with --json as JSON Lines, the daemon's own objects, one a line.
/// Everything else (progress, remarks, failures) goes to standard error.
class Session {
public:
    Session();

    bool json_output = false;
    ServerOptions server;
    std::string token_file;
    std::function<ExitCode()> action;  // what the command line asked for

    Interrupt& interrupt() { return interrupt_; }
    /// Made at the first call, when the options are known.
    DaemonClient& daemon();

    void print_json(const nlohmann::json& object) const;
    /// A line on standard error.
    void remark(const std::string& line) const;
    bool error_is_terminal() const { return error_is_terminal_; }
    /// `text` in bold or colour where standard output is a terminal that wants it (NO_COLOR is heeded).
    std::string bold(const std::string& text) const;
    std::string coloured_state(const std::string& state, const std::string& padded) const;

private:
    Interrupt interrupt_;
    std::unique_ptr<DaemonClient> daemon_;
    bool error_is_terminal_;
    bool colours_;
};

}  // namespace photond::cli
