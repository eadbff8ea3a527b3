#include "server/service/job_groups.h"

#include <memory>
#include <unordered_map>

#include "renderer/core/sha256.h"
#include "server/service/idempotency_key.h"
#include "server/service/page_cursor.h"

namespace photond {

using nlohmann::json;

std::optional<JobGroups::Key> JobGroups::key_of(const std::optional<std::string>& key, const json& echo) {
    if (!key) return std::nullopt;
    check_idempotency_key(*key);
    const std::string body = naming_json(echo).dump();
    return Key{*key, sha256_hex(body.data(), body.size())};
}

ComparisonRow JobGroups::require(const std::string& id) {
    if (const int64_t seq = group_seq(kind_, id); seq != 0)
        if (auto row = core_.store.comparison(seq); row && row->kind == kind_ && !row->purge_requested)
            return *std::move(row);
    throw Error(ErrorCode::NotFound, std::string("there is no ") +
                                         (kind_ == GroupKind::Sequence ? "sequence" : "comparison") + " '" + id + "'");
}

JobProgress JobGroups::progress_now(JobProgress job) const {
    if (job.state != JobState::Running) return job;
    if (const RunningAttempt* attempt = attempts_.running_attempt(job.seq)) {
        job.progress = attempt->progress;
        job.seconds = attempt->seconds;
    }
    return job;
}

ComparisonState JobGroups::state_of(const ComparisonRow& row) {
    ComparisonState state;
    for (const JobProgress& job : core_.store.comparison_progress(row.seq)) state.jobs.push_back(progress_now(job));
    std::unordered_map<int64_t, ReferenceProgress> known;
    for (ReferenceProgress& reference : core_.store.comparison_references(row.seq))
        known.emplace(reference.job.seq, std::move(reference));
    for (const int64_t seq : references_of(state.jobs)) {
        const auto found = known.find(seq);
        if (found == known.end()) continue;
        state.references.push_back(progress_now(found->second.job));
        if (found->second.is_own(row)) state.own_references.push_back(state.references.back());
    }
    return state;
}

std::optional<ComparisonRow> JobGroups::of_key(const std::optional<Key>& key) {
    if (!key) return std::nullopt;
    const auto known = core_.store.comparison_key(key->text);
    if (!known) return std::nullopt;
    const auto row = core_.store.comparison(known->comparison);
    if (known->body_sha256 != key->body_sha256 || !row || row->kind != kind_)
        throw Error(ErrorCode::IdempotencyMismatch, "the Idempotency-Key was used with another body, for " +
                                                        group_id(row ? row->kind : kind_, known->comparison));
    return require(group_id(kind_, known->comparison));
}

ComparisonRow JobGroups::insert(ComparisonRow row, std::vector<Member>& members, const std::optional<Key>& key,
                                std::function<void()>& queue) {
    row.kind = kind_;
    const auto inserted = std::make_shared<Insertion>();
    {
        auto transaction = core_.store.transaction();
        core_.store.insert_comparison(row);
        for (size_t i = 0; i < members.size(); ++i) {
            JobRow& job = members[i].job.row;
            job.comparison = row.seq;
            if (kind_ == GroupKind::Sequence) job.role = JobRole::Frame;
            jobs_.intake.insert_job(members[i].job, *inserted);
            ComparisonJob note = members[i].note;
            note.job = job.seq;
            core_.store.insert_comparison_job(row.seq, static_cast<int64_t>(i), note);
        }
        if (key) core_.store.insert_comparison_key(key->text, key->body_sha256, row.seq, row.created_ms);
        transaction.commit();
    }
    queue = [this, inserted] { jobs_.intake.accept(std::move(*inserted)); };
    return row;
}

Page JobGroups::list(uint32_t limit, const std::string& cursor,
                     const std::function<json(const ComparisonRow&, const ComparisonState&)>& summary) {
    check_limit(limit);
    const int64_t before = read_cursor(cursor, INT64_MAX);
    json items = json::array(), next;
    const std::lock_guard lock(core_.mutex);
    const std::vector<ComparisonRow> rows = core_.store.comparisons(before, limit, kind_);
    for (const ComparisonRow& row : rows)
        if (!row.purge_requested) items.push_back(summary(row, state_of(row)));
    if (rows.size() == limit) next = std::to_string(rows.back().seq);
    return {{"items", std::move(items)}, {"next_cursor", std::move(next)}};
}

void JobGroups::cancel(ComparisonRow row, bool remove, const std::function<void(const ComparisonRow&)>& look) {
    const ComparisonState before = state_of(row);
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
    look(row);
    if (remove) purges_.finish_purge(row);
    attempts_.dispatch();
}

}  // namespace photond
