#pragma once
// Saves a job's film while it is rendered, off its clock and at a bounded share of the time.

#include <filesystem>
#include <functional>
#include <optional>

#include "renderer/core/stats.h"
#include "renderer/film/film_file.h"
#include "server/worker/render_meters.h"

namespace photond {

/// Between two savings lies at least this many times what the last one took: 2 % of the time.
inline constexpr double kSavingPause = 50;

class FilmSaver {
public:
    using Clock = std::function<double()>;

    /// `save_seconds`: the least time between two savings; none: never of its own accord. Time runs from now on.
    FilmSaver(FilmIdentity identity, std::optional<double> save_seconds, Stats& stats, RenderMeters& meters,
              Clock now = wall_now_seconds);

    const FilmIdentity& identity() const { return identity_; }
    /// Whether it is time to save the film again.
    bool due(const Film& film) const;
    /// As FilmFile::save(), timed.
    void save(const Film& film, const std::string& history, const std::filesystem::path& path,
              const std::string& origin = {}, const std::string& state = {}, const std::string& left = {});

private:
    const FilmIdentity identity_;
    const std::optional<double> save_seconds_;
    Stats& stats_;
    RenderMeters& meters_;
    const Clock now_;
    double last_end_;
    std::optional<double> last_cost_;
};

}  // namespace photond
