#include "server/service/job_objects.h"

#include "protocol/openapi.h"
#include "renderer/methods/registry.h"
#include "server/clock_text.h"
#include "server/row_text.h"

namespace photond {

using nlohmann::json;

JobRow JobObjects::require_job(const std::string& id) {
    if (const int64_t seq = job_seq(id); seq != 0)
        if (auto row = core_.store.job(seq)) return *std::move(row);
    throw Error(ErrorCode::NotFound, "there is no job '" + id + "'");
}

std::string JobObjects::job_text(const JobRow& row) const {
    int64_t passes_done = row.passes_done;
    double progress = row.progress, seconds = row.seconds;
    std::string error_now = row.error_now, curve = row.curve;
    const RunningAttempt* attempt = row.state == JobState::Running ? attempts_.running_attempt(row.seq) : nullptr;
    if (attempt) {  // further than its row says
        passes_done = attempt->passes_done;
        progress = attempt->progress;
        seconds = attempt->seconds;
        error_now = text_of(attempt->error_now);
        curve = text_of(attempt->curve);
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
                  {"curve", link(!curve.empty(), "/curve.csv")},
                  {"difference", link(measurable, "/difference.exr")},
                  {"flip", link(measurable, "/flip.png")},
                  {"error_map", link(measurable, "/error.png")},
                  {"film", link(has_film, "/film")},
                  {"log", self + "/log.txt"},
                  {"events", self + "/events"}};
    for (const ArtefactInfo& artefact : all_artefacts()) links[artefact_link(std::string(artefact.name))] = nullptr;
    for (const json& name : is_over(row.state) ? json::parse(row.artefacts) : json::array())
        links[artefact_link(name.get<std::string>())] = self + "/" + name.get<std::string>();
    json reference_jobs;
    for (const int64_t seq : row.reference_jobs) reference_jobs.push_back(job_id(seq));
    return ObjectText()
        .add_text("attempts", row.attempts)
        .add("comparison", group_json(GroupKind::Comparison, row.role, row.comparison))
        .add("created", rfc3339(row.created_ms))
        .add_text("curve", curve)
        .add_text("error_now", error_now)
        .add_text("failure", row.failure)
        .add("finished", time_or_null(row.finished_ms))
        .add("id", job_id(row.seq))
        .add("links", links)
        .add("passes_done", passes_done)
        .add("progress", progress)
        .add("reference_job", reference_jobs.is_null() ? json() : reference_jobs.front())
        .add("reference_jobs", reference_jobs)
        .add("request", request)
        .add("role", job_role_name(row.role))
        .add("seconds", seconds)
        .add("sequence", group_json(GroupKind::Sequence, row.role, row.comparison))
        .add("started", time_or_null(row.started_ms))
        .add("state", job_state_name(row.state))
        .add_text("statistics", row.statistics)
        .add("waiting_for", row.state == JobState::Queued ? json(attempts_.waiting_for(row.seq, row.device)) : json())
        .text();
}

json JobObjects::get_job(const std::string& id) {
    const std::lock_guard lock(core_.mutex);
    return job_object(require_job(id));
}

std::optional<JobRow> JobObjects::job_of_key(const std::string& key, const std::string& body_sha256) {
    const auto known = core_.store.key(key);
    if (!known) return std::nullopt;
    if (known->body_sha256 != body_sha256)
        throw Error(ErrorCode::IdempotencyMismatch,
                    "the Idempotency-Key was used with another body, for job " + job_id(known->job));
    return require_job(job_id(known->job));
}

}  // namespace photond
