// Lists of jobs, whole or as summaries: filters read, and rows as clients see them.

#include <algorithm>
#include <utility>

#include "server/clock_text.h"
#include "server/row_text.h"
#include "server/service/job_objects.h"
#include "server/service/page_cursor.h"

namespace photond {

using nlohmann::json;

namespace {

constexpr size_t kJobsAtOnce = 16;  // of a list, under one lock: about a millisecond

/// "queued,running".
std::vector<JobState> states_named(const std::string& list) {
    std::vector<JobState> states;
    for (size_t begin = 0; begin <= list.size() && !list.empty();) {
        const size_t end = std::min(list.find(',', begin), list.size());
        const std::string name = list.substr(begin, end - begin);
        const auto state = job_state_named(name);
        if (!state)
            throw Error(ErrorCode::OutOfRange, "/state",
                        "'" + name + "' is none of queued, running, succeeded, failed, cancelled");
        states.push_back(*state);
        begin = end + 1;
    }
    return states;
}

/// All but the scene, which the store has to be asked for.
JobQuery query_of(const JobFilter& filter) {
    check_limit(filter.limit);
    if (filter.view != "full" && filter.view != "summary")
        throw Error(ErrorCode::OutOfRange, "/view", "'" + filter.view + "' is none of full, summary");
    JobQuery query;
    if (filter.order == "queue")
        query.order = JobOrder::Queue;
    else if (filter.order == "ended")
        query.order = JobOrder::Ended;
    else if (filter.order != "newest")
        throw Error(ErrorCode::OutOfRange, "/order", "'" + filter.order + "' is none of newest, queue, ended");
    if (query.order != JobOrder::Newest && !filter.cursor.empty())
        throw Error(ErrorCode::OutOfRange, "/cursor", "a cursor goes with order=newest alone; use offset");
    query.limit = filter.limit;
    query.offset = filter.offset;
    query.before = read_cursor(filter.cursor, INT64_MAX);
    query.states = states_named(filter.state);
    if (!filter.label.empty()) {
        const size_t equals = filter.label.find('=');
        query.label_key = filter.label.substr(0, equals);
        if (equals != std::string::npos) query.label_value = filter.label.substr(equals + 1);
        if (query.label_key.empty()) throw Error(ErrorCode::OutOfRange, "/label", "a label is KEY or KEY=VALUE");
    }
    if (!filter.role.empty()) {
        query.role = job_role_named(filter.role);
        if (!query.role)
            throw Error(ErrorCode::OutOfRange, "/role",
                        "'" + filter.role + "' is none of render, reference, merged, frame");
    }
    query.method = filter.method;
    query.device = filter.device;
    return query;
}

json summary_json(const JobSummary& row) {
    return {{"id", job_id(row.seq)},
            {"role", job_role_name(row.role)},
            {"comparison", group_json(GroupKind::Comparison, row.role, row.comparison)},
            {"sequence", group_json(GroupKind::Sequence, row.role, row.comparison)},
            {"state", job_state_name(row.state)},
            {"progress", row.progress},
            {"passes_done", row.passes_done},
            {"seconds", row.seconds},
            {"error_now", parsed_or_null(row.error_now)},
            {"created", rfc3339(row.created_ms)},
            {"started", time_or_null(row.started_ms)},
            {"finished", time_or_null(row.finished_ms)},
            {"scene", row.scene},
            {"method", row.method},
            {"device", row.device},
            {"width", row.width},
            {"height", row.height},
            {"priority", row.priority},
            {"labels", json::parse(row.labels)},
            {"failure", row.failure.empty() ? json() : json(row.failure)}};
}

}  // namespace

json JobObjects::job_summary(const JobSummary& row) {
    json object = summary_json(row);
    const auto awaited = row.state == JobState::Queued ? core_.queue.waits_for(row.seq) : std::nullopt;
    object["waits_for"] = awaited ? json(job_id(*awaited)) : json();
    object["waiting_for"] = row.state == JobState::Queued ? json(attempts_.waiting_for(row.seq, row.device)) : json();
    if (row.state != JobState::Running) return object;
    if (const RunningAttempt* attempt = attempts_.running_attempt(row.seq)) {
        object["progress"] = attempt->progress;
        object["passes_done"] = attempt->passes_done;
        object["seconds"] = attempt->seconds;
        object["error_now"] = attempt->error_now;
    }
    return object;
}

std::optional<std::string> JobObjects::listed_job(int64_t seq) {
    const auto row = core_.store.job(seq);
    return row ? std::optional(job_text(*row)) : std::nullopt;
}

std::optional<std::string> JobObjects::listed_summary(int64_t seq) {
    const auto row = core_.store.job_summary(seq);
    return row ? std::optional(job_summary(*row).dump(-1, ' ', false, json::error_handler_t::replace)) : std::nullopt;
}

void JobObjects::list_jobs(const JobFilter& filter, const TextSink& write) {
    JobQuery query = query_of(filter);
    const bool summaries = filter.view == "summary";
    std::vector<int64_t> page;
    int64_t total = 0;
    {
        const std::lock_guard lock(core_.mutex);
        if (!filter.scene.empty()) {
            // A scene that has been deleted is still found by its id.
            const auto scene = scenes_.find_scene(filter.scene);
            query.scene = scene ? scene->id : filter.scene;
        }
        if (summaries) total = core_.store.count_jobs(query);
        page = core_.store.job_page(query);
    }
    std::string text = "{\"items\":[";
    bool first = true;
    for (size_t at = 0; at < page.size(); write(std::exchange(text, {}))) {
        const std::lock_guard lock(core_.mutex);
        for (const size_t end = std::min(page.size(), at + kJobsAtOnce); at < end; ++at) {
            const auto item = summaries ? listed_summary(page[at]) : listed_job(page[at]);
            if (!item) continue;  // removed since
            if (!std::exchange(first, false)) text += ',';
            text += *item;
        }
    }
    const bool whole = page.size() == filter.limit && query.order == JobOrder::Newest;  // there may be more
    text += "],\"next_cursor\":" + (whole ? json(std::to_string(page.back())) : json()).dump();
    if (summaries) text += ",\"total\":" + std::to_string(total);
    write(text + "}\n");
}

}  // namespace photond
