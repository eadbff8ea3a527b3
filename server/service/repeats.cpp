#include "server/service/repeats.h"

#include <algorithm>

#include "server/clock_text.h"
#include "server/comparisons/repeats.h"
#include "server/row_text.h"

namespace photond {

std::vector<ComparisonJob> Repeats::runs_in_place_of(const JobRow& row) {
    if (!row.comparison || row.role == JobRole::Frame) return {};  // nobody compares the clocks of frames
    std::vector<ComparisonJob> jobs = core_.store.comparison_jobs(*row.comparison);
    const auto own = std::find_if(jobs.begin(), jobs.end(), [&](const auto& job) { return job.job == row.seq; });
    if (own == jobs.end()) return {};
    const int64_t planned = own->planned();
    std::erase_if(jobs, [&](const ComparisonJob& job) { return job.planned() != planned; });
    return jobs;
}

void Repeats::put_in_place(const JobRow& repeat, const std::vector<ComparisonJob>& runs) {
    ComparisonJob job = runs.front();
    job.repeat_of = job.job;
    job.job = repeat.seq;
    const size_t places = core_.store.comparison_jobs(*repeat.comparison).size();
    core_.store.insert_comparison_job(*repeat.comparison, static_cast<int64_t>(places), job);
}

std::optional<JobRow> Repeats::repeat_if_disturbed(const JobRow& ended, Outbox& outbox) {
    if (!CoreLoss::of_statistics(parsed_or_null(ended.statistics)) || ended.purge_requested) return std::nullopt;
    const std::vector<ComparisonJob> runs = runs_in_place_of(ended);
    if (runs.empty()) return std::nullopt;
    std::vector<MeasuredJob> measured;
    for (const ComparisonJob& run : runs) {
        const auto row = run.job == ended.seq ? std::optional(ended) : core_.store.job(run.job);
        if (!row) continue;
        MeasuredJob& job = measured.emplace_back();
        job.state = job_state_name(row->state);
        job.loss = CoreLoss::of_statistics(parsed_or_null(row->statistics));
    }
    if (!is_to_be_repeated(measured, core_.options.repeats)) return std::nullopt;
    JobRow repeat;
    repeat.priority = ended.priority;
    repeat.device = ended.device;
    repeat.method = ended.method;
    repeat.scene = ended.scene;
    repeat.request = ended.request;
    repeat.reference_jobs = ended.reference_jobs;
    repeat.comparison = ended.comparison;
    repeat.created_ms = now_ms();
    core_.store.insert_job(repeat);
    put_in_place(repeat, runs);
    core_.store.append_log(ended.seq, repeat.created_ms, "disturbed: repeated as " + job_id(repeat.seq));
    core_.store.append_log(repeat.seq, repeat.created_ms,
                           "queued for " + repeat.device + ": repeats " + job_id(ended.seq) + ", which was disturbed");
    core_.put_event(outbox, "state", repeat.seq, ServiceCore::state_data(repeat));
    return repeat;
}

}  // namespace photond
