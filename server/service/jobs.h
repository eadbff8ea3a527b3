#pragma once
// All that can be done with jobs, a class for each subject; they are made here in the order in which they need each
// other.

#include "server/service/artefact_files.h"
#include "server/service/attempts.h"
#include "server/service/cancellations.h"
#include "server/service/error_artefacts.h"
#include "server/service/estimates.h"
#include "server/service/job_artefacts.h"
#include "server/service/job_changes.h"
#include "server/service/job_films.h"
#include "server/service/job_intake.h"
#include "server/service/job_merges.h"
#include "server/service/job_objects.h"
#include "server/service/pictures.h"
#include "server/service/purges.h"
#include "server/service/references.h"
#include "server/service/scenes.h"
#include "server/service/service_core.h"
#include "server/service/submissions.h"
#include "server/service/waiting_jobs.h"

namespace photond {

struct Jobs {
    Jobs(ServiceCore& core, ArtefactFiles& artefact_files, Pictures& pictures, Scenes& scenes, References& references,
         WaitingJobs& waiting, Purges& purges, Attempts& attempts)
        : objects(core, scenes, attempts),
          estimates(core, scenes),
          intake(core, references, waiting, attempts),
          submissions(core, scenes, references, estimates, intake, objects),
          cancellations(core, references, waiting, purges, attempts, objects),
          changes(core, scenes, references, attempts, estimates, intake, submissions, objects),
          films(core, attempts, objects),
          merges(core, purges, objects, films),
          artefacts(core, artefact_files, objects, films),
          errors(core, artefact_files, pictures, references, objects, films) {}

    JobObjects objects;
    Estimates estimates;
    JobIntake intake;
    Submissions submissions;
    Cancellations cancellations;
    JobChanges changes;
    JobFilms films;
    JobMerges merges;
    JobArtefacts artefacts;
    ErrorArtefacts errors;
};

}  // namespace photond
