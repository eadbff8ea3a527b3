#pragma once
// Requests that were kept by daemons of before: each is given the parameters that it lacks, once, so that whoever goes
// on with a job or repeats it does what it was made to do, whatever the defaults are by then.

#include <nlohmann/json.hpp>

#include "protocol/job.h"
#include "server/store/store.h"

namespace photond {

/// Adds to each method that a request of a job or of a comparison names (its own, its reference's, its entries') the
/// parameters that it lacks: as MethodInfo::settings_before has them, else with the defaults of now. Whether there were
/// any.
bool complete_request(nlohmann::json& request);

/// Does so with all that the store keeps, in one transaction, where methods have other parameters than when it was last
/// done. References are found by the content that their requests now have.
void complete_requests(Store& store, const JobVocabulary& vocabulary);

}  // namespace photond
