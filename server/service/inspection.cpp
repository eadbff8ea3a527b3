#include "server/service/inspection.h"

#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <utility>

#include "protocol/error.h"
#include "protocol/problem.h"
#include "protocol/worker_messages.h"
#include "server/clock_text.h"
#include "server/service/saved_film.h"
#include "server/service/stray_files.h"
#include "server/service/uploads.h"

namespace photond {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// A row's file that is not there as it should be.
struct BadFile {
    enum class Of : uint8_t { Film, Artefact, Scene, Image };
    Of of = Of::Film;
    int64_t job = 0;   // of the first two
    std::string id;    // of the others
    std::string path;  // within the data folder
    std::string what;  // "is missing", or how it is damaged

    std::string line() const {
        const std::string whose = of == Of::Scene   ? "scene " + id
                                  : of == Of::Image ? "image " + id
                                                    : "job " + job_id(job);
        return whose + ": " + path + " " + what;
    }
};

constexpr const char* kMissing = "is missing";

/// How a film is wrong; nothing where it is right.
std::optional<std::string> fault_of_film(const fs::path& path, const std::string& store_id) {
    if (!fs::is_regular_file(fs::symlink_status(path))) return kMissing;
    try {
        const json origin = json::parse(FilmFile::examine(path).origin, nullptr, false);
        if (origin.is_object() && origin.value("store", store_id) != store_id) return "is of another store";
    } catch (const Error& error) {
        return std::string("cannot be read: ") + error.what();
    }
    return std::nullopt;
}

/// How what was uploaded is wrong: its id is the hash of its content.
template <class Hash>
std::optional<std::string> fault_of_upload(const fs::path& path, const std::string& id, const Hash& hash) {
    if (!fs::exists(fs::symlink_status(path))) return kMissing;
    try {
        if (hash(path).substr(0, kContentIdDigits) != id) return "is damaged: it is not what was uploaded";
    } catch (const std::exception& error) {
        return std::string("cannot be read: ") + error.what();
    }
    return std::nullopt;
}

std::vector<BadFile> find_bad_files(const DataFiles& files, Store& store) {
    std::vector<BadFile> bad;
    for (const FilmRow& row : store.films()) {
        const std::vector<std::string> paths = files_of_film(row);
        if (auto what = fault_of_film(files.directory / paths.front(), store.id()))
            bad.push_back({BadFile::Of::Film, row.seq, "", paths.front(), *std::move(what)});
        for (size_t i = 1; i < paths.size(); ++i)
            if (!fs::is_regular_file(fs::symlink_status(files.directory / paths[i])))
                bad.push_back({BadFile::Of::Artefact, row.seq, "", paths[i], kMissing});
    }
    const auto hash_scene = [](const fs::path& root) { return hash_tree(root, list_tree(root, kMostFilesOfScene)); };
    for (const std::string& id : store.scene_ids())
        if (auto what = fault_of_upload(files.scenes / id, id, hash_scene))
            bad.push_back({BadFile::Of::Scene, 0, id, path_of_scene(id), *std::move(what)});
    for (const auto& [id, file] : store.image_files())
        if (auto what = fault_of_upload(files.images / file, id, hash_file))
            bad.push_back({BadFile::Of::Image, 0, id, path_of_image(file), *std::move(what)});
    return bad;
}

bool rendered_by_nobody(int64_t) { return false; }

std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
}

void fail_job(JobRow& row, const std::string& detail) {
    row.state = JobState::Failed;
    row.finished_ms = now_ms();
    row.failure = problem_json(ErrorCode::ResultLost, detail, {}, "/v1/jobs/" + job_id(row.seq))
                      .dump(-1, ' ', false, json::error_handler_t::replace);
}

/// The row says from here on what it has no more; what is said of it.
std::string mark_job(Store& store, const BadFile& bad) {
    JobRow row = store.job(bad.job).value();
    std::string said = bad.path + " " + bad.what;
    if (bad.of == BadFile::Of::Artefact) {
        json kept = json::array();
        for (const json& name : json::parse(row.artefacts))
            if (artefact_path(path_of_film(row.film), name.get<std::string>()).string() != bad.path)
                kept.push_back(name);
        row.artefacts = kept.dump();
        said += ": the job has it no more";
    } else {
        row.film.clear();
        row.artefacts = "[]";
        row.passes_done = 0;
        if (row.state == JobState::Succeeded) {
            fail_job(row, said + "; retry the job to render it anew");
            said += ": the job failed, as result_lost";
        } else {
            said += is_over(row.state) ? ": the job has no film" : ": the job begins anew";
        }
    }
    store.update_job(row);
    store.append_log(row.seq, now_ms(), "repair: " + said);
    return "job " + job_id(row.seq) + ": " + said;
}

