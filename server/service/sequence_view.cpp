#include "server/service/sequence_view.h"

#include <algorithm>

#include "server/clock_text.h"
#include "server/method_params.h"

namespace photond {

using nlohmann::json;

namespace {

/// Seconds until the last frame will be done, by those that are: the time since the first one began over their number.
std::optional<double> seconds_left(const SequenceView& sequence) {
    const auto in = [&](JobState state) { return static_cast<double>(sequence.jobs[static_cast<size_t>(state)]); };
    const double left = in(JobState::Queued) + in(JobState::Running);
    const double done = in(JobState::Succeeded) + sequence.begun_progress;
    if (left == 0) return 0;
    if (!sequence.started_ms || !(done >= 1)) return std::nullopt;
    const double elapsed = static_cast<double>(now_ms() - *sequence.started_ms) / 1000;
    return elapsed / done * (left - sequence.begun_progress);
}

json frame_object(size_t number, const FrameRow& frame) {
    return {{"frame", number},
            {"time", json::parse(frame.parameters)["time"]},
            {"id", job_id(frame.job)},
            {"seed", frame.seed},
            {"state", job_state_name(frame.state)},
            {"progress", is_over(frame.state) ? 1.0 : frame.progress},
            {"seconds", frame.seconds}};
}

/// What each frame follows from of the one before.
json frames_share(const json& method) {
    const MethodInfo* info = find_method(method["name"].get<std::string>());
    json shared = json::array();
    if (info)
        for (const std::string_view what : left_to_next(*info, method["parameters"])) shared.push_back(what);
    return shared;
}

}  // namespace

JobState SequenceView::state() const {
    const auto in = [&](JobState state) { return jobs[static_cast<size_t>(state)]; };
    if (in(JobState::Queued) + in(JobState::Running) > 0) return has_begun ? JobState::Running : JobState::Queued;
    if (in(JobState::Cancelled) > 0) return JobState::Cancelled;
    return in(JobState::Failed) > 0 ? JobState::Failed : JobState::Succeeded;
}

json SequenceView::object() const {
    json counts = json::object();
    double all = 0, over = 0;
    for (size_t i = 0; i < jobs.size(); ++i) {
        counts[std::string(kJobStates[i])] = jobs[i];
        all += static_cast<double>(jobs[i]);
        if (is_over(static_cast<JobState>(i))) over += static_cast<double>(jobs[i]);
    }
    const JobState reached = state();
    const std::string id = group_id(GroupKind::Sequence, row.seq), self = "/v1/sequences/" + id;
    const std::optional<double> left = seconds_left(*this);
    const json request = json::parse(row.request);
    json object = {{"id", id},
                   {"state", job_state_name(reached)},
                   {"progress", is_over(reached) ? 1.0 : std::min((over + begun_progress) / all, 1.0)},
                   {"seconds_left", left ? json(*left) : json()},
                   {"created", rfc3339(row.created_ms)},
                   {"started", started_ms ? json(rfc3339(*started_ms)) : json()},
                   {"finished", is_over(reached) && finished_ms ? json(rfc3339(*finished_ms)) : json()},
                   {"job_states", counts},
                   {"frames_share", frames_share(request["method"])},
                   {"request", request},
                   {"links",
                    {{"self", self},
                     {"frames", self + "/frames.zip"},
                     {"video", self + "/video"},
                     {"report_html", self + "/report.html"}}}};
    if (!frames) return object;
    json& list = object["frames"] = json::array();
    for (const FrameRow& frame : *frames) list.push_back(frame_object(list.size(), frame));
    return object;
}

}  // namespace photond
