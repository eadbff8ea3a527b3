#include "server/service/stray_files.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <string_view>
#include <unordered_set>
#include <utility>

#include "protocol/worker_messages.h"
#include "server/clock_text.h"
#include "server/service/uploads.h"

namespace photond {

namespace fs = std::filesystem;
using nlohmann::json;
using Names = std::unordered_set<std::string>;

namespace {

constexpr const char* kNoRow = "no-row";
constexpr const char* kOtherStore = "other-store";

/// As DataFiles names what is spooled ("u") and cached ("a"), with what helpers add.
const std::regex kScratchName("[ua][0-9]+([.].*)?");
/// "J12-3.film" and what a worker writes beside it: parts, snapshots and artefacts.
const std::regex kFilmName("(J[0-9]+-[0-9]+[.]film)([.].*)?");
const std::regex kUnfinishedEnding("([.].+)?[.]part|[.]s[0-9]+");

std::vector<std::string> entries_of(const fs::path& folder) {
    std::vector<std::string> names;
    if (!fs::is_directory(folder)) return names;  // of a data folder that is only looked at
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
        names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

/// Everything that rows name, as paths within the data folder.
Names named_files(Store& store) {
    Names named;
    for (const FilmRow& row : store.films())
        for (std::string& path : files_of_film(row)) named.insert(std::move(path));
    for (const std::string& id : store.scene_ids()) named.insert(path_of_scene(id));
    for (const auto& [id, file] : store.image_files()) named.insert(path_of_image(file));
    return named;
}

std::optional<LeftFilm> left_film(const DataFiles& files, const Store& store, JobRow row) {
    const std::string name = film_name({row.seq, row.attempt});
    if (row.state == JobState::Succeeded || (is_over(row.state) && !row.film.empty())) return std::nullopt;
    const auto film = saved_film(files, store.id(), {row.seq, row.attempt});
    if (!film || (row.film == name && row.passes_done == film->passes)) return std::nullopt;
    LeftFilm left{std::move(row), {}};
    if (left.row.film != name) left.old_film = left.row.film;
    take_saved_film(left.row, *film, files);
    return left;
}

/// Why a file of a film is no row's: nothing where it is a temporary file of this store's own.
std::string reason_of_film_file(const std::string& name, const DataFiles& files, Store& store, bool of_this_store) {
    std::smatch parts;
    if (!of_this_store) return kOtherStore;
    if (!std::regex_match(name, parts, kFilmName)) return kNoRow;
    const std::string film = parts[1], ending = parts[2];
    if (std::regex_match(ending, kUnfinishedEnding)) return "";
    const auto attempt = attempt_of_film(film);
    const auto row = attempt ? store.job(attempt->seq) : std::nullopt;
    const bool begun = row && attempt->attempt <= row->attempt;
    // An artefact of an attempt that left no film: it comes again with the one that goes on.
    if (!ending.empty()) return begun && !fs::exists(files.films / film) ? "" : kNoRow;
    return kNoRow;
}

}  // namespace

std::string LeftFilm::line() const {
    return "the film of attempt " + std::to_string(row.attempt) + ", " + std::to_string(row.passes_done) +
           " passes, was saved before the daemon ended: it is the job's";
}

std::vector<LeftFilm> find_left_films(const DataFiles& files, Store& store, const IsRendered& is_rendered) {
    std::map<int64_t, JobRow> candidates;
    for (JobRow& row : store.running_jobs()) {
        const int64_t seq = row.seq;
        candidates.emplace(seq, std::move(row));
    }
    Names named;
    for (const FilmRow& row : store.films()) named.insert(row.film);
    for (const std::string& name : entries_of(files.films)) {
        const auto attempt = named.contains(name) ? std::nullopt : attempt_of_film(name);
        if (!attempt) continue;
        if (auto row = store.job(attempt->seq); row && row->attempt == attempt->attempt)
            candidates.emplace(attempt->seq, *std::move(row));
    }
    std::vector<LeftFilm> found;
    for (auto& [seq, row] : candidates)
        if (!is_rendered(seq))
            if (auto left = left_film(files, store, std::move(row))) found.push_back(*std::move(left));
    return found;
}

void adopt(Store& store, const LeftFilm& left) {
    auto transaction = store.transaction();
    store.update_job(left.row);
    store.append_log(left.row.seq, now_ms(), left.line());
    if (!left.old_film.empty()) store.note_unnamed_file(path_of_film(left.old_film));
    transaction.commit();
    spdlog::info("job {}: {}", job_id(left.row.seq), left.line());
}

std::vector<StrayFile> find_stray_scratch(const DataFiles& files, const Store& store) {
    const bool of_this_store = !store.is_new() && files.are_of(store.id());
    std::vector<StrayFile> strays;
    for (const fs::path& folder : {files.spool, files.cache})
        for (const std::string& name : entries_of(folder))
            strays.push_back({folder.filename() / name, !of_this_store                         ? kOtherStore
                                                        : std::regex_match(name, kScratchName) ? ""
                                                                                               : kNoRow});
    return strays;
}

std::vector<StrayFile> find_stray_results(const DataFiles& files, Store& store) {
    const bool of_this_store = !store.is_new() && files.are_of(store.id());
    const Names named = named_files(store);
    const std::vector<std::string> noted = store.unnamed_files();
    const Names temporary(noted.begin(), noted.end());
    std::vector<StrayFile> strays;
    for (const fs::path& folder : {files.films, files.scenes, files.images})
        for (const std::string& name : entries_of(folder)) {
            const std::string path = folder.filename() / name;
            if (named.contains(path)) continue;
            std::smatch parts;
            const bool of_film = folder == files.films && std::regex_match(name, parts, kFilmName);
            const std::string film = of_film ? parts[1].str() : name;
            std::string reason = of_this_store ? kNoRow : kOtherStore;
            if (temporary.contains(path) ||
                (of_film && temporary.contains(path_of_film(film)) && !named.contains(path_of_film(film))))
                reason.clear();
            else if (folder == files.films)
                reason = reason_of_film_file(name, files, store, of_this_store);
            strays.push_back({path, std::move(reason)});
        }
    return strays;
}

bool clear_away(const std::vector<StrayFile>& strays, const DataFiles& files, Quarantine& quarantine) {
    size_t removed = 0;
    bool all = true;
    for (const StrayFile& stray : strays) {
        if (stray.reason.empty()) {
            remove_quietly(files.directory / stray.path);
            ++removed;
            continue;
        }
        try {
            const uint64_t bytes = bytes_below(files.directory / stray.path);
            const fs::path now = quarantine.take(stray.path, stray.reason);
            spdlog::warn("quarantine: {} ({} bytes) is named by no row of this store; it is now {}",
                         stray.path.string(), bytes, now.string());
        } catch (const Error& error) {
            all = false;
            spdlog::error("{} is named by no row of this store and cannot be moved to quarantine: {}",
                          stray.path.string(), error.what());
        }
    }
    if (removed > 0) spdlog::info("removed {} temporary files of an earlier daemon", removed);
    return all;
}

void settle_files(DataFiles& files, Store& store) {
    auto transaction = store.transaction();
    for (const std::string& path : store.unnamed_files()) store.forget_unnamed_file(path);
    transaction.commit();
    files.become_of(store.id());
}

}  // namespace photond
