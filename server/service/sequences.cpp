#include "server/service/sequences.h"

#include <spdlog/spdlog.h>

#include <algorithm>

#include "renderer/core/sha256.h"
#include "server/clock_text.h"

namespace photond {

using nlohmann::json;

namespace {

/// Seconds until the last frame will be done, by those that are: the time since the first one began over their number.
std::optional<double> seconds_left(const std::vector<JobProgress>& frames) {
    std::optional<int64_t> started;
    double done = 0;
    size_t left = 0;
    for (const JobProgress& frame : frames) {
        if (frame.started_ms) started = std::min(started.value_or(INT64_MAX), *frame.started_ms);
        done += frame.state == JobState::Succeeded ? 1 : is_over(frame.state) ? 0 : frame.progress;
        left += !is_over(frame.state);
    }
    if (left == 0) return 0;
    if (!started || !(done >= 1)) return std::nullopt;
    double running = 0;
    for (const JobProgress& frame : frames)
        if (!is_over(frame.state)) running += frame.progress;
    const double elapsed = static_cast<double>(now_ms() - *started) / 1000;
    return elapsed / done * (static_cast<double>(left) - running);
}

json summary_of(const ComparisonRow& row, const ComparisonState& state) {
    const std::vector<JobProgress>& frames = state.jobs;
    json counts = json::object();
    for (const std::string_view name : kJobStates) counts[std::string(name)] = 0;
    std::optional<int64_t> started, finished;
    double progress = 0;
    for (const JobProgress& frame : frames) {
        counts[std::string(job_state_name(frame.state))].get_ref<int64_t&>() += 1;
        if (frame.started_ms) started = std::min(started.value_or(INT64_MAX), *frame.started_ms);
        if (frame.finished_ms) finished = std::max(finished.value_or(0), *frame.finished_ms);
        progress += (is_over(frame.state) ? 1 : frame.progress) / static_cast<double>(frames.size());
    }
    const JobState reached = state.state();
    const bool over = is_over(reached);
    const std::string self = "/v1/sequences/" + group_id(GroupKind::Sequence, row.seq);
    const std::optional<double> left = over ? std::optional(0.0) : seconds_left(frames);
    return {{"id", group_id(GroupKind::Sequence, row.seq)},
            {"state", job_state_name(reached)},
            {"progress", over ? 1.0 : std::min(progress, 1.0)},
            {"seconds_left", left ? json(*left) : json()},
            {"created", rfc3339(row.created_ms)},
            {"started", started ? json(rfc3339(*started)) : json()},
            {"finished", over && finished ? json(rfc3339(*finished)) : json()},
            {"job_states", counts},
            {"request", json::parse(row.request)},
            {"links",
             {{"self", self},
              {"frames", self + "/frames.zip"},
              {"video", self + "/video"},
              {"report_html", self + "/report.html"}}}};
}

}  // namespace

std::string sequence_key(const json& sequence, const std::string& what, const std::string& content) {
    const auto id = sequence.at("id").get<std::string>();
    return "comparison/" + std::to_string(group_seq(GroupKind::Sequence, id)) + "/" + what + "/" +
           sha256_hex(content.data(), content.size());
}

std::vector<PreparedJob> Sequences::draft_frames(const SequenceRequest& request) {
    std::optional<SceneRef> scene;
    {
        const std::lock_guard lock(core_.mutex);
        scene = scenes_.find_scene(request.frames.front().scene);
    }
    std::vector<PreparedJob> frames;
    if (!scene) return frames;
    frames.reserve(request.frames.size());
    for (const JobRequest& frame : request.frames) frames.push_back(jobs_.submissions.draft_job(frame, scene->id));
    return frames;
}

json Sequences::submit_sequence(const SequenceRequest& request, const std::optional<std::string>& key) {
    ComparisonRow row;
    row.request = request.echo.dump();
    const std::optional<JobGroups::Key> asked = JobGroups::key_of(key, request.echo);
    if (asked) {
        const std::lock_guard lock(core_.mutex);
        if (const auto known = groups_.of_key(asked)) return object_of(*known);
    }
    scenes_.know_scene(request.frames.front().scene);
    std::vector<PreparedJob> drafts = draft_frames(request);
    const std::lock_guard lock(core_.mutex);
    if (const auto known = groups_.of_key(asked)) return object_of(*known);
    if (core_.stopping) throw Error(ErrorCode::Unavailable, "the daemon is stopping and takes no new jobs");
    row.created_ms = now_ms();
    std::vector<PreparedJob> frames = jobs_.submissions.judge_drafts(request.frames, std::move(drafts));
    row.scene = frames.front().row.scene;
    jobs_.intake.check_room(frames);
    std::vector<JobGroups::Member> members;
    for (size_t i = 0; i < frames.size(); ++i) {
        const double time =
            request.echo["from"].get<double>() + static_cast<double>(i) / request.echo["fps"].get<double>();
        members.push_back(
            {std::move(frames[i]), {.parameters = json{{"time", time}}.dump(), .seed = request.frames[i].seed}});
    }
    std::function<void()> queue;
    row = groups_.insert(std::move(row), members, asked, queue);
    json object = object_of(row);  // as accepted, whatever happens next
    queue();
    spdlog::info("sequence {}: {} frames", group_id(GroupKind::Sequence, row.seq), members.size());
    return object;
}

json Sequences::object_of(const ComparisonRow& row) {
    const ComparisonState state = groups_.state_of(row);
    json object = summary_of(row, state);
    std::map<int64_t, const JobProgress*> known;
    for (const JobProgress& job : state.jobs) known[job.seq] = &job;
    json frames = json::array();
    for (const ComparisonJob& planned : core_.store.comparison_jobs(row.seq)) {
        const auto job = known.find(planned.job);
        if (job == known.end()) continue;  // being removed
        frames.push_back({{"frame", frames.size()},
                          {"time", json::parse(planned.parameters)["time"]},
                          {"id", job_id(planned.job)},
                          {"seed", planned.seed},
                          {"state", job_state_name(job->second->state)},
                          {"progress", is_over(job->second->state) ? 1.0 : job->second->progress},
                          {"seconds", job->second->seconds}});
    }
    object["frames"] = std::move(frames);
    return object;
}

json Sequences::estimate_sequence(const SequenceRequest& request) {
    const std::string& scene_name = request.frames.front().scene;
    scenes_.know_scene(scene_name);
    std::vector<PreparedJob> drafts = draft_frames(request);
    const std::lock_guard lock(core_.mutex);
    drafts = jobs_.submissions.judge_drafts(request.frames, std::move(drafts));
    jobs_.intake.check_room(drafts);
    const auto scene = scenes_.find_scene(scene_name);
    if (!scene) throw Error(ErrorCode::Internal, "a scene that was found is not there");
    // Frames differ in their moments alone: what is told of one is told of all.
    EarlierJobs earlier;
    const JobRequest& frame = request.frames.front();
    const auto frames = static_cast<double>(request.frames.size());
    const TimeEstimate time = jobs_.estimates.estimate_time(frame, *scene, earlier);
    return {{"frames", request.frames.size()},
            {"memory_bytes", jobs_.estimates.estimate_memory_bytes(frame, *scene)},
            {"disk_bytes", jobs_.estimates.estimate_disk_bytes(frame, *scene) * request.frames.size()},
            {"seconds", time.seconds ? json(*time.seconds * frames) : json()},
            {"warning", time.warning.empty() ? json() : json(time.warning)}};
}

json Sequences::get_sequence(const std::string& id) {
    const std::lock_guard lock(core_.mutex);
    return object_of(groups_.require(id));
}

Page Sequences::list_sequences(uint32_t limit, const std::string& cursor) {
    return groups_.list(limit, cursor, summary_of);
}

Cancelled Sequences::cancel_sequence(const std::string& id, bool remove) {
    const std::lock_guard lock(core_.mutex);
    const ComparisonRow row = groups_.require(id);
    const bool was_over = is_over(groups_.state_of(row).state());
    json object;
    groups_.cancel(row, remove, [&](const ComparisonRow& now) { object = object_of(now); });
    return {std::move(object), was_over};
}

}  // namespace photond
