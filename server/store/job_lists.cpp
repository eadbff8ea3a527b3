// Lists of jobs. However long jobs' rows are, a list looks for its jobs in one narrow index that holds every filter,
// and shows what is beside it (schema.h, step 5). What it found it keeps while no job changes, so that whoever leafs or
// jumps through a long list has its pages and its total at once.

#include <algorithm>
#include <nlohmann/json.hpp>

#include "server/store/store.h"

namespace photond {

namespace {

using nlohmann::json;

constexpr size_t kListsKept = 8;  // of different filters; a number for each job of each

std::string quoted(const std::string& text) { return json(text).dump(-1, ' ', false, json::error_handler_t::replace); }

/// What the labels' text holds where there is such a label, and nowhere else. They are JSON whose opening brace is a
/// comma, so that every key follows `,"`; within a string that cannot stand, for there a quotation mark has a backslash
/// before it, unless the string ends with that comma: only a key that is nothing but a comma can be seen where it is
/// not. Nor can a longer value be taken for this one, which ends with its own.
std::string label_text(const JobQuery& query) {
    std::string text = "," + quoted(query.label_key) + ":";
    if (query.label_value) text += quoted(*query.label_value);
    return text;
}

int64_t states_mask(const JobQuery& query) {
    int64_t mask = 0;
    for (const JobState state : query.states) mask |= int64_t{1} << static_cast<int>(state);
    return mask;
}

/// One text for each set of filters in use; what costs least to judge comes first.
std::string filter_sql(const JobQuery& query) {
    // Each order has an index that gives it; those of the later two hold no other job (schema.h, step 6).
    const auto [from, order] = [&]() -> std::pair<const char*, const char*> {
        switch (query.order) {
            case JobOrder::Newest: break;
            case JobOrder::Queue: return {"job_summaries_waiting WHERE state = 0", "priority DESC, seq"};
            case JobOrder::Ended:
                return {"job_summaries_ended WHERE finished_ms IS NOT NULL", "finished_ms DESC, seq DESC"};
        }
        return {"job_summaries_filters WHERE 1", "seq DESC"};
    }();
    std::string sql = std::string("SELECT seq FROM job_summaries INDEXED BY ") + from;
    if (!query.states.empty()) sql += " AND (?1 >> state) & 1";
    if (query.role) sql += " AND role = ?2";
    if (!query.device.empty()) sql += " AND device = ?3";
    if (!query.method.empty()) sql += " AND method = ?4";
    if (!query.scene.empty()) sql += " AND scene = ?5";
    if (!query.label_key.empty()) sql += " AND instr(labels, ?6)";
    return sql + " ORDER BY " + order;
}

bool is_unfiltered(const JobQuery& query) {
    return query.order == JobOrder::Newest && query.states.empty() && !query.role && query.device.empty() &&
           query.method.empty() && query.scene.empty() && query.label_key.empty();
}

/// The same for queries that the same jobs pass in the same order, on whatever page.
std::string filter_key(const JobQuery& query) {
    const json key{static_cast<int>(query.order),
                   states_mask(query),
                   query.role ? static_cast<int>(*query.role) : -1,
                   query.device,
                   query.method,
                   query.scene,
                   query.label_key.empty() ? "" : label_text(query)};
    return key.dump(-1, ' ', false, json::error_handler_t::replace);
}

JobSummary read_summary(const Statement& row) {
    JobSummary job;
    job.seq = row.integer(0);
    job.state = static_cast<JobState>(row.integer(1));
    job.role = static_cast<JobRole>(row.integer(2));
    job.device = row.text(3);
    job.method = row.text(4);
    job.labels = row.text(5);
    if (job.labels.empty())
        job.labels = "{}";
    else
        job.labels.front() = '{';
    job.priority = static_cast<int>(row.integer(6));
    job.comparison = row.optional_integer(7);
    job.created_ms = row.integer(8);
    job.started_ms = row.optional_integer(9);
    job.finished_ms = row.optional_integer(10);
    job.progress = row.real(11);
    job.passes_done = row.integer(12);
    job.seconds = row.real(13);
    job.error_now = row.text(14);
    job.scene = row.text(15);
    job.width = row.integer(16);
    job.height = row.integer(17);
    job.failure = row.text(18);
    return job;
}

}  // namespace

bool Store::has_list(const std::string& filter) {
    std::erase_if(job_lists_, [this](const JobList& list) { return list.version != jobs_version_; });
    const auto known =
        std::find_if(job_lists_.begin(), job_lists_.end(), [&](const JobList& list) { return list.filter == filter; });
    if (known == job_lists_.end()) return false;
    std::rotate(job_lists_.begin(), known, known + 1);
    return true;
}

const std::vector<int64_t>& Store::filtered_jobs(const JobQuery& query) {
    const std::string key = filter_key(query);
    if (has_list(key)) return job_lists_.front().seqs;
    Statement read = database_.prepare(filter_sql(query));
    if (!query.states.empty()) read.bind(1, states_mask(query));
    if (query.role) read.bind(2, static_cast<int64_t>(*query.role));
    if (!query.device.empty()) read.bind(3, query.device);
    if (!query.method.empty()) read.bind(4, query.method);
    if (!query.scene.empty()) read.bind(5, query.scene);
    if (!query.label_key.empty()) read.bind(6, label_text(query));
    JobList list{key, jobs_version_, {}};
    while (read.step()) list.seqs.push_back(read.integer(0));
    if (job_lists_.size() == kListsKept) job_lists_.pop_back();
    job_lists_.insert(job_lists_.begin(), std::move(list));
    return job_lists_.front().seqs;
}

std::vector<int64_t> Store::job_page(const JobQuery& query) {
    std::vector<int64_t> page;
    page.reserve(query.limit);
    // The newest of all jobs lie together: they are not worth a list of all, which the next change would make untrue.
    if (is_unfiltered(query) && query.offset == 0 && !has_list(filter_key(query))) {
        Statement read = database_.prepare("SELECT seq FROM jobs WHERE seq < ?1 ORDER BY seq DESC LIMIT ?2");
        read.bind(1, query.before).bind(2, int64_t{query.limit});
        while (read.step()) page.push_back(read.integer(0));
        return page;
    }
    const std::vector<int64_t>& all = filtered_jobs(query);
    const auto from = query.order == JobOrder::Newest
                          ? std::upper_bound(all.begin(), all.end(), query.before, std::greater<>())
                          : all.begin();
    const auto left = static_cast<uint64_t>(all.end() - from);
    const auto skipped = std::min<uint64_t>(query.offset, left);
    const auto begin = from + static_cast<std::ptrdiff_t>(skipped);
    page.assign(begin, begin + static_cast<std::ptrdiff_t>(std::min<uint64_t>(query.limit, left - skipped)));
    return page;
}

std::optional<JobSummary> Store::job_summary(int64_t seq) {
    Statement read = database_.prepare(
        "SELECT seq, state, role, device, method, labels, priority, comparison, created_ms, started_ms, "
        "finished_ms, progress, passes_done, seconds, error_now, scene_name, width, height, failure "
        "FROM job_summaries WHERE seq = ?1");
    read.bind(1, seq);
    return read.step() ? std::optional(read_summary(read)) : std::nullopt;
}

int64_t Store::count_jobs(const JobQuery& query) { return static_cast<int64_t>(filtered_jobs(query).size()); }

}  // namespace photond
