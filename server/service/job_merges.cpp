#include "server/service/job_merges.h"

#include <algorithm>
#include <utility>

#include "protocol/helper_messages.h"
#include "protocol/object_reader.h"
#include "renderer/core/sha256.h"
#include "renderer/methods/registry.h"
#include "server/clock_text.h"
#include "server/method_params.h"
#include "server/row_text.h"
#include "server/service/idempotency_key.h"
#include "server/service/saved_film.h"

namespace photond {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr size_t kMaxMergedJobs = 1000;
/// What of a request does not decide a pass's pixels: parts of one image may differ in it.
constexpr const char* kFreeMembers[] = {"stop",          "first_pass", "priority", "labels",
                                        "quiet_machine", "reference",  "metrics"};

std::string at(size_t index) { return "/jobs/" + std::to_string(index); }

std::vector<std::string> read_ids(const json& body) {
    BodyFaults faults;
    ObjectReader reader(body, "", faults);
    const json* source = reader.member("jobs", true);
    reader.finish();
    std::vector<std::string> ids;
    if (source && (!source->is_array() || source->empty() || source->size() > kMaxMergedJobs)) {
        faults.add(source->is_array() ? ErrorCode::OutOfRange : ErrorCode::WrongType, "/jobs",
                   "must be an array of 1 to " + std::to_string(kMaxMergedJobs) + " ids of jobs");
    } else if (source) {
        for (size_t i = 0; i < source->size(); ++i) {
            const json& id = (*source)[i];
            if (!id.is_string())
                faults.add(ErrorCode::WrongType, at(i), "must be the id of a job");
            else if (std::find(ids.begin(), ids.end(), id) != ids.end())
                faults.add(ErrorCode::Conflict, at(i), id.get<std::string>() + " is named twice");
            ids.push_back(id.is_string() ? id.get<std::string>() : "");
        }
    }
    faults.throw_if_any();
    return ids;
}

/// What decides the pixels of a job's passes.
json likeness(const JobRow& row) {
    json request = json::parse(row.request);
    for (const char* member : kFreeMembers) request.erase(member);
    request["scene"] = row.scene;
    return request;
}

void check_alike(const json& first, const json& other, const std::string& first_id, size_t index) {
    for (const auto& [member, value] : first.items())
        if (const json theirs = other.value(member, json()); theirs != value)
            throw Error(ErrorCode::Conflict, at(index),
                        std::string("differs from job ")
                            .append(first_id)
                            .append(" in ")
                            .append(member)
                            .append(": ")
                            .append(theirs.dump())
                            .append(" is not ")
                            .append(value.dump()));
}

JobRow merged_row(const std::vector<JobRow>& parts, const MergeFilmsReply& merged) {
    json request = json::parse(parts.front().request);
    uint64_t first_pass = UINT64_MAX;
    for (const JobRow& part : parts)
        first_pass = std::min(first_pass, json::parse(part.request).value("first_pass", uint64_t{0}));
    JobRow row = parts.front();
    row.seq = 0;
    row.role = JobRole::Merged;
    row.state = JobState::Succeeded;
    row.content.clear();
    row.comparison.reset();
    row.created_ms = now_ms();
    row.started_ms.reset();
    row.finished_ms = row.created_ms;
    row.attempt = row.crashes = row.losses = 0;
    row.cancel_requested = row.purge_requested = false;
    row.passes_done = merged.passes_done;
    row.seconds = merged.seconds;
    row.progress = 1;
    request["first_pass"] = first_pass;
    request["stop"] = {{"seconds", nullptr}, {"passes", row.passes_done}, {"target", nullptr}};
    row.request = request.dump();
    json statistics = merged.statistics;
    if (const json of_part = parsed_or_null(parts.front().statistics); of_part.is_object())
        statistics["left_out"] = of_part.value("left_out", json());  // alike in all: scene and settings are
    row.statistics = statistics.dump(-1, ' ', false, json::error_handler_t::replace);
    row.pixel_hash = merged.pixel_hash;
    row.failure.clear();
    row.attempts = row.artefacts = "[]";
    row.curve.clear();
    row.error_now.clear();
    return row;
}

}  // namespace

