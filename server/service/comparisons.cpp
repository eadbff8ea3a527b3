#include "server/service/comparisons.h"

#include <spdlog/spdlog.h>

#include <mutex>

#include "protocol/comparison_remarks.h"
#include "server/clock_text.h"

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

Compared Comparisons::read_comparison(const ComparisonRow& row) {
    Compared compared{row, groups_.state_of(row), {}, {}, core_.store.row_biases(row.seq)};
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
    return read_comparison(groups_.require(id));
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
    ComparisonRow row;
    row.request = request.echo.dump();
    const std::optional<JobGroups::Key> asked = JobGroups::key_of(key, request.echo);
    scenes_.know_scene(request.jobs.front().request.scene);
    std::unique_lock lock(core_.mutex);
    if (const auto known = groups_.of_key(asked)) {
        const Compared compared = read_comparison(*known);
        lock.unlock();
        return judge(compared).object;
    }
    if (core_.stopping) throw Error(ErrorCode::Unavailable, "the daemon is stopping and takes no new jobs");
    row.created_ms = now_ms();
    std::vector<PreparedJob> jobs = prepare_jobs(request);
    row.scene = jobs.front().row.scene;
    jobs_.intake.check_room(jobs);
    std::vector<JobGroups::Member> members;
    for (size_t i = 0; i < jobs.size(); ++i) {
        const PlannedJob& planned = request.jobs[i];
        members.push_back({std::move(jobs[i]),
                           {.label = planned.label, .parameters = planned.parameters.dump(), .seed = planned.seed}});
    }
    std::function<void()> queue;
    row = groups_.insert(std::move(row), members, asked, queue);
    const Compared compared = read_comparison(row);  // as accepted, whatever happens next
    queue();
    lock.unlock();
    spdlog::info("comparison {}: {} jobs", comparison_id(row.seq), members.size());
    return judge(compared).object;
}

void Comparisons::change_comparison(const std::string& id, const json& body) {
    BodyFaults faults;
    ObjectReader reader(body, "", faults);
    const json remarks = read_remarks(body, reader, faults);
    reader.finish();
    faults.throw_if_any();
    const std::lock_guard lock(core_.mutex);
    ComparisonRow row = groups_.require(id);
    json request = json::parse(row.request);
    request.update(remarks);
    row.request = request.dump();
    auto transaction = core_.store.transaction();
    core_.store.update_comparison(row);
    transaction.commit();
}

Page Comparisons::list_comparisons(uint32_t limit, const std::string& cursor) {
    JobGroups::RowPage page;
    std::vector<ComparisonState> states;
    {
        const std::lock_guard lock(core_.mutex);
        page = groups_.read_page(limit, cursor);
        for (const ComparisonRow& row : page.rows) states.push_back(groups_.state_of(row));
    }
    json items = json::array();
    for (size_t i = 0; i < states.size(); ++i) items.push_back(comparison_summary(page.rows[i], states[i]));
    return {{"items", std::move(items)}, {"next_cursor", std::move(page.next_cursor)}};
}

Cancelled Comparisons::cancel_comparison(const std::string& id, bool remove) {
    std::unique_lock lock(core_.mutex);
    const ComparisonRow row = groups_.require(id);
    const bool was_over = is_over(groups_.state_of(row).state());
    std::optional<Compared> compared;
    groups_.cancel(row, remove, [&](const ComparisonRow& now) { compared = read_comparison(now); });
    lock.unlock();
    return {judge(*compared).object, was_over};
}

}  // namespace photond
