#include "clients/cli/hard_cases_renders.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <deque>

#include "clients/cli/job_follower.h"
#include "clients/cli/progress_view.h"
#include "clients/cli/request_options.h"
#include "clients/cli/units.h"

namespace photond::cli {

namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr std::array<const char*, 4> kRadianceLayers = {"beauty", "emitted", "direct", "indirect"};
constexpr int kLowestPriority = -100;
constexpr size_t kAhead = 64;        // jobs submitted beyond the one that is waited for
constexpr double kNoDeadline = 1e9;  // seconds
constexpr size_t kPlainLines = 10;   // of progress where there is no terminal
constexpr const char* kLabel = "hard-cases";

std::string message_of(const json& job) {
    const json failure = job.value("failure", json());
    if (!failure.is_object()) return "job " + plain_text(job.value("id", json())) + " " + job.value("state", "");
    return plain_text(failure.value("title", json())) + ": " + plain_text(failure.value("detail", json()));
}

void purge(Session& session, const std::string& id) {
    session.daemon().send("DELETE", resource_path("jobs", id) + "?purge=true", nullptr, Repeat::Safely);
}

}  // namespace

json RenderWish::job(uint64_t seed, double seconds) const {
    return {{"scene", scene},
            {"image", {{"width", size.width}, {"height", size.height}}},
            {"method", method},
            {"stop", {{"passes", passes}, {"seconds", seconds}}},
            {"seed", seed},
            {"priority", kLowestPriority},
            {"labels", {{kLabel, scene}}}};
}

Renderings::Place Renderings::want(const RenderWish& wish, const std::string& layer, const ImageRegion& region) {
    const std::string key = wish.job(wish.first_seed, 0).dump();
    auto entry = std::find_if(all_.begin(), all_.end(), [&](const Entry& one) { return one.key == key; });
    if (entry == all_.end()) {
        all_.push_back({key, {wish}, {}});
        entry = all_.end() - 1;
    }
    auto wanted = std::find_if(entry->wanted.begin(), entry->wanted.end(),
                               [&](const Wanted& one) { return one.layer == layer && one.region == region; });
    if (wanted == entry->wanted.end()) {
        entry->wanted.push_back({layer, region, {}});
        wanted = entry->wanted.end() - 1;
    }
    return {static_cast<size_t>(entry - all_.begin()), static_cast<size_t>(wanted - entry->wanted.begin())};
}

const MeanLayer& Renderings::layer(const Place& place) const {
    const Entry& entry = all_[place.rendering];
    static const MeanLayer kNone;
    const auto found = entry.rendering.layers.find(entry.wanted[place.region].layer);
    return found == entry.rendering.layers.end() ? kNone : found->second;
}

const std::vector<std::optional<Radiance>>& Renderings::means(const Place& place) const {
    return all_[place.rendering].wanted[place.region].means;
}

class Renderings::Runner {
public:
    Runner(Session& session, std::vector<Entry>& all, const RenderLimits& limits)
        : session_(session), all_(all), limits_(limits) {}

    void run() {
        for (Entry& entry : all_)
            for (Wanted& wanted : entry.wanted) wanted.means.assign(limits_.seeds, std::nullopt);
        const size_t count = all_.size() * limits_.seeds;
        try {
            for (size_t next = 0; next < count || !waiting_.empty();) {
                while (next < count && waiting_.size() < kAhead) submit_one(next++);
                if (waiting_.empty()) continue;  // every one of them was refused
                collect_one();
                show(next - waiting_.size(), count);
            }
        } catch (const Failure& failure) {
            if (failure.code == ExitCode::Interrupted) remove_all();
            throw;
        }
    }

private:
    struct Waiting {
        std::string id;
        size_t entry, seed;
    };

    void submit_one(size_t number) {
        const size_t index = number / limits_.seeds, seed = number % limits_.seeds;
        Entry& entry = all_[index];
        try {
            const json job =
                submit(session_, "/v1/jobs",
                       entry.rendering.wish.job(entry.rendering.wish.first_seed + seed, limits_.job_seconds), "");
            waiting_.push_back({job.at("id").get<std::string>(), index, seed});
            entry.rendering.jobs.push_back(waiting_.back().id);
        } catch (const Failure& failure) {
            if (failure.code != ExitCode::Refused) throw;
            entry.rendering.failures.push_back("refused: " + refusal_text(failure));
        }
    }

    static std::string refusal_text(const Failure& failure) {
        std::string text = failure.what();
        if (failure.problem.is_object())
            for (const json& fault : failure.problem.value("errors", json::array()))
                text += "; " + plain_text(fault.value("pointer", json())) + ": " +
                        plain_text(fault.value("detail", json()));
        return text;
    }

