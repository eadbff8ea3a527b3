#pragma once
// What can be downloaded of a job: encoded by the helper from the film on the disk, kept by content.

#include <functional>
#include <string>

#include "protocol/helper_messages.h"
#include "server/service/artefact_files.h"
#include "server/service/job_films.h"
#include "server/service/job_objects.h"
#include "server/service/service_core.h"
#include "server/service/service_types.h"

namespace photond {

/// All take the lock where they need it, and wait for the helper (and, while the job runs, for the pass at hand)
/// without it. All throw NotFound, with the reason, where there is nothing to be had.
class JobArtefacts {
public:
    JobArtefacts(ServiceCore& core, ArtefactFiles& artefact_files, JobObjects& objects, JobFilms& films)
        : core_(core), artefact_files_(artefact_files), objects_(objects), films_(films) {}

    /// `precision` is "float" or "half", else they throw OutOfRange.
    Artefact image(const std::string& id, const std::string& precision);
    Artefact pixels(const std::string& id, const std::string& layer, const std::string& precision);
    Artefact preview(const std::string& id, const PreviewWanted& wanted);
    /// Throws Error with all faults: UnknownName, OutOfRange, Conflict.
    static void check_look(const PreviewWanted& wanted);
    /// The film itself.
    Artefact film(const std::string& id);
    Artefact statistics(const std::string& id);
    Artefact curve_file(const std::string& id);
    Artefact method_artefact(const std::string& id, const std::string& name);
    Artefact log(const std::string& id);

private:
    using Encode = std::function<EncodedReply(const FilmSource& film, const std::filesystem::path& out)>;
    /// What `encode` makes of the job's film; kept under the film's name and `what`.
    Artefact encoded(const std::string& id, const std::string& what, const std::string& media_type,
                     const Encode& encode);

    ServiceCore& core_;
    ArtefactFiles& artefact_files_;
    JobObjects& objects_;
    JobFilms& films_;
};

}  // namespace photond
