#pragma once
// Progress on standard error: one line redrawn on a terminal, plain lines now and then elsewhere.

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>

namespace photond::cli {

/// The line that is redrawn.
class ProgressLine {
public:
    ProgressLine() = default;
    /// Ends the line, so that what follows stands on its own.
    ~ProgressLine();
    ProgressLine(const ProgressLine&) = delete;
    ProgressLine& operator=(const ProgressLine&) = delete;

    void redraw(const std::string& text);

private:
    bool open_ = false;
};

/// Of one job.
class ProgressView {
public:
    explicit ProgressView(bool terminal) : terminal_(terminal) {}
    void show(const nlohmann::json& job);

private:
    bool terminal_;
    ProgressLine line_;
    std::string state_;    // last shown
    double progress_ = 0;  // last shown, on plain lines
    std::chrono::steady_clock::time_point shown_at_{};
};

struct ComparisonProgress {
    size_t done = 0;  // jobs that are over
    size_t all = 0;
    std::string name;    // of the first one that is not; empty when there is none
    nlohmann::json job;  // that one; null when there is none
};

/// Of a comparison: how many of its jobs are done, and the one that runs.
class ComparisonProgressView {
public:
    explicit ComparisonProgressView(bool terminal) : terminal_(terminal) {}
    void show(const nlohmann::json& comparison, const ComparisonProgress& progress);

private:
    bool terminal_;
    ProgressLine line_;
    std::string shown_;  // what the last plain line was about
};

/// "12/64 passes, 3.1 s, relative_mse 0.0123 (target 0.01)" of a job.
std::string job_figures(const nlohmann::json& job);

}  // namespace photond::cli
