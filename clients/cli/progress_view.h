#pragma once
// A job's progress on standard error: one line redrawn on a terminal, plain lines now and then elsewhere.

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>

namespace photond::cli {

class ProgressView {
public:
    explicit ProgressView(bool terminal) : terminal_(terminal) {}
    /// Ends the redrawn line.
    ~ProgressView();
    ProgressView(const ProgressView&) = delete;
    ProgressView& operator=(const ProgressView&) = delete;

    void show(const nlohmann::json& job);

private:
    void redraw(const std::string& line);

    bool terminal_;
    bool line_open_ = false;
    std::string state_;    // last shown
    double progress_ = 0;  // last shown, on plain lines
    std::chrono::steady_clock::time_point shown_at_{};
};

}  // namespace photond::cli
