#pragma once
// What can be downloaded of a comparison: its object with every curve, the curves as a table, and a page to look at.

#include <string>

#include "server/service/artefact_files.h"
#include "server/service/comparisons.h"
#include "server/service/jobs.h"
#include "server/service/service_types.h"

namespace photond {

struct Report;  // server/comparisons/report_html.h

/// All without the lock. All throw NotFound.
class ComparisonReports {
public:
    ComparisonReports(ArtefactFiles& artefact_files, Jobs& jobs, Comparisons& comparisons)
        : artefact_files_(artefact_files), jobs_(jobs), comparisons_(comparisons) {}

    Artefact comparison_json(const std::string& id);
    Artefact comparison_csv(const std::string& id);
    /// Waits for the helper. Throws NoSpace.
    Artefact comparison_html(const std::string& id);

private:
    /// Images and maps of what has succeeded, first seed of each row; waits for the helper. False where one is left out
    /// that may be there at the next look, such as a map that was not drawn in time because a job renders.
    bool add_pictures(Report& report, const Judged& judged);

    ArtefactFiles& artefact_files_;
    Jobs& jobs_;
    Comparisons& comparisons_;
};

}  // namespace photond
