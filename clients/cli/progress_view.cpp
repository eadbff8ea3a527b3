#include "clients/cli/progress_view.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iostream>

#include "clients/cli/units.h"

namespace photond::cli {

namespace {

using nlohmann::json;

constexpr double kPlainStep = 0.1;               // of the whole job, between plain lines
constexpr std::chrono::seconds kPlainPause{10};  // or this long, whichever comes first
constexpr size_t kBarColumns = 30;

bool utf8_locale() {
    for (const char* name : {"LC_ALL", "LC_CTYPE", "LANG"}) {
        const char* value = std::getenv(name);
        if (!value || !*value) continue;
        const std::string locale = value;
        return locale.find("UTF-8") != std::string::npos || locale.find("utf8") != std::string::npos;
    }
    return false;
}

size_t terminal_columns() {
    winsize size{};
    return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

double number(const json& object, const char* key) {
    return object.contains(key) && object[key].is_number() ? object[key].get<double>() : 0;
}

std::string passes_text(const json& job) {
    const std::string done = human_number(number(job, "passes_done"));
    const json stop = job.contains("request") ? job["request"].value("stop", json::object()) : json::object();
    if (stop.is_object() && stop.contains("passes") && stop["passes"].is_number())
        return done + "/" + plain_text(stop["passes"]) + " passes";
    return done + (done == "1" ? " pass" : " passes");
}

/// The error so far and the one to reach; empty while nothing is measured.
std::string error_text(const json& job) {
    const json error = job.value("error_now", json());
    if (!error.is_object()) return "";
    const json value = error.value("value", json()), interval = error.value("interval", json());
    const bool below = interval.is_array() && !(value.is_number() && value.get<double>() > 0);
    if (!below && !value.is_number()) return "";
    const std::string metric = plain_text(error.value("metric", json()));
    std::string text =
        ", " + metric + (below ? " below " : " ") + three_digit_number((below ? interval.at(1) : value).get<double>());
    const json stop = job.contains("request") ? job["request"].value("stop", json()) : json();
    const json target = stop.is_object() ? stop.value("target", json()) : json();
    if (target.is_object() && plain_text(target.value("metric", json())) == metric)
        text += " (target " + plain_text(target.value("value", json())) + ")";
    return text;
}

std::string bar(double progress) {
    static const bool utf8 = utf8_locale();
    const auto full = static_cast<size_t>(std::lround(std::clamp(progress, 0.0, 1.0) * kBarColumns));
    std::string text;
    for (size_t i = 0; i < kBarColumns; ++i) text += i < full ? (utf8 ? "━" : "=") : (utf8 ? "╌" : "-");
    return utf8 ? text : "[" + text + "]";
}

/// Of a job that runs evenly; empty before there is enough to judge by.
std::string time_left(const json& job) {
    const double progress = number(job, "progress");
    const double seconds = number(job, "seconds");
    if (progress < 0.02 || progress >= 1 || seconds < 0.5) return "";
    return ", about " + human_seconds(seconds * (1 - progress) / progress) + " left";
}

}  // namespace

std::string job_figures(const json& job) {
    return passes_text(job) + ", " + human_seconds(number(job, "seconds")) + error_text(job);
}

ProgressLine::~ProgressLine() {
    if (open_) std::cerr << std::endl;
}

void ProgressLine::redraw(const std::string& text) {
    std::string shown = text;
    // Cut at whole characters: a line that wraps would not be redrawn in place.
    while (display_width(shown) + 1 > terminal_columns()) {
        while (shown.size() > 1 && (static_cast<unsigned char>(shown.back()) & 0xC0U) == 0x80U) shown.pop_back();
        shown.pop_back();
    }
    std::cerr << '\r' << shown << "\033[K" << std::flush;
    open_ = true;
}

void ProgressView::show(const json& job) {
    const std::string state = plain_text(job.value("state", json()));
    const std::string id = plain_text(job.value("id", json()));
    const double progress = number(job, "progress");
    const std::string percent = human_number(std::floor(progress * 100)) + " %";
    const std::string figures = job_figures(job);
    if (terminal_) {
        if (state == "queued")
            line_.redraw(id + " queued");
        else
            line_.redraw(id + " " + bar(progress) + " " + std::string(5 - std::min<size_t>(5, percent.size()), ' ') +
                         percent + "  " + figures + (state == "running" ? time_left(job) : ", " + state));
        return;
    }
    const auto now = std::chrono::steady_clock::now();
    const bool due = progress >= progress_ + kPlainStep || (progress > progress_ && now - shown_at_ >= kPlainPause);
    if (state == state_ && !due) return;
    std::cerr << id << ' ' << state;
    if (state != "queued")
        std::cerr << ": " << percent << ", " << figures << (state == "running" ? time_left(job) : "");
    std::cerr << std::endl;
    state_ = state;
    progress_ = progress;
    shown_at_ = now;
}

void ComparisonProgressView::show(const json& comparison, const ComparisonProgress& progress) {
    const std::string state = plain_text(comparison.value("state", json()));
    const std::string id = plain_text(comparison.value("id", json()));
    const std::string count = std::to_string(progress.done) + "/" + counted(progress.all, "job");
    const bool runs = progress.job.is_object() && progress.job.value("state", "") == "running";
    std::string now;
    if (progress.job.is_object()) now = runs ? progress.name : "next: " + progress.name;
    if (terminal_) {
        const double share = progress.job.is_object() ? number(progress.job, "progress") : 0;
        const double all = static_cast<double>(std::max<size_t>(progress.all, 1));
        line_.redraw(id + " " + bar((static_cast<double>(progress.done) + share) / all) + " " + count +
                     (now.empty() ? ", " + state : "  " + now) + (runs ? ": " + job_figures(progress.job) : ""));
        return;
    }
    const std::string line = id + " " + state + ": " + count + (now.empty() ? "" : ", " + now);
    if (line == shown_) return;
    shown_ = line;
    std::cerr << line << std::endl;
}

}  // namespace photond::cli
