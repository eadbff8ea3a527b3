#include "server/service/saved_film.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "protocol/job.h"
#include "protocol/worker_messages.h"
#include "renderer/methods/registry.h"
#include "server/job_vocabulary.h"
#include "server/row_text.h"

namespace photond {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr std::string_view kFilmEnding = ".film";

}  // namespace

std::string film_name(AttemptId attempt) {
    return job_id(attempt.seq) + "-" + std::to_string(attempt.attempt) + std::string(kFilmEnding);
}

std::optional<AttemptId> attempt_of_film(std::string_view name) {
    const size_t dash = name.find('-');
    if (dash == std::string_view::npos || !name.ends_with(kFilmEnding)) return std::nullopt;
    const std::string number(name.substr(dash + 1, name.size() - dash - 1 - kFilmEnding.size()));
    AttemptId attempt{job_seq(name.substr(0, dash)), job_seq("J" + number)};  // both are numbers from 1 on
    if (attempt.seq == 0 || attempt.attempt == 0) return std::nullopt;
    return attempt;
}

std::vector<std::string> files_of_film(const FilmRow& row) {
    std::vector<std::string> paths{path_of_film(row.film)};
    for (const json& name : json::parse(row.artefacts))
        paths.push_back(artefact_path(paths.front(), name.get<std::string>()).string());
    return paths;
}

std::string film_origin(const std::string& store_id, std::optional<AttemptId> attempt) {
    json origin{{"store", store_id}};
    if (attempt) origin["job"] = job_id(attempt->seq), origin["attempt"] = attempt->attempt;
    return origin.dump();
}

std::optional<FilmFacts> saved_film(const DataFiles& files, const std::string& store_id, AttemptId attempt) {
    const fs::path path = files.films / film_name(attempt);
    if (!fs::is_regular_file(fs::symlink_status(path))) return std::nullopt;
    try {
        FilmFacts film = FilmFile::examine(path);
        if (film.origin == film_origin(store_id, attempt) && film.passes > 0) return film;
        spdlog::warn("{} is not what attempt {} of job {} has saved: its origin is '{}'", path.string(),
                     attempt.attempt, job_id(attempt.seq), film.origin);
    } catch (const Error& error) {
        spdlog::warn("{}", error.what());
    }
    return std::nullopt;
}

std::vector<std::string> artefacts_beside(const fs::path& film, const std::string& method) {
    std::vector<std::string> names;
    const MethodInfo* info = find_method(method);
    for (const ArtefactInfo& artefact : info ? info->artefacts : std::vector<ArtefactInfo>())
        if (fs::is_regular_file(fs::symlink_status(artefact_path(film, artefact.name))))
            names.emplace_back(artefact.name);
    return names;
}

void take_saved_film(JobRow& row, const FilmFacts& film, const DataFiles& files) {
    const json history = json::parse(film.history, nullptr, false);
    row.film = film_name({row.seq, row.attempt});
    row.passes_done = film.passes;
    row.artefacts = json(artefacts_beside(files.films / row.film, row.method)).dump();
    if (!history.is_object()) return;
    row.seconds = history.value("seconds", row.seconds);
    row.curve = text_of(history.value("curve", json::array()));
    try {
        const JobRequest request = parse_job_request(json::parse(row.request), job_vocabulary());
        row.progress = std::max(row.progress, progress_of(request.stop, film.passes, row.seconds));
    } catch (const Error& error) {  // of an older version: the next attempt says it
        spdlog::warn("job {}: how far it has come is not known: {}", job_id(row.seq), error.what());
    }
}

}  // namespace photond
