// Comparisons and sequences in the store, and what is asked of all their jobs at once.

#include "server/store/store.h"

namespace photond {

namespace {

constexpr const char* kSelectComparisons =
    "SELECT seq, scene, request, created_ms, purge_requested, kind FROM comparisons";

std::vector<ComparisonRow> read_comparisons(Statement& read) {
    std::vector<ComparisonRow> rows;
    while (read.step())
        rows.push_back({read.integer(0), read.text(1), read.text(2), read.integer(3), read.integer(4) != 0,
                        static_cast<GroupKind>(read.integer(5))});
    return rows;
}

/// Of the columns seq, state, device, progress, seconds, started_ms and finished_ms.
JobProgress read_progress(const Statement& read) {
    return {read.integer(0),
            static_cast<JobState>(read.integer(1)),
            read.text(2),
            read.real(3),
            read.real(4),
            read.optional_integer(5),
            read.optional_integer(6)};
}

}  // namespace

void Store::insert_comparison(ComparisonRow& comparison) {
    database_
        .prepare(
            "INSERT INTO comparisons (scene, request, created_ms, purge_requested, kind) VALUES (?1, ?2, ?3, ?4, ?5)")
        .bind(1, comparison.scene)
        .bind(2, comparison.request)
        .bind(3, comparison.created_ms)
        .bind(4, static_cast<int64_t>(comparison.purge_requested))
        .bind(5, static_cast<int64_t>(comparison.kind))
        .run();
    comparison.seq = database_.last_insert_id();
}

void Store::insert_comparison_job(int64_t comparison, int64_t place, const ComparisonJob& job) {
    database_
        .prepare(
            "INSERT INTO comparison_jobs (comparison, place, job, label, parameters, seed, repeat_of) VALUES (?1, ?2, "
            "?3, ?4, ?5, ?6, ?7)")
        .bind(1, comparison)
        .bind(2, place)
        .bind(3, job.job)
        .bind(4, job.label)
        .bind(5, job.parameters)
        .bind(6, static_cast<int64_t>(job.seed))
        .bind(7, job.repeat_of)
        .run();
}

void Store::update_comparison(const ComparisonRow& comparison) {
    database_.prepare("UPDATE comparisons SET purge_requested = ?1, request = ?2 WHERE seq = ?3")
        .bind(1, static_cast<int64_t>(comparison.purge_requested))
        .bind(2, comparison.request)
        .bind(3, comparison.seq)
        .run();
}

void Store::delete_comparison(int64_t seq) {
    database_.prepare("DELETE FROM comparisons WHERE seq = ?1").bind(1, seq).run();
}

std::optional<ComparisonRow> Store::comparison(int64_t seq) {
    Statement read = database_.prepare(std::string(kSelectComparisons) + " WHERE seq = ?1");
    read.bind(1, seq);
    std::vector<ComparisonRow> rows = read_comparisons(read);
    if (rows.empty()) return std::nullopt;
    return std::move(rows.front());
}

std::vector<ComparisonRow> Store::comparisons(int64_t before, uint32_t limit, GroupKind kind) {
    Statement read =
        database_.prepare(std::string(kSelectComparisons) + " WHERE seq < ?1 AND kind = ?3 ORDER BY seq DESC LIMIT ?2");
    read.bind(1, before).bind(2, static_cast<int64_t>(limit)).bind(3, static_cast<int64_t>(kind));
    return read_comparisons(read);
}

std::vector<ComparisonRow> Store::comparisons_to_purge() {
    Statement read = database_.prepare(std::string(kSelectComparisons) + " WHERE purge_requested = 1");
    return read_comparisons(read);
}

std::vector<ComparisonJob> Store::comparison_jobs(int64_t seq) {
    Statement read = database_.prepare(
        "SELECT job, label, parameters, seed, repeat_of FROM comparison_jobs WHERE comparison = ?1 ORDER BY place");
    read.bind(1, seq);
    std::vector<ComparisonJob> jobs;
    while (read.step())
        jobs.push_back({read.integer(0), read.text(1), read.text(2), static_cast<uint64_t>(read.integer(3)),
                        read.optional_integer(4)});
    return jobs;
}

std::vector<JobProgress> Store::comparison_progress(int64_t seq) {
    Statement read = database_.prepare(
        "SELECT jobs.seq, state, device, progress, seconds, started_ms, finished_ms, reference_job, "
        "second_reference_job, repeat_of FROM comparison_jobs "
        "JOIN jobs ON jobs.seq = comparison_jobs.job WHERE comparison_jobs.comparison = ?1 ORDER BY place");
    read.bind(1, seq);
    std::vector<JobProgress> jobs;
    while (read.step()) {
        JobProgress& job = jobs.emplace_back(read_progress(read));
        for (const int reference : {7, 8})
            if (const auto referred = read.optional_integer(reference)) job.reference_jobs.push_back(*referred);
        job.repeat_of = read.optional_integer(9);
    }
    return jobs;
}

std::vector<StateCount> Store::count_states(int64_t comparison) {
    Statement read = database_.prepare(
        "SELECT state, count(*), sum(progress), min(started_ms), max(finished_ms) FROM job_summaries "
        "WHERE comparison = ?1 GROUP BY state");
    read.bind(1, comparison);
    std::vector<StateCount> counts;
    while (read.step())
        counts.push_back({static_cast<JobState>(read.integer(0)), read.integer(1), read.real(2),
                          read.optional_integer(3), read.optional_integer(4)});
    return counts;
}

std::vector<JobProgress> Store::running_jobs_of(int64_t comparison) {
    Statement read = database_.prepare(
        "SELECT seq, state, device, progress, seconds, started_ms, finished_ms FROM job_summaries "
        "WHERE comparison = ?1 AND state = 1");
    read.bind(1, comparison);
    std::vector<JobProgress> jobs;
    while (read.step()) jobs.push_back(read_progress(read));
    return jobs;
}

std::optional<int64_t> Store::frame_before(int64_t sequence, int64_t job) {
    Statement read = database_.prepare(
        "SELECT job FROM comparison_jobs WHERE comparison = ?1 AND place < (SELECT place FROM comparison_jobs WHERE "
        "job = ?2 AND comparison = ?1) ORDER BY place DESC LIMIT 1");
    read.bind(1, sequence).bind(2, job);
    return read.step() ? std::optional(read.integer(0)) : std::nullopt;
}

std::vector<FrameRow> Store::frames(int64_t sequence) {
    Statement read = database_.prepare(
        "SELECT job, parameters, seed, state, progress, seconds FROM comparison_jobs "
        "JOIN job_summaries ON job_summaries.seq = job WHERE comparison_jobs.comparison = ?1 ORDER BY place");
    read.bind(1, sequence);
    std::vector<FrameRow> frames;
    while (read.step())
        frames.push_back({read.integer(0), read.text(1), static_cast<uint64_t>(read.integer(2)),
                          static_cast<JobState>(read.integer(3)), read.real(4), read.real(5)});
    return frames;
}

std::vector<JobRow> Store::unfinished_jobs_of(int64_t comparison) {
    std::vector<int64_t> seqs;
    {
        Statement read =
            database_.prepare("SELECT seq FROM job_summaries WHERE comparison = ?1 AND state < 2 ORDER BY seq");
        read.bind(1, comparison);
        while (read.step()) seqs.push_back(read.integer(0));
    }
    std::vector<JobRow> jobs;
    jobs.reserve(seqs.size());
    for (const int64_t seq : seqs)
        if (auto found = job(seq)) jobs.push_back(*std::move(found));
    return jobs;
}

std::vector<RemovableJob> Store::removable_jobs(int64_t comparison) {
    Statement read = database_.prepare(
        "SELECT seq, state, film FROM comparison_jobs JOIN jobs ON seq = job WHERE comparison_jobs.comparison = ?1 "
        "ORDER BY place");
    read.bind(1, comparison);
    std::vector<RemovableJob> jobs;
    while (read.step()) jobs.push_back({read.integer(0), static_cast<JobState>(read.integer(1)), read.text(2)});
    return jobs;
}

bool Store::has_begun_reference(const ComparisonRow& comparison) {
    Statement read = database_.prepare(
        // All of its jobs have references, or none has: of many the first one tells it.
        "SELECT 1 FROM comparison_jobs JOIN jobs ON jobs.seq = job JOIN job_summaries AS reference "
        "ON reference.seq IN (reference_job, second_reference_job) "
        "WHERE (SELECT reference_job FROM jobs WHERE seq = (SELECT min(job) FROM comparison_jobs WHERE comparison = "
        "?1)) "
        "IS NOT NULL AND comparison_jobs.comparison = ?1 AND reference.role = 1 AND reference.created_ms >= ?2 "
        "AND reference.state <> 0 LIMIT 1");
    read.bind(1, comparison.seq).bind(2, comparison.created_ms);
    return read.step();
}

std::vector<ReferenceProgress> Store::comparison_references(int64_t seq) {
    Statement read = database_.prepare(
        "WITH members AS (SELECT reference_job, second_reference_job FROM comparison_jobs "
        "JOIN jobs ON jobs.seq = comparison_jobs.job WHERE comparison_jobs.comparison = ?1) "
        "SELECT seq, state, device, progress, seconds, started_ms, finished_ms, role, created_ms FROM job_summaries "
        "WHERE seq IN (SELECT reference_job FROM members UNION SELECT second_reference_job FROM members)");
    read.bind(1, seq);
    std::vector<ReferenceProgress> references;
    while (read.step())
        references.push_back({read_progress(read), static_cast<JobRole>(read.integer(7)), read.integer(8)});
    return references;
}

void Store::put_row_bias(int64_t comparison, const RowBias& bias, const std::string& map) {
    database_
        .prepare(
            "INSERT OR REPLACE INTO row_biases (comparison, films, layer, errors, map) VALUES (?1, ?2, ?3, ?4, ?5)")
        .bind(1, comparison)
        .bind(2, bias.films)
        .bind(3, bias.layer)
        .bind(4, bias.errors)
        .bind(5, map)
        .run();
}

std::vector<RowBias> Store::row_biases(int64_t comparison) {
    Statement read = database_.prepare("SELECT films, layer, errors FROM row_biases WHERE comparison = ?1");
    read.bind(1, comparison);
    std::vector<RowBias> biases;
    while (read.step()) biases.push_back({read.text(0), read.text(1), read.text(2)});
    return biases;
}

std::optional<std::string> Store::row_bias_map(int64_t comparison, const std::string& films, const std::string& layer) {
    Statement read =
        database_.prepare("SELECT map FROM row_biases WHERE comparison = ?1 AND films = ?2 AND layer = ?3");
    read.bind(1, comparison).bind(2, films).bind(3, layer);
    if (!read.step()) return std::nullopt;
    return read.text(0);
}

std::optional<Store::ComparisonKeyRow> Store::comparison_key(const std::string& key) {
    Statement read = database_.prepare("SELECT body_sha256, comparison FROM comparison_keys WHERE key = ?1");
    read.bind(1, key);
    if (!read.step()) return std::nullopt;
    return ComparisonKeyRow{read.text(0), read.integer(1)};
}

void Store::insert_comparison_key(const std::string& key, const std::string& body_sha256, int64_t comparison,
                                  int64_t at_ms) {
    database_.prepare("INSERT INTO comparison_keys (key, body_sha256, at_ms, comparison) VALUES (?1, ?2, ?3, ?4)")
        .bind(1, key)
        .bind(2, body_sha256)
        .bind(3, at_ms)
        .bind(4, comparison)
        .run();
}

}  // namespace photond
