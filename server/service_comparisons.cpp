// Comparisons: a request, the jobs it means, and what follows from those. A comparison has no state of its own: it is
// written with all its jobs in one transaction, and from there on everything is read off them.

#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>

#include "protocol/worker_messages.h"
#include "renderer/core/sha256.h"
#include "server/clock_text.h"
#include "server/comparisons/measured_job.h"
#include "server/comparisons/report_text.h"
#include "server/comparisons/verdict.h"
#include "server/row_text.h"
#include "server/service_impl.h"

namespace photond {

using nlohmann::json;

namespace {

/// Faults of a planned job, at the place of the comparison's body that they come from.
Error placed(const Error& error, const PlannedJob& job) {
    std::vector<Fault> faults = error.faults;
    for (Fault& fault : faults)
        if (fault.pointer.starts_with("/method"))
            fault.pointer = "/entries/" + std::to_string(job.entry) + fault.pointer;
    return Error(error.code, error.what(), std::move(faults));
}

/// Of its jobs; a reference that is being made for it begins it.
JobState state_of(const std::vector<JobProgress>& jobs, const std::optional<JobProgress>& reference) {
    size_t over = 0, failed = 0, cancelled = 0;
    bool begun = reference && reference->state != JobState::Queued;
    for (const JobProgress& job : jobs) {
        over += is_over(job.state);
        failed += job.state == JobState::Failed;
        cancelled += job.state == JobState::Cancelled;
        begun = begun || job.state != JobState::Queued;
    }
    if (over < jobs.size()) return begun ? JobState::Running : JobState::Queued;
    if (cancelled > 0) return JobState::Cancelled;
    return failed > 0 ? JobState::Failed : JobState::Succeeded;
}

/// What the comparison took beside its jobs' clocks: on each device the time from the first start to the last end, less
/// the `seconds` of its jobs (and of the reference made for it). So it holds loading, building, saving and measuring,
/// and what other jobs did there in between; not the wait for the first start.
double overhead_seconds(const std::vector<JobProgress>& jobs) {
    struct Span {
        int64_t first_ms = INT64_MAX, last_ms = 0;
        double clocks_s = 0;
    };
    std::map<std::string, Span> devices;
    for (const JobProgress& job : jobs) {
        if (!job.started_ms || !job.finished_ms) continue;
        Span& span = devices[job.device];
        span.first_ms = std::min(span.first_ms, *job.started_ms);
        span.last_ms = std::max(span.last_ms, *job.finished_ms);
        span.clocks_s += job.seconds;
    }
    double overhead = 0;
    for (const auto& [device, span] : devices)
        overhead += std::max(0.0, static_cast<double>(span.last_ms - span.first_ms) / 1000 - span.clocks_s);
    return overhead;
}

std::optional<int64_t> first_start(const std::vector<JobProgress>& jobs) {
    std::optional<int64_t> first;
    for (const JobProgress& job : jobs)
        if (job.started_ms) first = std::min(first.value_or(INT64_MAX), *job.started_ms);
    return first;
}

json summary_json(const ComparisonRow& row, const std::vector<JobProgress>& jobs,
                  const std::optional<JobProgress>& reference) {
    const JobState state = state_of(jobs, reference);
    std::vector<JobProgress> all = jobs;
    if (reference) all.push_back(*reference);
    double progress = 0;
    json counts = json::object();
    for (const std::string_view name : kJobStates) counts[std::string(name)] = 0;
    for (const JobProgress& job : jobs) counts[std::string(job_state_name(job.state))].get_ref<int64_t&>() += 1;
    for (const JobProgress& job : all)
        progress += (is_over(job.state) ? 1 : job.progress) / static_cast<double>(all.size());
    const auto started = first_start(all);
    int64_t finished = 0;
    for (const JobProgress& job : jobs) finished = std::max(finished, job.finished_ms.value_or(0));
    const bool over = is_over(state);
    const std::string self = "/v1/comparisons/" + comparison_id(row.seq);
    return {{"id", comparison_id(row.seq)},
            {"state", job_state_name(state)},
            {"progress", over ? 1.0 : std::min(progress, 1.0)},
            {"created", rfc3339(row.created_ms)},
            {"started", started ? json(rfc3339(*started)) : json()},
            {"finished", over && finished > 0 ? json(rfc3339(finished)) : json()},
            {"job_states", counts},
            {"overhead_seconds", over && started ? json(overhead_seconds(all)) : json()},
            {"request", json::parse(row.request)},
            {"links",
             {{"self", self},
              {"report_json", self + "/report.json"},
              {"report_csv", self + "/report.csv"},
              {"report_html", self + "/report.html"}}}};
}

/// "its own noise": of the metrics that were measured, and where that is too near to what it is compared with.
json reference_json(const ComparisonRow& row, const std::optional<JobProgress>& reference,
                    const std::vector<MeasuredJob>& jobs, const ComparisonTable& table) {
    const json asked = json::parse(row.request).value("reference", json());
    if (asked.is_null()) return nullptr;
    json error = json::object(), warnings = json::array();
    for (const MeasuredJob& job : jobs)
        for (const auto& [metric, noise] : job.reference_error) error[metric] = noise;
    for (const TableRow& table_row : table.rows)
        for (const auto& [metric, figure] : table_row.error)
            if (figure.near_reference)
                warnings.push_back("the " + metric + " of " + row_name(table_row.label, table_row.parameters) + ", " +
                                   short_number(figure.error->mean) + ", is within 3 times the reference's own, " +
                                   short_number(*figure.reference) + ": take a reference of more passes");
    const bool image = asked.is_string() && asked.get_ref<const std::string&>().starts_with("image:");
    return {{"job", reference ? json(job_id(reference->seq)) : json()},
            {"image", image ? json(asked.get<std::string>().substr(6)) : json()},
            {"state", reference ? json(job_state_name(reference->state)) : json()},
            {"error", error.empty() ? json() : error},
            {"warnings", warnings}};
}

TableWishes wishes_of(const json& request) {
    TableWishes wishes;
    const json stop = request.value("stop", json::object());
    if (const json seconds = stop.value("seconds", json()); seconds.is_number()) wishes.seconds = seconds.get<double>();
    if (const json target = stop.value("target", json()); target.is_object())
        wishes.error[target.value("metric", "")] = target.value("value", 0.0);
    return wishes;
}

}  // namespace

ComparisonRow Service::Impl::require_comparison(const std::string& id) {
    if (const int64_t seq = comparison_seq(id); seq != 0)
        if (auto row = store.comparison(seq); row && !row->purge_requested) return *std::move(row);
    throw Error(ErrorCode::NotFound, "there is no comparison '" + id + "'");
}

JobProgress Service::Impl::progress_now(JobProgress job) const {
    for (const auto& slot : slots)
        if (slot->running && slot->running->seq == job.seq && job.state == JobState::Running) {
            job.progress = slot->running->progress;
            job.seconds = slot->running->seconds;
        }
    return job;
}

Service::Impl::ComparisonState Service::Impl::comparison_state(const ComparisonRow& row) {
    ComparisonState state;
    std::optional<int64_t> reference;
    for (const JobProgress& job : store.comparison_progress(row.seq)) {
        if (job.reference_job) reference = job.reference_job;
        state.jobs.push_back(progress_now(job));
    }
    if (!reference) return state;
    const auto found = store.job(*reference);
    if (!found) return state;
    state.reference = progress_now({found->seq, found->state, found->device, found->progress, found->seconds,
                                    found->started_ms, found->finished_ms, std::nullopt});
    state.made_for_it = found->role == JobRole::Reference && found->created_ms >= row.created_ms;
    return state;
}

json Service::Impl::comparison_summary(const ComparisonRow& row) {
    const ComparisonState state = comparison_state(row);
    return summary_json(row, state.jobs, state.made_for_it ? state.reference : std::nullopt);
}

Service::Impl::Compared Service::Impl::read_comparison(const ComparisonRow& row) {
    Compared compared{row, comparison_state(row), {}};
    for (ComparisonJob& planned : store.comparison_jobs(row.seq)) {
        auto job = store.job(planned.job);
        if (!job) continue;  // being purged
        if (const RunningAttempt* attempt = running_attempt(job->seq); attempt && job->state == JobState::Running) {
            job->passes_done = attempt->passes_done;
            job->seconds = attempt->seconds;
            if (!attempt->curve.empty()) job->curve = attempt->curve.dump();
        }
        compared.jobs.emplace_back(std::move(planned), *std::move(job));
    }
    return compared;
}

Service::Impl::Judged Service::Impl::judge(const Compared& compared) {
    Judged judged;
    json& object = judged.object;
    const ComparisonState& state = compared.state;
    object = summary_json(compared.row, state.jobs, state.made_for_it ? state.reference : std::nullopt);
    json& jobs = object["jobs"] = json::array();
    for (const auto& [planned, row] : compared.jobs) {
        MeasuredJob job;
        job.id = job_id(row.seq);
        job.label = planned.label;
        job.parameters = json::parse(planned.parameters);
        job.seed = planned.seed;
        job.state = job_state_name(row.state);
        job.passes = static_cast<uint64_t>(row.passes_done);
        job.seconds = row.seconds;
        add_measurements(job, parsed_or_null(row.curve), parsed_or_null(row.statistics));
        jobs.push_back({{"id", job.id},
                        {"label", job.label},
                        {"parameters", job.parameters},
                        {"seed", job.seed},
                        {"state", job.state},
                        {"passes_done", job.passes},
                        {"seconds", job.seconds}});
        judged.jobs.push_back(std::move(job));
    }
    const json& request = object["request"];
    judged.table = make_table(judged.jobs, request.at("metrics").get<std::vector<std::string>>(), wishes_of(request));
    object["table"] = to_json(judged.table);
    object["verdicts"] = verdicts_json(judged.table);
    object["reference"] = reference_json(compared.row, state.reference, judged.jobs, judged.table);
    return judged;
}

Service::Impl::Compared Service::Impl::read_comparison(const std::string& id) {
    const std::lock_guard lock(mutex);
    return read_comparison(require_comparison(id));
}

json Service::Impl::get_comparison(const std::string& id) { return judge(read_comparison(id)).object; }

std::vector<PreparedJob> Service::Impl::prepare_jobs(const ComparisonRequest& request) {
    std::vector<PreparedJob> jobs;
    for (const PlannedJob& planned : request.jobs) try {
            jobs.push_back(prepare_job(planned.request));
        } catch (const Error& error) {
            throw placed(error, planned);
        }
    return jobs;
}

json Service::Impl::submit_comparison(const ComparisonRequest& request, const std::optional<std::string>& key) {
    const std::string body = request.echo.dump();
    const std::string body_sha256 = key ? sha256_hex(body.data(), body.size()) : "";
    if (key) check_idempotency_key(*key);
    know_scene(request.jobs.front().request.scene);
    std::unique_lock lock(mutex);
    if (key)
        if (const auto known = store.comparison_key(*key)) {
            if (known->body_sha256 != body_sha256)
                throw Error(ErrorCode::IdempotencyMismatch,
                            "the Idempotency-Key was used with another body, for " + comparison_id(known->comparison));
            const Compared compared = read_comparison(require_comparison(comparison_id(known->comparison)));
            lock.unlock();
            return judge(compared).object;
        }
    if (stopping) throw Error(ErrorCode::Unavailable, "the daemon is stopping and takes no new jobs");
    ComparisonRow row;
    row.created_ms = now_ms();
    row.request = body;
    std::vector<PreparedJob> jobs = prepare_jobs(request);
    row.scene = jobs.front().row.scene;
    check_room(jobs);
    Insertion inserted;
    {
        auto transaction = store.transaction();
        store.insert_comparison(row);
        for (size_t i = 0; i < jobs.size(); ++i) {
            jobs[i].row.comparison = row.seq;
            insert_job(jobs[i], inserted);
            const PlannedJob& planned = request.jobs[i];
            store.insert_comparison_job(row.seq, static_cast<int64_t>(i),
                                        {jobs[i].row.seq, planned.label, planned.parameters.dump(), planned.seed});
        }
        if (key) store.insert_comparison_key(*key, body_sha256, row.seq, row.created_ms);
        transaction.commit();
    }
    const Compared compared = read_comparison(row);  // as accepted, whatever happens next
    accept(std::move(inserted));
    lock.unlock();
    spdlog::info("comparison {}: {} jobs", comparison_id(row.seq), jobs.size());
    return judge(compared).object;
}

Page Service::Impl::list_comparisons(uint32_t limit, const std::string& cursor) {
    check_limit(limit);
    const int64_t before = read_cursor(cursor, INT64_MAX);
    json items = json::array(), next;
    const std::lock_guard lock(mutex);
    const std::vector<ComparisonRow> rows = store.comparisons(before, limit);
    for (const ComparisonRow& row : rows)
        if (!row.purge_requested) items.push_back(comparison_summary(row));
    if (rows.size() == limit) next = std::to_string(rows.back().seq);
    return {{"items", std::move(items)}, {"next_cursor", std::move(next)}};
}

/// Cancels what waits and asks for what runs to be cancelled, all in one transaction.
void Service::Impl::cancel_jobs(std::vector<JobRow> rows, const std::function<void()>& more, bool remove) {
    Outbox outbox;
    {
        auto transaction = store.transaction();
        for (JobRow& row : rows) {
            if (is_over(row.state)) continue;
            const bool waiting = row.state == JobState::Queued;
            if (waiting) {
                row.state = JobState::Cancelled;
                row.finished_ms = now_ms();
            } else {
                row.cancel_requested = true;
                row.purge_requested = row.purge_requested || remove;
            }
            store.update_job(row);
            store.append_log(row.seq, now_ms(), waiting ? "cancelled while queued" : "to be cancelled");
            if (waiting) put_event(outbox, "state", row.seq, state_data(row));
        }
        more();
        transaction.commit();
    }
    tell(std::move(outbox));
    for (const JobRow& row : rows)
        if (row.state == JobState::Cancelled && queue.remove(row.seq)) ended(row);
    for (const JobRow& row : rows)
        if (Slot* slot = is_over(row.state) ? nullptr : slot_of(row.seq)) cancel_running(*slot);
}

std::vector<JobRow> Service::Impl::jobs_of_comparison(int64_t seq) {
    std::vector<JobRow> rows;
    for (const ComparisonJob& planned : store.comparison_jobs(seq))
        if (auto row = store.job(planned.job)) rows.push_back(*std::move(row));
    return rows;
}

Service::Cancelled Service::Impl::cancel_comparison(const std::string& id, bool remove) {
    std::unique_lock lock(mutex);
    ComparisonRow row = require_comparison(id);
    const ComparisonState before = comparison_state(row);
    const bool was_over = is_over(state_of(before.jobs, std::nullopt));
    std::vector<JobRow> jobs = jobs_of_comparison(row.seq);
    if (remove)
        for (const JobRow& job : jobs)
            for (const JobRow& user : store.unfinished_jobs_measured_against(job.seq))
                if (user.comparison != row.seq) check_unused(job, false);
    cancel_jobs(
        std::move(jobs),
        [&] {
            row.purge_requested = remove;
            if (remove) store.update_comparison(row);
        },
        remove);
    // The reference that was made for it alone is not wanted any more.
    if (before.made_for_it && !is_over(before.reference->state) &&
        store.unfinished_jobs_measured_against(before.reference->seq).empty())
        if (auto reference = store.job(before.reference->seq))
            cancel_jobs(
                {*std::move(reference)}, [] {}, false);
    const Compared compared = read_comparison(row);
    if (remove) finish_purge(row);
    dispatch();
    lock.unlock();
    return {judge(compared).object, was_over};
}

void Service::Impl::finish_purge(const ComparisonRow& row) {
    std::vector<JobRow> removed;
    {
        auto transaction = store.transaction();
        bool empty = true;
        for (JobRow& job : jobs_of_comparison(row.seq)) {
            if (!is_over(job.state)) {  // goes when its worker has let go of it, and the comparison with the last one
                empty = false;
                continue;
            }
            store.delete_job(job.seq);
            removed.push_back(std::move(job));
        }
        if (empty) store.delete_comparison(row.seq);
        transaction.commit();
    }
    for (const JobRow& job : removed) {
        artefacts.forget("job/" + std::to_string(job.seq) + "/");
        remove_film(job.film);
    }
    artefacts.forget("comparison/" + std::to_string(row.seq) + "/");
}

void Service::Impl::finish_purges() {
    for (const ComparisonRow& row : store.comparisons_to_purge()) finish_purge(row);
}

void Service::Impl::check_not_compared(const JobRow& row) {
    if (row.comparison && store.comparison(*row.comparison))
        throw Error(ErrorCode::WrongState, "job " + job_id(row.seq) + " belongs to comparison " +
                                               comparison_id(*row.comparison) + "; it is removed with that");
}

json Service::submit_comparison(const ComparisonRequest& request, const std::optional<std::string>& idempotency_key) {
    return impl_->submit_comparison(request, idempotency_key);
}
json Service::get_comparison(const std::string& id) { return impl_->get_comparison(id); }
Page Service::list_comparisons(uint32_t limit, const std::string& cursor) {
    return impl_->list_comparisons(limit, cursor);
}
Service::Cancelled Service::cancel_comparison(const std::string& id) { return impl_->cancel_comparison(id, false); }
Service::Cancelled Service::purge_comparison(const std::string& id) { return impl_->cancel_comparison(id, true); }

}  // namespace photond
