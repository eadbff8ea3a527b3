// Jobs as clients see them: looked at, cancelled, retried, extended, purged.

#include <spdlog/spdlog.h>

#include <algorithm>

#include "protocol/object_reader.h"
#include "protocol/openapi.h"
#include "protocol/worker_messages.h"
#include "renderer/core/atomic_file.h"
#include "renderer/methods/registry.h"
#include "server/clock_text.h"
#include "server/row_text.h"
#include "server/service_impl.h"

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

}  // namespace

JobRow Service::Impl::require_job(const std::string& id) {
    if (const int64_t seq = job_seq(id); seq != 0)
        if (auto row = store.job(seq)) return *std::move(row);
    throw Error(ErrorCode::NotFound, "there is no job '" + id + "'");
}

json Service::Impl::job_object(const JobRow& row) const {
    int64_t passes_done = row.passes_done;
    double progress = row.progress, seconds = row.seconds;
    json error_now = parsed_or_null(row.error_now), curve = parsed_or_null(row.curve);
    for (const auto& slot : slots)
        if (slot->running && slot->running->seq == row.seq && row.state == JobState::Running) {
            passes_done = slot->running->passes_done;
            progress = slot->running->progress;
            seconds = slot->running->seconds;
            error_now = slot->running->error_now;
            curve = slot->running->curve.empty() ? json() : slot->running->curve;
        }
    json request = json::parse(row.request);
    request["priority"] = row.priority;  // which may have been changed since
    const std::string self = "/v1/jobs/" + job_id(row.seq);
    const bool has_film = passes_done > 0;
    const bool measurable = has_film && !request.value("reference", json()).is_null();
    const auto link = [&](bool there, const char* name) { return there ? json(self + name) : json(); };
    json links = {{"self", self},
                  {"image", self + "/image.exr"},
                  {"preview", self + "/preview.png"},
                  {"statistics", self + "/statistics.json"},
                  {"curve", link(!curve.is_null(), "/curve.csv")},
                  {"difference", link(measurable, "/difference.exr")},
                  {"flip", link(measurable, "/flip.png")},
                  {"error_map", link(measurable, "/error.png")},
                  {"film", link(has_film, "/film")},
                  {"log", self + "/log.txt"},
                  {"events", self + "/events"}};
    for (const ArtefactInfo& artefact : all_artefacts()) links[artefact_link(std::string(artefact.name))] = nullptr;
    for (const json& name : json::parse(row.artefacts))
        links[artefact_link(name.get<std::string>())] = self + "/" + name.get<std::string>();
    return {{"id", job_id(row.seq)},
            {"role", job_role_name(row.role)},
            {"comparison", row.comparison ? json(comparison_id(*row.comparison)) : json()},
            {"reference_job", row.reference_job ? json(job_id(*row.reference_job)) : json()},
            {"state", job_state_name(row.state)},
            {"progress", progress},
            {"passes_done", passes_done},
            {"seconds", seconds},
            {"error_now", error_now},
            {"created", rfc3339(row.created_ms)},
            {"started", time_or_null(row.started_ms)},
            {"finished", time_or_null(row.finished_ms)},
            {"attempts", json::parse(row.attempts)},
            {"request", std::move(request)},
            {"links", links},
            {"statistics", parsed_or_null(row.statistics)},
            {"failure", parsed_or_null(row.failure)},
            {"curve", curve}};
}

json Service::Impl::get_job(const std::string& id) {
    const std::lock_guard lock(mutex);
    return job_object(require_job(id));
}

Service::Cancelled Service::Impl::cancel_job(const std::string& id, bool remove) {
    const std::lock_guard lock(mutex);
    JobRow row = require_job(id);
    if (remove) check_not_compared(row);
    if (remove) check_unused(row, false);
    if (is_over(row.state)) {
        json object = job_object(row);
        if (remove) purge(row);
        return {std::move(object), true};
    }
    if (row.state == JobState::Queued) {
        row.state = JobState::Cancelled;
        row.finished_ms = now_ms();
        commit_state(row, "cancelled while queued");
        queue.remove(row.seq);
        ended(row);
        dispatch();
        json object = job_object(row);
        if (remove) purge(row);
        return {std::move(object), false};
    }
    if (!row.cancel_requested || (remove && !row.purge_requested)) {
        row.cancel_requested = true;
        row.purge_requested = row.purge_requested || remove;
        auto transaction = store.transaction();
        store.update_job(row);
        store.append_log(row.seq, now_ms(), "to be cancelled");
        transaction.commit();
    }
    if (Slot* slot = slot_of(row.seq)) cancel_running(*slot);
    return {job_object(row), false};
}

void Service::Impl::purge(const JobRow& row) {
    auto transaction = store.transaction();
    store.delete_job(row.seq);
    transaction.commit();
    artefacts.forget("job/" + std::to_string(row.seq) + "/");
    remove_film(row.film);
    finish_purges();
}

void Service::Impl::remove_parts(const std::string& film) const {
    remove_quietly(AtomicFile::part_of(files.films / film));
    for (const ArtefactInfo& artefact : all_artefacts())
        remove_quietly(AtomicFile::part_of(artefact_path(files.films / film, artefact.name)));
}

