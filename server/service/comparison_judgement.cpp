#include "server/service/comparison_judgement.h"

#include <algorithm>
#include <map>
#include <string>
#include <unordered_set>

#include "protocol/message_parts.h"
#include "server/clock_text.h"
#include "server/comparisons/headline.h"
#include "server/comparisons/repeats.h"
#include "server/comparisons/report_text.h"
#include "server/comparisons/verdict.h"
#include "server/left_out_json.h"
#include "server/row_text.h"
#include "server/service/references.h"
#include "server/service/row_films.h"

namespace photond {

using nlohmann::json;

namespace {

/// What the comparison took beside its jobs' clocks: on each device the time from the first start to the last end, less
/// the `seconds` of its jobs (and of the references made for it). So it holds loading, building, saving and measuring,
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

/// ", 0.001, is within 3 times the reference's own, 0.0005" of a figure that is near the reference.
std::string near_reference_text(const FinalError& figure) {
    const MeanError& mean = *figure.mean;
    if (!mean.interval)
        return ", " + short_number(mean.error.mean) + ", is within 3 times the reference's own, " +
               short_number(*figure.reference);
    return ", between " + short_number(mean.interval->least) + " and " + short_number(mean.interval->greatest) +
           " by the references' noise, is not known to a third of itself";
}

/// Whether all finished jobs were measured against two films (statistics of before there were any do not say how);
/// where none is finished, whether all will be.
bool is_measured_by_two(const Compared& compared, const std::vector<json>& statistics) {
    const json::json_pointer form("/reference/form");
    const auto is_known = [](const json& of_job) { return of_job.is_object(); };
    const auto by_two = [&](const json& of_job) {
        return !is_known(of_job) || (of_job.contains(form) && of_job.at(form) == ReferenceSource::kTwoFilms);
    };
    if (std::any_of(statistics.begin(), statistics.end(), is_known))
        return std::all_of(statistics.begin(), statistics.end(), by_two);
    return std::all_of(compared.state.jobs.begin(), compared.state.jobs.end(),
                       [](const JobProgress& job) { return job.reference_jobs.size() == References::kFilms; });
}

json method_of(const JobRow& row) {
    const json request = parsed_or_null(row.request);
    return request.is_object() ? request.value("method", json()) : json();
}

/// What the reference leaves out. Where its job's statistics do not tell, its method does, by the needs of the scene as
/// `statistics` of the jobs measured against it have them.
std::optional<PathsLeftOut> left_out_of_reference(const Compared& compared, const std::vector<json>& statistics) {
    json method = json::parse(compared.row.request).value(json::json_pointer("/reference/method"), json());
    for (const JobRow& reference : compared.references) {
        method = method_of(reference);
        if (const auto known = left_out_of_job(parsed_or_null(reference.statistics), method)) return known;
    }
    for (json of_job : statistics) {
        if (!of_job.is_object()) continue;
        of_job.erase("left_out");  // which is its own
        if (const auto known = left_out_of_job(of_job, method)) return known;
    }
    return std::nullopt;
}

/// "its own noise": of the metrics that were measured, and where that is too near to what it is compared with.
json reference_json(const Judged& judged, const Compared& compared) {
    const json asked = json::parse(compared.row.request).value("reference", json());
    if (asked.is_null()) return nullptr;
    json error = json::object(), warnings = json::array();
    for (const MeasuredJob& job : judged.jobs)
        for (const auto& [metric, noise] : job.reference_error) error[metric] = noise;
    for (const TableRow& table_row : judged.table.rows)
        for (const auto& [metric, figure] : table_row.error)
            if (figure.near_reference)
                warnings.push_back("the " + metric + " of " + row_name(table_row.label, table_row.parameters) +
                                   near_reference_text(figure) + ": take a reference of more passes");
    const bool image = asked.is_string() && asked.get_ref<const std::string&>().starts_with("image:");
    json films;
    for (const JobProgress& film : compared.state.references) films.push_back(job_id(film.seq));
    const std::optional<JobState> reached = compared.state.reference_state();
    return {{"job", films.is_null() ? json() : films.front()},
            {"jobs", films},
            {"form", image                                             ? ReferenceSource::kImage
                     : is_measured_by_two(compared, judged.statistics) ? ReferenceSource::kTwoFilms
                                                                       : ReferenceSource::kFilm},
            {"image", image ? json(asked.get<std::string>().substr(6)) : json()},
            {"state", reached ? json(job_state_name(*reached)) : json()},
            {"error", error.empty() ? json() : error},
            {"left_out", judged.table.reference_left_out ? to_json(*judged.table.reference_left_out) : json()},
            {"warnings", warnings}};
}

/// A job as it was planned and its repeats, in the order they were made.
struct Place {
    std::vector<MeasuredJob> runs;
    std::vector<json> statistics;
};

std::vector<Place> places_of(const Compared& compared) {
    std::vector<Place> places;
    std::map<int64_t, size_t> place_of;  // by the job that was planned
    for (const auto& [planned, row] : compared.jobs) {
        MeasuredJob job;
        job.id = job_id(row.seq);
        job.label = planned.label;
        job.parameters = json::parse(planned.parameters);
        job.seed = planned.seed;
        job.state = job_state_name(row.state);
        job.passes = static_cast<uint64_t>(row.passes_done);
        job.seconds = row.seconds;
        json statistics = parsed_or_null(row.statistics);
        add_measurements(job, parsed_or_null(row.curve), statistics);
        job.left_out = left_out_of_job(statistics, method_of(row));
        const auto [place, is_new] = place_of.emplace(planned.planned(), places.size());
        if (is_new) places.emplace_back();
        places[place->second].runs.push_back(std::move(job));
        places[place->second].statistics.push_back(std::move(statistics));
    }
    return places;
}

json warning_json(const MeasuredJob& job) { return job.loss ? json(job.loss->warning()) : json(); }

/// "photons, seed 2: J5 lost 2.1 s of its processor time (14 %) to others; its repeat J9 counts"; empty where nothing
/// was lost.
std::string place_warning(const Place& place, size_t counts) {
    const MeasuredJob& counting = place.runs[counts];
    const auto disturbed =
        std::find_if(place.runs.begin(), place.runs.end(), [](const MeasuredJob& run) { return run.loss; });
    if (disturbed == place.runs.end()) return "";
    const auto lost = [](const MeasuredJob& run) { return run.id + " lost " + run.loss->what(); };
    const std::string name =
        row_name(counting.label, counting.parameters) + ", seed " + std::to_string(counting.seed) + ": ";
    const MeasuredJob& last = place.runs.back();
    if (!last.is_over()) return name + lost(*disturbed) + "; it is repeated as " + last.id;
    if (!counting.loss) return name + lost(*disturbed) + "; its repeat " + counting.id + " counts";
    if (place.runs.size() == 1) return name + lost(counting) + "; run it again";
    return name + lost(counting) + ", the least of " + std::to_string(place.runs.size()) + " runs; run it again";
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

std::vector<JobState> ComparisonState::places() const {
    std::map<int64_t, JobState> found;  // by the job that was planned
    for (const JobProgress& job : jobs) {
        const auto [place, planned] = found.emplace(job.planned(), job.state);
        if (!planned && is_over(place->second) && (!is_over(job.state) || job.state == JobState::Succeeded))
            place->second = job.state;
    }
    std::vector<JobState> states;
    for (const JobProgress& job : jobs)
        if (!job.repeat_of) states.push_back(found.at(job.seq));
    return states;
}

std::optional<JobState> ComparisonState::reference_state() const {
    for (const JobProgress& film : references)
        if (film.state != JobState::Succeeded) return film.state;
    return references.empty() ? std::nullopt : std::optional(JobState::Succeeded);
}

std::vector<int64_t> references_of(const std::vector<JobProgress>& jobs) {
    std::vector<int64_t> references;
    std::unordered_set<int64_t> known;
    for (const JobProgress& job : jobs)
        for (const int64_t seq : job.reference_jobs)
            if (known.insert(seq).second) references.push_back(seq);
    return references;
}

JobState ComparisonState::state() const {
    const std::vector<JobState> states = places();
    const auto there_is = [&](JobState state) {
        return std::find(states.begin(), states.end(), state) != states.end();
    };
    const auto has_begun = [](const JobProgress& job) { return job.state != JobState::Queued; };
    const bool begun = std::any_of(own_references.begin(), own_references.end(), has_begun) ||
                       std::any_of(jobs.begin(), jobs.end(), has_begun);
    if (std::any_of(states.begin(), states.end(), [](JobState state) { return !is_over(state); }))
        return begun ? JobState::Running : JobState::Queued;
    if (there_is(JobState::Cancelled)) return JobState::Cancelled;
    return there_is(JobState::Failed) ? JobState::Failed : JobState::Succeeded;
}

json comparison_summary(const ComparisonRow& row, const ComparisonState& known) {
    const JobState state = known.state();
    const std::vector<JobProgress>& jobs = known.jobs;
    std::vector<JobProgress> all = jobs;
    all.insert(all.end(), known.own_references.begin(), known.own_references.end());
    double progress = 0;
    json counts = json::object();
    for (const std::string_view name : kJobStates) counts[std::string(name)] = 0;
    const std::vector<JobState> places = known.places();
    for (const JobState place : places) counts[std::string(job_state_name(place))].get_ref<int64_t&>() += 1;
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
            {"repeats", jobs.size() - places.size()},
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
    json &jobs = object["jobs"] = json::array(), &warnings = object["warnings"] = json::array();
    for (const Place& place : places_of(compared)) {
        const size_t counts = run_that_counts(place.runs);
        const MeasuredJob& job = place.runs[counts];
        json runs = json::array();
        for (const MeasuredJob& run : place.runs)
            runs.push_back({{"id", run.id}, {"state", run.state}, {"warning", warning_json(run)}});
        jobs.push_back({{"id", job.id},
                        {"label", job.label},
                        {"parameters", job.parameters},
                        {"seed", job.seed},
                        {"state", job.state},
                        {"passes_done", job.passes},
                        {"seconds", job.seconds},
                        {"warning", warning_json(job)},
                        {"runs", std::move(runs)}});
        if (const std::string text = place_warning(place, counts); !text.empty()) warnings.push_back(text);
        judged.statistics.push_back(place.statistics[counts]);
        judged.jobs.push_back(job);
    }
    const json& request = object["request"];
    judged.table = make_table(judged.jobs, request.at("metrics").get<std::vector<std::string>>(), wishes_of(request));
    judged.table.reference_left_out = left_out_of_reference(compared, judged.statistics);
    add_biases(judged.table, compared);
    object["table"] = to_json(judged.table);
    const std::vector<Verdict> found = verdicts(judged.table);
    object["verdicts"] = verdicts_json(judged.table, found);
    object["headlines"] = headlines_json(judged.table, found);
    object["reference"] = reference_json(judged, compared);
    return judged;
}

}  // namespace photond
