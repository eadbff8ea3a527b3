#include "server/service/comparisons.h"

#include <spdlog/spdlog.h>

#include <mutex>

#include "renderer/core/sha256.h"
#include "server/clock_text.h"
#include "server/service/idempotency_key.h"
#include "server/service/page_cursor.h"

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

}  // namespace

ComparisonRow Comparisons::require_comparison(const std::string& id) {
    if (const int64_t seq = comparison_seq(id); seq != 0)
        if (auto row = core_.store.comparison(seq); row && !row->purge_requested) return *std::move(row);
    throw Error(ErrorCode::NotFound, "there is no comparison '" + id + "'");
}

JobProgress Comparisons::progress_now(JobProgress job) const {
    if (job.state != JobState::Running) return job;
    if (const RunningAttempt* attempt = attempts_.running_attempt(job.seq)) {
        job.progress = attempt->progress;
        job.seconds = attempt->seconds;
    }
    return job;
}

ComparisonState Comparisons::comparison_state(const ComparisonRow& row) {
    ComparisonState state;
    for (const JobProgress& job : core_.store.comparison_progress(row.seq)) state.jobs.push_back(progress_now(job));
    for (const int64_t seq : references_of(state.jobs)) {
        const auto found = core_.store.job(seq);
        if (!found) continue;
        state.references.push_back(progress_now({found->seq, found->state, found->device, found->progress,
                                                 found->seconds, found->started_ms, found->finished_ms}));
        if (found->role == JobRole::Reference && found->created_ms >= row.created_ms)
            state.own_references.push_back(state.references.back());
    }
    return state;
}

Compared Comparisons::read_comparison(const ComparisonRow& row) {
    Compared compared{row, comparison_state(row), {}, {}, core_.store.row_biases(row.seq)};
    for (const JobProgress& film : compared.state.references)
        if (auto reference = core_.store.job(film.seq)) compared.references.push_back(*std::move(reference));
    for (ComparisonJob& planned : core_.store.comparison_jobs(row.seq)) {
        auto job = core_.store.job(planned.job);
        if (!job) continue;  // being purged
        if (const RunningAttempt* attempt = attempts_.running_attempt(job->seq);
            attempt && job->state == JobState::Running) {
            job->passes_done = attempt->passes_done;
            job->seconds = attempt->seconds;
            if (!attempt->curve.empty()) job->curve = attempt->curve.dump();
        }
        compared.jobs.emplace_back(std::move(planned), *std::move(job));
    }
    return compared;
}

Compared Comparisons::read_comparison(const std::string& id) {
    const std::lock_guard lock(core_.mutex);
    return read_comparison(require_comparison(id));
}

json Comparisons::get_comparison(const std::string& id) { return judge(read_comparison(id)).object; }

std::vector<PreparedJob> Comparisons::prepare_jobs(const ComparisonRequest& request) {
    std::vector<PreparedJob> jobs;
    for (const PlannedJob& planned : request.jobs) try {
            jobs.push_back(jobs_.submissions.prepare_job(planned.request));
        } catch (const Error& error) {
            throw placed(error, planned);
        }
    return jobs;
}

json Comparisons::submit_comparison(const ComparisonRequest& request, const std::optional<std::string>& key) {
    const std::string body = request.echo.dump();
    const std::string body_sha256 = key ? sha256_hex(body.data(), body.size()) : "";
    if (key) check_idempotency_key(*key);
    scenes_.know_scene(request.jobs.front().request.scene);
    std::unique_lock lock(core_.mutex);
    if (key)
        if (const auto known = core_.store.comparison_key(*key)) {
            if (known->body_sha256 != body_sha256)
                throw Error(ErrorCode::IdempotencyMismatch,
                            "the Idempotency-Key was used with another body, for " + comparison_id(known->comparison));
            const Compared compared = read_comparison(require_comparison(comparison_id(known->comparison)));
            lock.unlock();
            return judge(compared).object;
        }
    if (core_.stopping) throw Error(ErrorCode::Unavailable, "the daemon is stopping and takes no new jobs");
    ComparisonRow row;
    row.created_ms = now_ms();
    row.request = body;
    std::vector<PreparedJob> jobs = prepare_jobs(request);
    row.scene = jobs.front().row.scene;
    jobs_.intake.check_room(jobs);
    Insertion inserted;
    {
        auto transaction = core_.store.transaction();
        core_.store.insert_comparison(row);
        for (size_t i = 0; i < jobs.size(); ++i) {
            jobs[i].row.comparison = row.seq;
            jobs_.intake.insert_job(jobs[i], inserted);
            const PlannedJob& planned = request.jobs[i];
            core_.store.insert_comparison_job(
                row.seq, static_cast<int64_t>(i),
                {jobs[i].row.seq, planned.label, planned.parameters.dump(), planned.seed});
        }
        if (key) core_.store.insert_comparison_key(*key, body_sha256, row.seq, row.created_ms);
        transaction.commit();
    }
    const Compared compared = read_comparison(row);  // as accepted, whatever happens next
    jobs_.intake.accept(std::move(inserted));
    lock.unlock();
    spdlog::info("comparison {}: {} jobs", comparison_id(row.seq), jobs.size());
    return judge(compared).object;
}

Page Comparisons::list_comparisons(uint32_t limit, const std::string& cursor) {
    check_limit(limit);
    const int64_t before = read_cursor(cursor, INT64_MAX);
    json items = json::array(), next;
    const std::lock_guard lock(core_.mutex);
    const std::vector<ComparisonRow> rows = core_.store.comparisons(before, limit);
    for (const ComparisonRow& row : rows)
        if (!row.purge_requested) items.push_back(comparison_summary(row, comparison_state(row)));
    if (rows.size() == limit) next = std::to_string(rows.back().seq);
    return {{"items", std::move(items)}, {"next_cursor", std::move(next)}};
}

Cancelled Comparisons::cancel_comparison(const std::string& id, bool remove) {
    std::unique_lock lock(core_.mutex);
    ComparisonRow row = require_comparison(id);
    const ComparisonState before = comparison_state(row);
    const bool was_over = is_over(before.state());
    std::vector<JobRow> jobs = purges_.jobs_of_comparison(row.seq);
    if (remove)
        for (const JobRow& job : jobs)
            for (const JobRow& user : core_.store.unfinished_jobs_measured_against(job.seq))
                if (user.comparison != row.seq) references_.check_unused(job, false);
    jobs_.cancellations.cancel_jobs(
        std::move(jobs),
        [&] {
            row.purge_requested = remove;
            if (remove) core_.store.update_comparison(row);
        },
        remove);
    // What was made for it alone to be measured against is not wanted any more.
    for (const JobProgress& film : before.own_references)
        if (!is_over(film.state) && core_.store.unfinished_jobs_measured_against(film.seq).empty())
            if (auto reference = core_.store.job(film.seq))
                jobs_.cancellations.cancel_jobs(
                    {*std::move(reference)}, [] {}, false);
    const Compared compared = read_comparison(row);
    if (remove) purges_.finish_purge(row);
    attempts_.dispatch();
    lock.unlock();
    return {judge(compared).object, was_over};
}

}  // namespace photond
