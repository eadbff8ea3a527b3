#include "server/worker/film_saver.h"

#include <algorithm>

#include "server/worker/off_the_clock.h"

namespace photond {

namespace {

/// For the first saving, whose cost is not known yet: of a film's sums in memory, on a slow disk.
constexpr double kBytesASecond = 200e6;

}  // namespace

FilmSaver::FilmSaver(FilmIdentity identity, std::optional<double> save_seconds, Stats& stats, RenderMeters& meters,
                     Clock now)
    : identity_(std::move(identity)),
      save_seconds_(save_seconds),
      stats_(stats),
      meters_(meters),
      now_(std::move(now)),
      last_end_(now_()) {}

bool FilmSaver::due(const Film& film) const {
    if (!save_seconds_) return false;
    const double cost = last_cost_.value_or(static_cast<double>(film.bytes()) / kBytesASecond);
    return now_() - last_end_ >= std::max(*save_seconds_, kSavingPause * cost);
}

void FilmSaver::save(const Film& film, const std::string& history, const std::filesystem::path& path,
                     const std::string& origin, const std::string& state, const std::string& left) {
    const OffTheClock saving(stats_, kFilmSavingStage, meters_);
    const double start = now_();
    FilmFile::save(film, identity_, history, path, origin, state, left);
    last_end_ = now_();
    last_cost_ = last_end_ - start;
}

}  // namespace photond