    void collect_one() {
        const Waiting next = waiting_.front();
        Entry& entry = all_[next.entry];
        const std::optional<json> job = wait_for_end(next.id);
        waiting_.pop_front();
        if (!job) {
            ++entry.rendering.hangs;
            session_.daemon().send("DELETE", resource_path("jobs", next.id), nullptr, Repeat::Safely);
            return;
        }
        try {
            take(entry, next, *job);
        } catch (const Failure& failure) {
            if (failure.code != ExitCode::Refused) throw;
            entry.rendering.failures.push_back(next.id + ": " + failure.what());
        }
    }

    /// The job when it is over; none when it has run for longer than it may. How long it waits does not count: that is
    /// up to others' jobs.
    std::optional<json> wait_for_end(const std::string& id) {
        const std::chrono::duration<double> limit(limits_.job_seconds + limits_.timeout_seconds);
        std::optional<Clock::time_point> running_since;
        const auto listener = [&](const json& job, const std::string&) {
            if (!running_since && job.value("state", "") == "running") running_since = Clock::now();
        };
        while (true) {
            const auto run_for = running_since ? Clock::now() - *running_since : Clock::duration::zero();
            session_.interrupt().set_deadline(limit - run_for);
            try {
                json job = follow_job(session_.daemon(), id, listener);
                session_.interrupt().set_deadline(std::chrono::duration<double>(kNoDeadline));
                return job;
            } catch (const Failure& failure) {
                if (failure.code != ExitCode::TimedOut) throw;
                session_.interrupt().acknowledge();
                if (running_since && Clock::now() - *running_since >= limit) return std::nullopt;
            }
        }
    }

    void take(Entry& entry, const Waiting& which, const json& job) {
        Rendering& rendering = entry.rendering;
        rendering.seconds += job.value("seconds", 0.0);
        if (job.value("state", "") != "succeeded") {
            rendering.failures.push_back(which.id + ": " + message_of(job));
            return;
        }
        rendering.cut_short += job.value("passes_done", 0U) < rendering.wish.passes;
        const json& statistics = job.at("statistics");
        rendering.nan_samples += statistics.value("nan_count", uint64_t{0});
        rendering.infinite_samples += statistics.value("infinity_count", uint64_t{0});
        for (const char* name : kRadianceLayers) {
            const LayerPixels layer = fetch(which.id, name, rendering.wish.size);
            rendering.faults += faults_of(layer);
            bool wanted_here = false;
            for (Wanted& wanted : entry.wanted) {
                if (wanted.layer != name) continue;
                wanted.means[which.seed] = region_mean(layer, wanted.region);
                wanted_here = true;
            }
            if (wanted_here) rendering.layers[name].add(layer);
        }
    }

    LayerPixels fetch(const std::string& id, const std::string& layer, ImageSize size) {
        HttpRequest request;
        request.path = resource_path("jobs", id) + "/pixels?precision=float&layer=" + layer;
        std::string bytes;
        ReplySink sink;
        sink.head = [&bytes](const HttpReply&) {
            bytes.clear();
            return true;
        };
        sink.data = [&bytes](std::string_view more) {
            bytes.append(more);
            return true;
        };
        session_.daemon().ask(request, Repeat::Safely, &sink);
        return layer_from(bytes, size);
    }

    /// Nothing of an interrupted table is of use.
    void remove_all() {
        session_.interrupt().acknowledge();
        session_.remark("cancelling");
        for (const Waiting& waiting : waiting_) purge(session_, waiting.id);
        for (const Entry& entry : all_) remove_jobs(session_, entry.rendering.jobs);
    }

    void show(size_t done, size_t count) {
        const std::string text = std::to_string(done) + "/" + counted(count, "job");
        if (session_.error_is_terminal()) {
            const RenderWish& wish =
                all_[std::min((done + limits_.seeds) / limits_.seeds, all_.size()) - 1].rendering.wish;
            line_.redraw(text + "  " + wish.scene + ", " + plain_text(wish.method.at("name")));
        } else if (done * kPlainLines / count > shown_) {
            shown_ = done * kPlainLines / count;
            session_.remark(text);
        }
    }

    Session& session_;
    std::vector<Entry>& all_;
    const RenderLimits& limits_;
    std::deque<Waiting> waiting_;
    ProgressLine line_;
    size_t shown_ = 0;
};

void Renderings::run(Session& session, const RenderLimits& limits) { Runner(session, all_, limits).run(); }

void remove_jobs(Session& session, const std::vector<std::string>& jobs) {
    for (const std::string& id : jobs) {
        try {
            purge(session, id);
        } catch (const Failure& failure) {
            if (failure.code != ExitCode::Refused) throw;  // it is gone already
        }
    }
}

}  // namespace photond::cli
