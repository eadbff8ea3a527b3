#pragma once
// Errors to look at: differences and maps of a job against its reference, and measuring on request.

#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "protocol/helper_messages.h"
#include "server/service/artefact_files.h"
#include "server/service/job_films.h"
#include "server/service/job_objects.h"
#include "server/service/pictures.h"
#include "server/service/references.h"
#include "server/service/service_core.h"
#include "server/service/service_types.h"

namespace photond {

/// All take the lock where they need it, and wait for the helper (and, while the job runs, for the pass at hand)
/// without it.
class ErrorArtefacts {
public:
    ErrorArtefacts(ServiceCore& core, ArtefactFiles& artefact_files, Pictures& pictures, References& references,
                   JobObjects& objects, JobFilms& films)
        : core_(core),
          artefact_files_(artefact_files),
          pictures_(pictures),
          references_(references),
          objects_(objects),
          films_(films) {}

    /// Of a job against its reference. They throw NotFound, with the reason, where either film is missing; faults of
    /// `layer` and `range`; TryLater of the pictures (Pictures::picture).
    Artefact difference(const std::string& id);
    Artefact flip(const std::string& id, const std::string& layer, const std::string& range);
    Artefact error_map(const std::string& id, const std::string& layer);

    /// Of any two, each "job:ID" or "image:ID". Throws faults of each argument; UnknownName; TryLater.
    Artefact flip_map(const std::string& image, const std::string& reference, const std::string& layer,
                      const std::string& range, const std::string& precision);
    /// `body`: {"image", "reference" or "references", "metrics"}. Throws faults of it; UnknownName, and WrongState for
    /// a job that has no film yet.
    nlohmann::json measure(const nlohmann::json& body);

private:
    struct MeasuredPair {
        FilmSource film;
        ReferenceSource reference;
        std::vector<FilmSource> pinned_references;
        std::string key;  // in the cache
    };
    /// What "job:ID" or "image:ID" names.
    struct NamedSource {
        FilmSource film;  // of a job; pending where it has none yet. Held as long as this lives
        ImageSource source;
        std::string key;      // in the cache
        std::string subject;  // as FilmSource's
    };
    /// A job's film and its reference. Throws NotFound, with the reason, where it has none. Pending likewise.
    MeasuredPair measured_pair(const std::string& id);
    using Encode = std::function<EncodedReply(Helper& helper, const ImageSource& image,
                                              const ReferenceSource& reference, const std::filesystem::path& out)>;
    /// The picture that `encode` makes of both; kept under their names and `what`.
    Artefact map_of_errors(const std::string& id, const std::string& what, const Encode& encode);
    NamedSource source_named(const std::string& name, const std::string& pointer);
    /// Two references. Throws Conflict where they are one, or jobs of one seed.
    void check_independent(const std::string& first, const std::string& second);

    ServiceCore& core_;
    ArtefactFiles& artefact_files_;
    Pictures& pictures_;
    References& references_;
    JobObjects& objects_;
    JobFilms& films_;
};

}  // namespace photond
