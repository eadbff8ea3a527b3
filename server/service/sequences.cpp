#include "server/service/sequences.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>
#include <mutex>

#include "renderer/core/sha256.h"
#include "server/clock_text.h"

namespace photond {

using nlohmann::json;

std::string sequence_key(const json& sequence, const std::string& what, const std::string& content) {
    const auto id = sequence.at("id").get<std::string>();
    return "comparison/" + std::to_string(group_seq(GroupKind::Sequence, id)) + "/" + what + "/" +
           sha256_hex(content.data(), content.size());
}

SequenceView Sequences::look_at(const ComparisonRow& row, bool with_frames) {
    SequenceView sequence{.row = row};
    for (const StateCount& count : core_.store.count_states(row.seq)) {
        sequence.jobs[static_cast<size_t>(count.state)] = count.jobs;
        if (count.state == JobState::Queued) sequence.begun_progress += count.progress;
        sequence.has_begun = sequence.has_begun || count.state != JobState::Queued;
        if (count.first_started_ms)
            sequence.started_ms = std::min(sequence.started_ms.value_or(INT64_MAX), *count.first_started_ms);
        if (count.last_finished_ms)
            sequence.finished_ms = std::max(sequence.finished_ms.value_or(0), *count.last_finished_ms);
    }
    std::map<int64_t, JobProgress> running;  // by their numbers
    for (JobProgress& job : core_.store.running_jobs_of(row.seq)) {
        job = groups_.progress_now(std::move(job));
        sequence.begun_progress += job.progress;
        running[job.seq] = std::move(job);
    }
    if (!sequence.has_begun) sequence.has_begun = core_.store.has_begun_reference(row);
    if (!with_frames) return sequence;
    sequence.frames = core_.store.frames(row.seq);
    for (FrameRow& frame : *sequence.frames)
        if (const auto now = running.find(frame.job); now != running.end())
            frame.progress = now->second.progress, frame.seconds = now->second.seconds;
    return sequence;
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

std::optional<SequenceView> Sequences::of_key(const std::optional<JobGroups::Key>& key) {
    const auto known = groups_.of_key(key);
    return known ? std::optional(look_at(*known, true)) : std::nullopt;
}

SequenceView Sequences::insert(const SequenceRequest& request, std::vector<PreparedJob> frames,
                               const std::optional<JobGroups::Key>& key) {
    if (core_.stopping) throw Error(ErrorCode::Unavailable, "the daemon is stopping and takes no new jobs");
    ComparisonRow row{.request = request.echo.dump(), .created_ms = now_ms()};
    frames = jobs_.submissions.judge_drafts(request.frames, std::move(frames));
    row.scene = frames.front().row.scene;
    jobs_.intake.check_room(frames);
    std::vector<JobGroups::Member> members;
    members.reserve(frames.size());
    for (size_t i = 0; i < frames.size(); ++i) {
        const double time =
            request.echo["from"].get<double>() + static_cast<double>(i) / request.echo["fps"].get<double>();
        members.push_back(
            {std::move(frames[i]), {.parameters = json{{"time", time}}.dump(), .seed = request.frames[i].seed}});
    }
    std::function<void()> queue;
    row = groups_.insert(std::move(row), members, key, queue);
    SequenceView accepted = look_at(row, true);  // as accepted, whatever happens next
    queue();
    spdlog::info("sequence {}: {} frames", group_id(GroupKind::Sequence, row.seq), members.size());
    return accepted;
}

json Sequences::submit_sequence(const SequenceRequest& request, const std::optional<std::string>& key) {
    const std::optional<JobGroups::Key> asked = JobGroups::key_of(key, request.echo);
    std::optional<SequenceView> sequence;
    std::unique_lock lock(core_.mutex);
    if (sequence = of_key(asked); !sequence) {
        lock.unlock();
        scenes_.know_scene(request.frames.front().scene);
        std::vector<PreparedJob> drafts = draft_frames(request);
        lock.lock();
        if (sequence = of_key(asked); !sequence) sequence = insert(request, std::move(drafts), asked);
    }
    lock.unlock();
    return sequence->object();
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

json Sequences::get_sequence(const std::string& id, bool with_frames) {
    std::unique_lock lock(core_.mutex);
    const SequenceView sequence = look_at(groups_.require(id), with_frames);
    lock.unlock();
    return sequence.object();
}

Page Sequences::list_sequences(uint32_t limit, const std::string& cursor) {
    std::vector<SequenceView> sequences;
    std::unique_lock lock(core_.mutex);
    const JobGroups::RowPage page = groups_.read_page(limit, cursor);
    for (const ComparisonRow& row : page.rows) sequences.push_back(look_at(row, false));
    lock.unlock();
    json items = json::array();
    for (const SequenceView& sequence : sequences) items.push_back(sequence.object());
    return {{"items", std::move(items)}, {"next_cursor", page.next_cursor}};
}

Cancelled Sequences::cancel_sequence(const std::string& id, bool remove) {
    std::unique_lock lock(core_.mutex);
    const ComparisonRow row = groups_.require(id);
    const bool was_over = is_over(look_at(row, false).state());
    SequenceView sequence;
    groups_.cancel(row, remove, [&](const ComparisonRow& now) { sequence = look_at(now, true); });
    lock.unlock();
    return {sequence.object(), was_over};
}

}  // namespace photond