std::vector<JobRow> JobMerges::jobs_to_merge(const std::vector<std::string>& ids) {
    std::vector<JobRow> rows;
    json first;
    for (size_t i = 0; i < ids.size(); ++i) {
        const int64_t seq = job_seq(ids[i]);
        auto row = seq ? core_.store.job(seq) : std::nullopt;
        if (!row) throw Error(ErrorCode::UnknownName, at(i), "there is no job '" + ids[i] + "'");
        if (!is_over(row->state) || row->film.empty())
            throw Error(ErrorCode::Conflict, at(i),
                        "job " + ids[i] + " is " + std::string(job_state_name(row->state)) +
                            (is_over(row->state) ? " and has no film" : ", not over"));
        if (i == 0)
            first = likeness(*row);
        else
            check_alike(first, likeness(*row), ids[0], i);
        rows.push_back(*std::move(row));
    }
    const MethodInfo* method = find_method(rows.front().method);
    const std::string_view building = method ? builds_on_before(*method, first["method"]["parameters"]) : "";
    if (rows.size() > 1 && !building.empty())
        throw Error(ErrorCode::Unsupported, at(0),
                    "films of " + rows.front().method + " cannot be merged with these parameters: their " +
                        std::string(building) + " build on those before");
    return rows;
}

json JobMerges::merge_jobs(const json& body, const std::optional<std::string>& key) {
    if (key) check_idempotency_key(*key);
    const std::vector<std::string> ids = read_ids(body);
    const std::string said = json{{"merge", ids}}.dump();
    const std::string body_sha256 = sha256_hex(said.data(), said.size());
    std::vector<JobRow> parts;
    std::vector<FilmSource> films;  // held by names of their own: a job may be purged meanwhile
    MergeFilmsRequest order;
    {
        const std::lock_guard lock(core_.mutex);
        if (key)
            if (const auto known = objects_.job_of_key(*key, body_sha256)) return objects_.job_object(*known);
        if (core_.stopping) throw Error(ErrorCode::Unavailable, "the daemon is stopping and takes no new jobs");
        parts = jobs_to_merge(ids);
        uint64_t bytes = 0;
        for (const JobRow& part : parts) {
            FilmSource& film = films.emplace_back();
            film.path = require_kept(core_.files.films / part.film, job_id(part.seq));
            films_.pin(film);
            bytes = std::max<uint64_t>(bytes, fs::file_size(film.path));
            order.films.push_back(film.path);
        }
        core_.check_disk(bytes);
    }
    FilmSource merged;
    merged.path = core_.files.fresh_spool_path();
    order.job_request = json::parse(parts.front().request);
    order.scene_id = parts.front().scene;
    order.origin = film_origin(core_.store.id());
    order.out = merged.path;
    MergeFilmsReply reply;
    try {
        reply = core_.bulk_helper->ask(std::move(order));
    } catch (const Error& error) {
        remove_quietly(merged.path);
        std::vector<Fault> faults = error.faults;
        for (Fault& fault : faults)
            if (fault.pointer.starts_with("/films")) fault.pointer.replace(0, 6, "/jobs");
        throw Error(error.code, error.what(), std::move(faults));
    }
    return add_merged(merged_row(parts, reply), merged.path, ids, key, body_sha256);
}

json JobMerges::add_merged(JobRow row, const fs::path& film, const std::vector<std::string>& ids,
                           const std::optional<std::string>& key, const std::string& body_sha256) {
    std::string parts;
    for (const std::string& id : ids) parts += (parts.empty() ? "" : ", ") + id;
    const std::lock_guard lock(core_.mutex);
    if (key)
        if (const auto known = objects_.job_of_key(*key, body_sha256)) {  // said twice at the same time
            remove_quietly(film);
            return objects_.job_object(*known);
        }
    // The film is on the disk under its name before a row names it; where none comes to, the next start removes it.
    row.film = "merged-" + std::to_string(row.created_ms) + "-" + film.filename().string() + ".film";
    {
        auto transaction = core_.store.transaction();
        purges_.note_removal(row.film);
        transaction.commit();
    }
    publish(film, core_.files.films / row.film);
    Outbox outbox;
    try {
        auto transaction = core_.store.transaction();
        core_.store.forget_unnamed_file(path_of_film(row.film));
        core_.store.insert_job(row);
        if (key) core_.store.insert_key(*key, body_sha256, row.seq, row.created_ms);
        core_.store.append_log(row.seq, row.created_ms, "merged from " + parts);
        core_.put_event(outbox, "state", row.seq, ServiceCore::state_data(row));
        transaction.commit();
    } catch (...) {
        purges_.remove_film(row.film);
        throw;
    }
    core_.tell(std::move(outbox));
    return objects_.job_object(row);
}

}  // namespace photond
