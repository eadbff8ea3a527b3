#pragma once
// A job's film, to be read: the one that it left, or a snapshot of the one at hand.

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "server/service/attempts.h"
#include "server/service/job_objects.h"
#include "server/service/service_core.h"

namespace photond {

struct FilmSource {
    bool pending = false;  // there is none yet; the rest is then empty
    std::filesystem::path path;
    std::string cache_key;
    std::string subject;  // the same; of a job that runs, whatever film is its newest
    nlohmann::json statistics;
    nlohmann::json request;  // the job's, every default filled in
    std::shared_ptr<const void> pin;
};

/// A file that a job's row names, under the lock: rows and files change together there, so that one which is not there
/// has been taken away by somebody else. Throws ResultLost then.
std::filesystem::path require_kept(const std::filesystem::path& file, const std::string& job);

class JobFilms {
public:
    JobFilms(ServiceCore& core, Attempts& attempts, JobObjects& objects)
        : core_(core), attempts_(attempts), objects_(objects) {}

    /// Takes the lock; of a running job it waits for the disk to take it, or for a moment where the client asks again,
    /// and gives an older snapshot then. Throws NotFound, with the reason, where there is none, and ResultLost where it
    /// is gone.
    FilmSource film_source(const std::string& id);
    /// Gives the film a second name that goes with the last user: it can be read whatever becomes of its job. With the
    /// lock or without. Throws NotFound where the job has just been removed.
    void pin(FilmSource& film);

private:
    ServiceCore& core_;
    Attempts& attempts_;
    JobObjects& objects_;
};

}  // namespace photond
