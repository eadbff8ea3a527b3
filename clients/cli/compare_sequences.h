#pragma once
// Entries of a comparison on a moving scene: a sequence each, measured against two of a reference method.

#include <nlohmann/json.hpp>
#include <string>

#include "clients/cli/comparison_follower.h"
#include "clients/cli/session.h"

namespace photond::cli {

struct SequenceReports {
    ReportOutputs outputs;  // pages and JSON
    std::string videos;     // folder; empty: none are saved
};

/// `request`: a comparison's with `entries` and `stop`, its scene sent, with a sequence's `frames`, `fps` and
/// `animation`. `reference`: the method of the two references and their passes, {"method", "passes"}, whose seeds lie
/// apart. Sequences are rendered one after another, as they are submitted. Prints a table, with --json the report.
ExitCode compare_sequences(Session& session, const nlohmann::json& request, const nlohmann::json& reference,
                           const WaitOptions& wait, const SequenceReports& reports);

}  // namespace photond::cli
