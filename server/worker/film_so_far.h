#pragma once
// The film so far, told and shown while the next pass is rendered, whatever that pass takes.

#include <condition_variable>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "protocol/worker_messages.h"
#include "renderer/core/stats.h"
#include "renderer/film/film_file.h"
#include "server/worker/pass_loop.h"
#include "server/worker/render_meters.h"

namespace photond {

/// The least time between two progress messages.
inline constexpr double kProgressSeconds = 0.25;
/// A film that is asked for is saved between passes, off the clock, when the pass at hand is done within this time, and
/// beside that pass otherwise.
inline constexpr double kSavedBesideAfter = 0.025;

/// Who asks for a running job's film; from another thread than the one that renders.
class FilmRequests {
public:
    /// Save the film so far to `path`; a second request before that replaces the first.
    void ask(std::filesystem::path path);

private:
    friend class FilmSoFar;

    std::mutex mutex_;
    std::condition_variable changed_;
    std::optional<std::filesystem::path> asked_;
    double asked_at_ = 0;
};

/// Reads the film in a thread of its own, whose life is this object's. The rendering thread calls all functions. What
/// it saves is to be looked at: such a film's history has its seconds alone, and it has no state to be gone on with.
class FilmSoFar final : public FilmReader {
public:
    /// Called from either thread, and both may be called at once.
    struct Told {
        std::function<void(ProgressMessage progress)> progress;
        std::function<void(const std::filesystem::path& path, uint32_t passes)> saved;
    };

    /// Borrows `requests`, `stats` and `meters`.
    FilmSoFar(FilmRequests& requests, FilmIdentity identity, std::string origin, Told told, Stats& stats,
              RenderMeters& meters);
    ~FilmSoFar() override;
    FilmSoFar(const FilmSoFar&) = delete;
    FilmSoFar& operator=(const FilmSoFar&) = delete;

    bool hold(bool wait) override;
    /// Saves it here and now where it is asked for already.
    void stands(const Film& film, double seconds) override;
    /// What the daemon is to hear of it: at once, or as soon as kProgressSeconds have passed since the last. True when
    /// it was at once.
    bool tell(ProgressMessage progress);

private:
    void run();
    /// With the lock, which it gives up while it writes.
    void save_as_asked(std::unique_lock<std::mutex>& lock);
    void tell_progress();

    FilmRequests& requests_;
    const FilmIdentity identity_;
    const std::string origin_;
    const Told told_;
    Stats& stats_;
    RenderMeters& meters_;

    // Under the requests' mutex.
    const Film* film_ = nullptr;  // null while it changes
    double film_seconds_ = 0;
    bool reading_ = false, over_ = false;
    std::optional<ProgressMessage> untold_;
    double last_told_ = 0;

    std::thread thread_;
};

}  // namespace photond