void Service::Impl::remove_film(const std::string& film) const {
    if (film.empty()) return;
    remove_quietly(files.films / film);
    for (const ArtefactInfo& artefact : all_artefacts())
        remove_quietly(artefact_path(files.films / film, artefact.name));
}

json Service::Impl::change_job(const std::string& id, const json& body) {
    BodyFaults faults;
    ObjectReader reader(body, "", faults);
    const auto priority = reader.integer("priority", -100, 100, true);
    reader.finish();
    faults.throw_if_any();
    const std::lock_guard lock(mutex);
    JobRow row = require_job(id);
    if (is_over(row.state))
        throw Error(ErrorCode::WrongState, "job " + id + " is " + std::string(job_state_name(row.state)) +
                                               "; only one that is queued or running has a priority to change");
    if (row.priority == *priority) return job_object(row);
    const std::string line =
        "priority changed from " + std::to_string(row.priority) + " to " + std::to_string(*priority) + " on request";
    row.priority = static_cast<int>(*priority);
    JobRow shown = row;
    if (const RunningAttempt* attempt = running_attempt(row.seq)) {  // further than its row says
        shown.passes_done = attempt->passes_done;
        shown.progress = attempt->progress;
        shown.seconds = attempt->seconds;
        shown.error_now = text_of(attempt->error_now);
    }
    Insertion changed;
    {
        auto transaction = store.transaction();
        if (row.reference_job) raise_reference(*row.reference_job, row.priority, changed);
        store.update_job(row);
        store.append_log(row.seq, now_ms(), line);
        put_event(changed.outbox, "state", row.seq, state_data(shown));
        transaction.commit();
    }
    changed.rows.push_back(row);
    json object = job_object(row);
    accept(std::move(changed));
    return object;
}

json Service::Impl::retry_job(const std::string& id) {
    const std::lock_guard lock(mutex);
    JobRow row = require_job(id);
    if (row.state != JobState::Failed && row.state != JobState::Cancelled)
        throw Error(ErrorCode::WrongState, "job " + id + " is " + std::string(job_state_name(row.state)) +
                                               "; only a failed or cancelled one can be retried");
    return queue_again(std::move(row), "queued again on request");
}

json Service::Impl::extend_job(const std::string& id, const json& body) {
    const std::lock_guard lock(mutex);
    JobRow row = require_job(id);
    json request = json::parse(row.request);
    BodyFaults faults;
    ObjectReader reader(body, "", faults);
    StopConditions stop;
    if (const json* source = reader.member("stop", true))
        stop = read_stop_conditions(*source, reader.at("stop"), vocabulary,
                                    !request.value("reference", json()).is_null(), faults);
    reader.finish();
    faults.throw_if_any();
    // Said again while that is under way, or done, it changes nothing: a client may repeat what it heard no answer to.
    const json was = request["stop"];
    request["stop"] = to_json(stop);
    parse_job_request(request, vocabulary);  // a target's layer must be one of the job's
    if (was == request["stop"] && row.state != JobState::Cancelled && row.state != JobState::Failed)
        return job_object(row);
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

void Service::Impl::check_one_range(const JobRow& row) {
    const json ranges = parsed_or_null(row.statistics).value("pass_ranges", json());
    if (ranges.is_array() && ranges.size() > 1)
        throw Error(ErrorCode::WrongState, "the passes of job " + job_id(row.seq) + " are " +
                                               std::to_string(ranges.size()) + " ranges, " + ranges.dump() +
                                               ": there is no one pass to go on from");
}

json Service::Impl::queue_again(JobRow row, const std::string& why) {
    const JobRequest request = parse_job_request(json::parse(row.request), vocabulary);
    const std::string id = job_id(row.seq);
    if (!has_device(row.device))
        throw Error(ErrorCode::DeviceUnavailable,
                    "job " + id + " is rendered on " + row.device + ", which this daemon was not given");
    check_unused(row, true);
    const auto scene = find_scene(row.scene);
    if (!scene) throw Error(ErrorCode::WrongState, "the scene of job " + id + " has been deleted");
    auto reference = missing_reference(request, *scene, row.reference_job);
    if (!reference && !waits_for(row)) reference_source(row);  // lost: it cannot be measured again
    // The film's next savings take the place of the one it has.
    check_room(reference ? 2 : 1, estimate_disk_bytes(request, *scene));
    const int64_t now = now_ms();
    if (row.role == JobRole::Reference) row.content = reference_content(request, row.scene);
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
        auto transaction = store.transaction();
        if (reference) row.reference_job = insert_reference(*std::move(reference), inserted);
        if (row.reference_job) raise_reference(*row.reference_job, row.priority, inserted);
        store.update_job(row);
        store.append_log(row.seq, now, why + from + waiting_text(row));
        put_event(inserted.outbox, "state", row.seq, state_data(row));
        transaction.commit();
    }
    inserted.rows.push_back(row);
    artefacts.forget("job/" + std::to_string(row.seq) + "/");
    json object = job_object(row);
    accept(std::move(inserted));
    return object;
}

}  // namespace photond
