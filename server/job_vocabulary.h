#pragma once
// The names this build knows, for the readers of jobs and comparisons: in the daemon and in its workers.

#include "protocol/job.h"

namespace photond {

/// Methods, layers and metrics of the registry and its tables.
JobVocabulary job_vocabulary();

}  // namespace photond
