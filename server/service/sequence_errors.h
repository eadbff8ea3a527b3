#pragma once
// Errors of a sequence by frame, against two others that are its references: how wrong each frame is, how much it
// flickers and how late it shows what moves.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "server/service/artefact_files.h"
#include "server/service/job_films.h"
#include "server/service/pictures.h"
#include "server/service/sequences.h"

namespace photond {

/// Takes no lock; waits for the helper.
class SequenceErrors {
public:
    SequenceErrors(Pictures& pictures, JobFilms& films, Sequences& sequences)
        : pictures_(pictures), films_(films), sequences_(sequences) {}

    /// protocol.md, "Sequences". Of the frames that have succeeded in all three; what was measured before is kept.
    /// `first` and `second`: the references' ids. Throws NotFound; Conflict at /first or /second where frames are not
    /// of the same moments, scene, view and size or share a seed with others of the three; UnknownName at /layer;
    /// TryLater while a job renders and there is more to be measured.
    nlohmann::json errors(const std::string& id, const std::string& first, const std::string& second,
                          const std::string& layer);

private:
    /// Of frame `frame` of the three, and of the one before where that has succeeded too.
    nlohmann::json measured_frame(const nlohmann::json (&sequences)[3], size_t frame, const std::string& layer);

    Pictures& pictures_;
    JobFilms& films_;
    Sequences& sequences_;
};

}  // namespace photond
