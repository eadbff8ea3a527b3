#pragma once
// The page of a sequence, and of others beside it.

#include <string>
#include <vector>

#include "server/service/artefact_files.h"
#include "server/service/sequence_errors.h"
#include "server/service/sequence_files.h"
#include "server/service/sequences.h"
#include "server/service/service_types.h"

namespace photond {

/// Takes no lock; waits for the helper.
class SequenceReports {
public:
    SequenceReports(ArtefactFiles& artefact_files, Sequences& sequences, SequenceErrors& errors, SequenceFiles& files)
        : artefact_files_(artefact_files), sequences_(sequences), errors_(errors), files_(files) {}

    /// HTML that stands alone. Throws OutOfRange at /beside for more than kMostBeside, and what errors throw.
    Artefact html(const std::string& id, const SequenceReportWanted& wanted);

    static constexpr size_t kMostBeside = 15;

private:
    ArtefactFiles& artefact_files_;
    Sequences& sequences_;
    SequenceErrors& errors_;
    SequenceFiles& files_;
};

}  // namespace photond
