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

JobGroups::RowPage JobGroups::read_page(uint32_t limit, const std::string& cursor) {
    check_limit(limit);
    RowPage page{core_.store.comparisons(read_cursor(cursor, INT64_MAX), limit, kind_), {}};
    if (page.rows.size() == limit) page.next_cursor = std::to_string(page.rows.back().seq);
    std::erase_if(page.rows, [](const ComparisonRow& row) { return row.purge_requested; });
    return page;
}

void JobGroups::cancel(ComparisonRow row, bool remove, const std::function<void(const ComparisonRow&)>& look) {
    const std::vector<ReferenceProgress> references = core_.store.comparison_references(row.seq);
    if (remove)
        for (const RemovableJob& job : core_.store.removable_jobs(row.seq))
            references_.check_unused_beside(job.seq, row.seq);
    jobs_.cancellations.cancel_jobs(
        core_.store.unfinished_jobs_of(row.seq),
        [&] {
            row.purge_requested = remove;
            if (remove) core_.store.update_comparison(row);
        },
        remove);
    // What was made for it alone to be measured against is not wanted any more.
    std::vector<JobRow> unwanted;
    for (const ReferenceProgress& reference : references)
        if (reference.is_own(row) && !is_over(reference.job.state) &&
            core_.store.unfinished_jobs_measured_against(reference.job.seq).empty())
            if (auto film = core_.store.job(reference.job.seq)) unwanted.push_back(*std::move(film));
    if (!unwanted.empty())
        jobs_.cancellations.cancel_jobs(
            std::move(unwanted), [] {}, false);
    look(row);
    if (remove) purges_.finish_purge(row);
    attempts_.dispatch();
}

}  // namespace photond
