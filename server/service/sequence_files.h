#pragma once
// All frames of a sequence as one file.

#include <string>

#include "server/service/artefact_files.h"
#include "server/service/jobs.h"
#include "server/service/sequences.h"

namespace photond {

class SequenceFiles {
public:
    SequenceFiles(ArtefactFiles& artefact_files, ServiceCore& core, Jobs& jobs, Sequences& sequences)
        : artefact_files_(artefact_files), core_(core), jobs_(jobs), sequences_(sequences) {}

    /// A ZIP of the frames that have succeeded so far, as 0000.exr or 0000.png by `images`. Waits for the helper.
    /// Pending while there is none. Throws NotFound, OutOfRange for another word, and what images throw.
    Artefact frames_zip(const std::string& id, const std::string& images);

private:
    ArtefactFiles& artefact_files_;
    ServiceCore& core_;
    Jobs& jobs_;
    Sequences& sequences_;
};

}  // namespace photond
