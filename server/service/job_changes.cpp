#include "server/service/job_changes.h"

#include <algorithm>
#include <mutex>
#include <utility>

#include "protocol/object_reader.h"
#include "server/clock_text.h"
#include "server/row_text.h"

namespace photond {

using nlohmann::json;

namespace {

/// What of its stop conditions a job has done, where that can be told before the end.
double progress_towards(const StopConditions& stop, const JobRow& row) {
    double progress = 0;
    if (stop.passes) progress = std::max(progress, static_cast<double>(row.passes_done) / *stop.passes);
    if (stop.seconds) progress = std::max(progress, row.seconds / *stop.seconds);
    return std::min(progress, 1.0);
}

/// The conditions that what a job has done meets already, as text; empty: none.
std::string met(const StopConditions& stop, const JobRow& row) {
    if (stop.passes && row.passes_done >= *stop.passes)
        return "the film has " + std::to_string(row.passes_done) + " passes already";
    if (stop.seconds && row.seconds >= *stop.seconds) return "the film took " + json(row.seconds).dump() + " s already";
    if (!stop.target) return "";
    const json now = parsed_or_null(row.error_now);
    const json statistics = parsed_or_null(row.statistics);
    json value =
        now.is_object() && now.value("metric", "") == stop.target->metric ? now.value("value", json()) : json();
    if (value.is_null() && statistics.is_object() && statistics.value("error", json()).is_object())
        value = statistics["error"].value(stop.target->metric, json());
    if (value.is_number() && value.get<double>() <= stop.target->value)
        return "the film's " + stop.target->metric + " is " + value.dump() + " already";
    return "";
}

/// Throws WrongState for a merged film with gaps between its passes.
void check_one_range(const JobRow& row) {
    const json ranges = parsed_or_null(row.statistics).value("pass_ranges", json());
    if (ranges.is_array() && ranges.size() > 1)
        throw Error(ErrorCode::WrongState, "the passes of job " + job_id(row.seq) + " are " +
                                               std::to_string(ranges.size()) + " ranges, " + ranges.dump() +
                                               ": there is no one pass to go on from");
}

}  // namespace

json JobChanges::change_job(const std::string& id, const json& body) {
    BodyFaults faults;
    ObjectReader reader(body, "", faults);
    const auto priority = reader.integer("priority", -100, 100, true);
    reader.finish();
    faults.throw_if_any();
    const std::lock_guard lock(core_.mutex);
    JobRow row = objects_.require_job(id);
    if (is_over(row.state))
        throw Error(ErrorCode::WrongState, "job " + id + " is " + std::string(job_state_name(row.state)) +
                                               "; only one that is queued or running has a priority to change");
    if (row.priority == *priority) return objects_.job_object(row);
    const std::string line =
        "priority changed from " + std::to_string(row.priority) + " to " + std::to_string(*priority) + " on request";
    row.priority = static_cast<int>(*priority);
    JobRow shown = row;
    if (const RunningAttempt* attempt = attempts_.running_attempt(row.seq)) {  // further than its row says
        shown.passes_done = attempt->passes_done;
        shown.progress = attempt->progress;
        shown.seconds = attempt->seconds;
        shown.error_now = text_of(attempt->error_now);
    }
    Insertion changed;
    {
        auto transaction = core_.store.transaction();
        references_.raise_references(row, changed);
        core_.store.update_job(row);
        core_.store.append_log(row.seq, now_ms(), line);
        core_.put_event(changed.outbox, "state", row.seq, ServiceCore::state_data(shown));
        transaction.commit();
    }
    changed.rows.push_back(row);
    json object = objects_.job_object(row);
    intake_.accept(std::move(changed));
    return object;
}

json JobChanges::retry_job(const std::string& id) {
    const std::lock_guard lock(core_.mutex);
    JobRow row = objects_.require_job(id);
    if (row.state != JobState::Failed && row.state != JobState::Cancelled)
        throw Error(ErrorCode::WrongState, "job " + id + " is " + std::string(job_state_name(row.state)) +
                                               "; only a failed or cancelled one can be retried");
    return queue_again(std::move(row), "queued again on request");
}

json JobChanges::repeat_job(const std::string& id) {
    const auto require_over = [&] {
        JobRow row = objects_.require_job(id);
        if (row.role != JobRole::Render && row.role != JobRole::Frame)
            throw Error(ErrorCode::WrongState, "job " + id + " is a " + std::string(job_role_name(row.role)) +
                                                   "; only one that was asked for can be repeated");
        if (!is_over(row.state))
            throw Error(ErrorCode::WrongState, "job " + id + " is " + std::string(job_state_name(row.state)) +
                                                   "; only one that is over can be repeated");
        return row;
    };
    std::unique_lock lock(core_.mutex);
    const JobRequest request = parse_job_request(json::parse(require_over().request), core_.vocabulary);
    lock.unlock();
    scenes_.know_scene(request.scene);
    lock.lock();
    const JobRow row = require_over();
    const std::vector<ComparisonJob> runs = repeats_.runs_in_place_of(row);
    for (const ComparisonJob& run : runs)
        if (const auto other = core_.store.job(run.job); other && !is_over(other->state))
            throw Error(ErrorCode::WrongState, "job " + id + " is repeated already, as " + job_id(run.job));
    PreparedJob repeat = submissions_.prepare_job(request);
    if (!runs.empty()) repeat.row.comparison = row.comparison;
    intake_.check_room({&repeat, 1});
    Insertion inserted;
    {
        auto transaction = core_.store.transaction();
        intake_.insert_job(repeat, inserted);
        if (!runs.empty()) repeats_.put_in_place(repeat.row, runs);
        core_.store.append_log(row.seq, repeat.row.created_ms, "repeated on request as " + job_id(repeat.row.seq));
        transaction.commit();
    }
    json object = objects_.job_object(repeat.row);
    intake_.accept(std::move(inserted));
    return object;
}

json JobChanges::extend_job(const std::string& id, const json& body) {
    const std::lock_guard lock(core_.mutex);
    JobRow row = objects_.require_job(id);
    json request = json::parse(row.request);
    BodyFaults faults;
    ObjectReader reader(body, "", faults);
    StopConditions stop;
    if (const json* source = reader.member("stop", true))
        stop = read_stop_conditions(*source, reader.at("stop"), core_.vocabulary,
                                    !request.value("reference", json()).is_null(), faults);
    reader.finish();
    faults.throw_if_any();
    // Said again while that is under way, or done, it changes nothing: a client may repeat what it heard no answer to.
    const json was = request["stop"];
    request["stop"] = to_json(stop);
    parse_job_request(request, core_.vocabulary);  // a target's layer must be one of the job's
    if (was == request["stop"] && row.state != JobState::Cancelled && row.state != JobState::Failed)
        return objects_.job_object(row);
    if (row.state != JobState::Succeeded && row.state != JobState::Cancelled)
        throw Error(ErrorCode::WrongState, "job " + id + " is " + std::string(job_state_name(row.state)) +
                                               "; only a succeeded or cancelled one can be extended");
    if (row.film.empty()) throw Error(ErrorCode::WrongState, "job " + id + " has no film to go on from");
    if (row.role == JobRole::Merged) check_one_range(row);
    if (const std::string has = met(stop, row); !has.empty()) throw Error(ErrorCode::Conflict, "/stop", has);
    row.request = request.dump();
    row.progress = progress_towards(stop, row);
    return queue_again(std::move(row), "extended on request to " + to_json(stop).dump());
}

json JobChanges::queue_again(JobRow row, const std::string& why) {
    const JobRequest request = parse_job_request(json::parse(row.request), core_.vocabulary);
    const std::string id = job_id(row.seq);
    if (!core_.has_device(row.device))
        throw Error(ErrorCode::DeviceUnavailable,
                    "job " + id + " is rendered on " + row.device + ", which this daemon was not given");
    references_.check_unused(row, true);
    const auto scene = scenes_.find_scene(row.scene);
    if (!scene) throw Error(ErrorCode::WrongState, "the scene of job " + id + " has been deleted");
    const std::vector<JobRow> references = references_.missing_references(request, *scene, row.reference_jobs);
    if (references.empty() && !references_.waits_for(row))
        references_.reference_source(row);  // lost: it cannot be measured again
    // The film's next savings take the place of the one it has.
    intake_.check_room(1 + references.size(), estimates_.estimate_disk_bytes(request, *scene));
    const int64_t now = now_ms();
    // What it shows may be other than before. One that was made when a reference was one film is not found by that.
    if (References::is_one_of_two(row.content)) row.content = References::reference_content(request, row.scene);
    row.state = JobState::Queued;
    row.started_ms.reset();
    row.finished_ms.reset();
    row.crashes = row.losses = 0;
    row.cancel_requested = false;
    row.artefacts = "[]";
    row.pixel_hash.clear();
    row.statistics.clear();
    row.failure.clear();
    const std::string from =
        row.film.empty() ? "" : "; goes on from its film of " + std::to_string(row.passes_done) + " passes";
    Insertion inserted;
    {
        auto transaction = core_.store.transaction();
        if (!references.empty()) row.reference_jobs = references_.insert_references(references, inserted);
        references_.raise_references(row, inserted);
        core_.store.update_job(row);
        core_.store.append_log(row.seq, now, why + from + references_.waiting_text(row));
        core_.put_event(inserted.outbox, "state", row.seq, ServiceCore::state_data(row));
        transaction.commit();
    }
    inserted.rows.push_back(row);
    core_.artefacts.forget("job/" + std::to_string(row.seq) + "/");
    json object = objects_.job_object(row);
    intake_.accept(std::move(inserted));
    return object;
}

}  // namespace photond
