#include "server/worker/film_so_far.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <limits>
#include <utility>

#include "server/worker/film_history.h"
#include "server/worker/off_the_clock.h"

namespace photond {

void FilmRequests::ask(std::filesystem::path path) {
    const std::lock_guard lock(mutex_);
    asked_ = std::move(path);
    asked_at_ = wall_now_seconds();
    changed_.notify_all();
}

FilmSoFar::FilmSoFar(FilmRequests& requests, FilmIdentity identity, std::string origin, Told told, Stats& stats,
                     RenderMeters& meters)
    : requests_(requests),
      identity_(std::move(identity)),
      origin_(std::move(origin)),
      told_(std::move(told)),
      stats_(stats),
      meters_(meters),
      thread_([this] { run(); }) {}

FilmSoFar::~FilmSoFar() {
    {
        const std::lock_guard lock(requests_.mutex_);
        over_ = true;
    }
    requests_.changed_.notify_all();
    thread_.join();
}

bool FilmSoFar::hold(bool wait) {
    std::unique_lock lock(requests_.mutex_);
    if (reading_) {
        if (!wait) return false;
        const OffTheClock waiting(stats_, kFilmSavingStage, meters_);
        requests_.changed_.wait(lock, [this] { return !reading_; });
    }
    film_ = nullptr;
    return true;
}

void FilmSoFar::stands(const Film& film, double seconds) {
    std::unique_lock lock(requests_.mutex_);
    film_ = &film;
    film_seconds_ = seconds;
    if (!requests_.asked_) return;
    const OffTheClock saving(stats_, kFilmSavingStage, meters_);
    save_as_asked(lock);
}

bool FilmSoFar::tell(ProgressMessage progress) {
    const std::lock_guard lock(requests_.mutex_);
    untold_ = std::move(progress);
    if (wall_now_seconds() < last_told_ + kProgressSeconds) {
        requests_.changed_.notify_all();
        return false;
    }
    tell_progress();
    return true;
}

void FilmSoFar::tell_progress() {
    told_.progress(*std::exchange(untold_, std::nullopt));
    last_told_ = wall_now_seconds();
}

void FilmSoFar::save_as_asked(std::unique_lock<std::mutex>& lock) {
    const std::filesystem::path path = *std::exchange(requests_.asked_, std::nullopt);
    const Film& film = *film_;
    // Not what stages and counts came to: those are the pass's at hand.
    const std::string history = FilmHistory{.seconds = film_seconds_}.text();
    reading_ = true;
    lock.unlock();
    try {
        FilmFile::save(film, identity_, history, path, origin_);
        told_.saved(path, film.passes());
    } catch (const std::exception& error) {  // of no concern to the job
        spdlog::warn("the film so far cannot be saved: {}", error.what());
    }
    lock.lock();
    reading_ = false;
    requests_.changed_.notify_all();
}

void FilmSoFar::run() {
    std::unique_lock lock(requests_.mutex_);
    while (!over_) {
        const double now = wall_now_seconds();
        double next = std::numeric_limits<double>::infinity();
        if (untold_) next = last_told_ + kProgressSeconds;
        const bool may_read = film_ && requests_.asked_ && !reading_;
        if (may_read) next = std::min(next, requests_.asked_at_ + kSavedBesideAfter);
        if (next > now) {
            if (next == std::numeric_limits<double>::infinity())
                requests_.changed_.wait(lock);
            else
                requests_.changed_.wait_for(lock, std::chrono::duration<double>(next - now));
            continue;
        }
        if (untold_ && last_told_ + kProgressSeconds <= now) tell_progress();
        if (may_read && requests_.asked_at_ + kSavedBesideAfter <= now) save_as_asked(lock);
    }
}

}  // namespace photond
