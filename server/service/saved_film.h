#pragma once
// The film that an attempt has saved, as it lies on the disk. Its file says which store, job and attempt it is of: so
// one that no row names yet can be told, whoever was killed before the row came.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/film/film_file.h"
#include "server/store/data_files.h"
#include "server/store/store.h"

namespace photond {

/// An attempt's number is the fencing token of its job.
struct AttemptId {
    int64_t seq = 0;
    int64_t attempt = 0;
    bool operator==(const AttemptId&) const = default;
};

/// "J12-3.film", in the films folder.
std::string film_name(AttemptId attempt);
/// The other way; nothing for any other name.
std::optional<AttemptId> attempt_of_film(std::string_view name);
/// Of a film in the films folder, its path within the data folder.
inline std::string path_of_film(const std::string& film) { return "films/" + film; }

/// Its path and those of its artefacts.
std::vector<std::string> files_of_film(const FilmRow& row);

/// FilmFacts::origin of what that attempt saves, or of a film that is joined from others.
std::string film_origin(const std::string& store_id, std::optional<AttemptId> attempt = std::nullopt);

/// What the film of that attempt holds. Nothing where it is not there, not complete, or not of that attempt and store;
/// the log says which of the latter. Reads all of it.
std::optional<FilmFacts> saved_film(const DataFiles& files, const std::string& store_id, AttemptId attempt);
/// Names of those artefacts of a method that lie beside a film.
std::vector<std::string> artefacts_beside(const std::filesystem::path& film, const std::string& method);
/// The row has that film from here on, of its newest attempt.
void take_saved_film(JobRow& row, const FilmFacts& film, const DataFiles& files);

}  // namespace photond
