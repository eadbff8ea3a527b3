#pragma once
// What lies in the data folder and no row names: an earlier daemon may have ended at any point, and a store may have
// been lost. Only what is known to be this store's own and temporary may be removed.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "server/service/saved_film.h"
#include "server/store/data_files.h"
#include "server/store/quarantine.h"
#include "server/store/store.h"

namespace photond {

/// A film that an attempt saved and its job's row does not know.
struct LeftFilm {
    JobRow row;            // as it is with the film
    std::string old_film;  // that it had before; empty: none
    std::string line() const;
};

/// Whether a job is being rendered at this moment: its newest attempt's files are its worker's.
using IsRendered = std::function<bool(int64_t seq)>;

/// Complete films of this store, of the newest attempt of a job that has not succeeded.
std::vector<LeftFilm> find_left_films(const DataFiles& files, Store& store, const IsRendered& is_rendered);
/// Writes such a row. The old film is then a stray file.
void adopt(Store& store, const LeftFilm& left);

struct StrayFile {
    std::filesystem::path path;  // within the data folder
    std::string reason;          // to quarantine it, a word or two; empty: a temporary file of this store's own
};

/// While nothing is served or rendered. Spool and cache are the daemon's scratch; left films are stray until they are
/// adopted.
std::vector<StrayFile> find_stray_scratch(const DataFiles& files, const Store& store);
std::vector<StrayFile> find_stray_results(const DataFiles& files, Store& store);

/// Removes what is temporary and moves the rest to quarantine; the log says each of those. What cannot be moved stays,
/// and the log says why. True where nothing has stayed.
bool clear_away(const std::vector<StrayFile>& strays, const DataFiles& files, Quarantine& quarantine);

/// Once all of them are cleared away: from here on everything that lies there is this store's.
void settle_files(DataFiles& files, Store& store);

}  // namespace photond
