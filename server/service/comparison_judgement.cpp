#include "server/service/comparison_judgement.h"

#include <algorithm>
#include <map>
#include <string>

#include "server/clock_text.h"
#include "server/comparisons/headline.h"
#include "server/comparisons/report_text.h"
#include "server/comparisons/verdict.h"
#include "server/row_text.h"

namespace photond {

using nlohmann::json;

namespace {

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

JobState ComparisonState::state() const {
    const auto own = own_reference();
    size_t over = 0, failed = 0, cancelled = 0;
    bool begun = own && own->state != JobState::Queued;
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

json comparison_summary(const ComparisonRow& row, const ComparisonState& known) {
    const JobState state = known.state();
    const std::vector<JobProgress>& jobs = known.jobs;
    std::vector<JobProgress> all = jobs;
    if (const auto own = known.own_reference()) all.push_back(*own);
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

Judged judge(const Compared& compared) {
    Judged judged;
    json& object = judged.object;
    const ComparisonState& state = compared.state;
    object = comparison_summary(compared.row, state);
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
    const std::vector<Verdict> found = verdicts(judged.table);
    object["verdicts"] = verdicts_json(judged.table, found);
    object["headlines"] = headlines_json(judged.table, found);
    object["reference"] = reference_json(compared.row, state.reference, judged.jobs, judged.table);
    return judged;
}

}  // namespace photond
