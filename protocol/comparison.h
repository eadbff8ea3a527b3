#pragma once
// A comparison of methods as the wire says it (protocol.md, "Comparisons"): what all its jobs have in common, and the
// entries, sweeps and seeds that set them apart.

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "protocol/job.h"

namespace photond {

inline constexpr size_t kMaxComparisonJobs = 1000;

/// One job of a comparison. Jobs of the same entry and parameters differ by their seed: together they are a row.
struct PlannedJob {
    size_t entry = 0;           // index into the entries
    std::string label;          // the entry's
    nlohmann::json parameters;  // object: those the sweep gave, by name; empty without one
    uint64_t seed = 1;
    JobRequest request;
};

struct ComparisonRequest {
    /// Rows in the order of the entries, sweep values in the order given (the last parameter varying fastest), and the
    /// seeds of a row beside each other.
    std::vector<PlannedJob> jobs;
    std::vector<std::string> metrics;  // of the tables; the first one decides the Pareto front
    nlohmann::json echo;  // the request as understood, every default filled in; parsing it gives the same request
};

/// Reads a body: {scene, camera, image, reference, entries: [{label, method, sweep}], stop, metrics, seeds, layers,
/// labels, priority, environment, glass, time}. Each job is read as parse_job_request() reads it, so that the same
/// rules hold. Throws photond::Error with all faults, each with its pointer into this body
/// ("/entries/1/sweep/photons/2"). A reference is required unless every metric is estimated; labels of entries are
/// distinct; at most kMaxComparisonJobs jobs.
/// Defaults: metrics ["relative_mse"], seeds [1], label the method's name.
ComparisonRequest parse_comparison_request(const nlohmann::json& body, const JobVocabulary& vocabulary);

}  // namespace photond
