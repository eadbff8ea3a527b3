#include "server/worker/helper_merge.h"

#include "protocol/job.h"
#include "renderer/film/film_file.h"
#include "server/job_vocabulary.h"
#include "server/worker/film_history.h"
#include "server/worker/statistics.h"

namespace photond {

using nlohmann::json;

namespace {

struct JoinedFilms {
    SavedFilm saved;
    FilmHistory history;
};

void join(JoinedFilms& joined, const std::filesystem::path& path, uint64_t memory_bytes) {
    const uint64_t held = joined.saved.film.bytes();
    const SavedFilm next = FilmFile::load(path, memory_bytes - std::min(memory_bytes, held));
    require_alike(joined.saved.identity, next.identity);
    const FilmHistory history = FilmHistory::parse(next.history);
    joined.saved.film.merge(next.film);
    joined.history += history;
}

JoinedFilms first_film(const std::filesystem::path& path, uint64_t memory_bytes) {
    SavedFilm saved = FilmFile::load(path, memory_bytes);
    require_alike(saved.identity, saved.identity);  // it must say what it is
    FilmHistory history = FilmHistory::parse(saved.history);
    return {std::move(saved), std::move(history)};
}

JoinedFilms join_all(const std::vector<std::filesystem::path>& paths, uint64_t memory_bytes) {
    size_t at = 0;
    try {
        JoinedFilms joined = first_film(paths[0], memory_bytes);
        for (at = 1; at < paths.size(); ++at) join(joined, paths[at], memory_bytes);
        return joined;
    } catch (const Error& error) {
        throw Error(error.code, "/films/" + std::to_string(at), error.what());
    }
}

/// What was measured of one process and one scene in memory does not add up over jobs: null.
json statistics_of(const JoinedFilms& joined, const JobRequest& request, const std::string& scene_id) {
    const Stats stats{joined.history.counts, joined.history.stages, joined.history.skipped};
    const MemoryBudget no_budget;
    const Needs no_needs;
    const Device device{.id = request.method.device, .kind = "", .name = ""};
    json statistics = statistics_json({.stats = stats,
                                       .film = joined.saved.film,
                                       .pixel_hash = joined.saved.film.pixel_hash(),
                                       .budget = no_budget,
                                       .needs = no_needs,
                                       .device = device,
                                       .request = request,
                                       .scene_id = scene_id,
                                       .render_seconds = joined.history.seconds,
                                       .threads = 0,
                                       .baseline_resident_bytes = 0,
                                       .peak_resident_bytes = 0,
                                       .settings_hash = joined.saved.identity.settings,
                                       .resumed_passes = 0,
                                       .errors = nullptr});
    for (const char* unknown : {"needs", "left_out", "threads", "host_cores", "device_shared", "host_shared"})
        statistics[unknown] = nullptr;
    for (const char* unknown : {"accounted_bytes", "baseline_resident_bytes", "peak_resident_bytes"})
        statistics["memory"][unknown] = nullptr;
    for (const char* unknown : {"name", "software"}) statistics["device"][unknown] = nullptr;
    return statistics;
}

}  // namespace

MergeFilmsReply merge_films(const MergeFilmsRequest& asked, uint64_t memory_bytes) {
    if (asked.films.empty()) throw Error(ErrorCode::MissingField, "/films", "must name films");
    const JobRequest request = parse_job_request(asked.job_request, job_vocabulary());
    const JoinedFilms joined = join_all(asked.films, memory_bytes);
    const Film& film = joined.saved.film;
    if (film.passes() == 0) throw Error(ErrorCode::Internal, "/films", "the films have no pass");
    json statistics = statistics_of(joined, request, asked.scene_id);
    // The state of several runs is that of none.
    const bool is_one = asked.films.size() == 1;
    FilmFile::save(film, joined.saved.identity, joined.history.text(), asked.out, asked.origin,
                   is_one ? joined.saved.state : std::string());
    std::string pixel_hash = statistics["pixel_hash"];
    return {film.passes(), joined.history.seconds, std::move(statistics), std::move(pixel_hash)};
}

}  // namespace photond