std::string forget_scene(Store& store, const BadFile& bad) {
    const std::string said = bad.path + " " + bad.what;
    size_t failed = 0;
    for (JobRow& row : store.queued_jobs_of_scene(bad.id)) {
        fail_job(row, "the job's scene is gone: " + said);
        store.update_job(row);
        store.append_log(row.seq, now_ms(), "repair: failed, for its scene is gone: " + said);
        ++failed;
    }
    store.delete_scene(bad.id);
    return "scene " + bad.id + ": " + said + ": it is removed and may be uploaded again; " + std::to_string(failed) +
           " jobs that waited failed, as result_lost";
}

std::string set_right(Store& store, const BadFile& bad) {
    auto transaction = store.transaction();
    std::string line;
    switch (bad.of) {
        case BadFile::Of::Film:
        case BadFile::Of::Artefact: line = mark_job(store, bad); break;
        case BadFile::Of::Scene: line = forget_scene(store, bad); break;
        case BadFile::Of::Image:
            store.delete_image(bad.id);
            line = bad.line() + ": it is removed and may be uploaded again";
            break;
    }
    transaction.commit();
    return line;
}

}  // namespace

std::vector<std::string> check_data_folder(const fs::path& folder) {
    if (!fs::is_directory(folder)) throw Error(ErrorCode::NotFound, "there is no data folder " + folder.string());
    const DataFiles files(folder, DataFiles::Use::Read);
    std::vector<std::string> lines;
    if (!fs::exists(files.store)) return {"store.sqlite is missing: a start makes a new one and quarantines the rest"};
    try {
        Store store(files.store, Store::Use::Read);
        const std::string integrity = store.database().integrity();
        if (integrity != "ok")
            for (const std::string& line : lines_of(integrity)) lines.push_back("store.sqlite: " + line);
        for (const BadFile& bad : find_bad_files(files, store)) lines.push_back(bad.line());
        std::vector<std::string> left_paths;
        for (const LeftFilm& left : find_left_films(files, store, rendered_by_nobody)) {
            left_paths.push_back(path_of_film(left.row.film));
            lines.push_back("job " + job_id(left.row.seq) + ": " + left_paths.back() + " holds " +
                            std::to_string(left.row.passes_done) +
                            " passes that its row does not know: a start takes them");
        }
        auto strays = find_stray_scratch(files, store);
        for (StrayFile& stray : find_stray_results(files, store)) strays.push_back(std::move(stray));
        for (const StrayFile& stray : strays) {
            if (stray.reason.empty()) continue;
            const std::string path = stray.path.string();
            bool left = false;
            for (const std::string& film : left_paths) left = left || path.starts_with(film);
            if (!left) lines.push_back(path + " is named by no row: a start moves it to quarantine");
        }
    } catch (const Error& error) {
        lines.push_back(std::string("store.sqlite cannot be read: ") + error.what());
    }
    return lines;
}

std::vector<std::string> repair_data_folder(const fs::path& folder) {
    if (!fs::is_directory(folder)) throw Error(ErrorCode::NotFound, "there is no data folder " + folder.string());
    DataFiles files(folder);
    Store store(files.store);
    if (const std::string integrity = store.database().integrity(); integrity != "ok")
        throw Error(ErrorCode::Internal, "the store is damaged, which cannot be repaired (restore a backup): " +
                                             lines_of(integrity).front());
    Quarantine quarantine(files.directory);
    std::vector<std::string> lines;
    for (const LeftFilm& left : find_left_films(files, store, rendered_by_nobody)) {
        adopt(store, left);
        lines.push_back("job " + job_id(left.row.seq) + ": " + left.line());
    }
    for (const BadFile& bad : find_bad_files(files, store)) {
        lines.push_back(set_right(store, bad));
        if (fs::exists(fs::symlink_status(files.directory / bad.path))) quarantine.take(bad.path, "damaged");
    }
    auto strays = find_stray_scratch(files, store);
    for (StrayFile& stray : find_stray_results(files, store)) strays.push_back(std::move(stray));
    for (const StrayFile& stray : strays)
        lines.push_back(stray.path.string() +
                        (stray.reason.empty() ? ": temporary, removed" : ": moved to quarantine, " + stray.reason));
    if (!clear_away(strays, files, quarantine))
        throw Error(ErrorCode::Internal, "not all could be moved to quarantine; the log says what");
    settle_files(files, store);
    return lines;
}

}  // namespace photond
