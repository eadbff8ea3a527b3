#pragma once
// Sequences of the same frames as one HTML page that needs nothing beside itself: what they look like, and where they
// were measured against two references, their errors by frame.

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace photond {

struct ReportedSequence {
    nlohmann::json sequence;     // the object that GET /v1/sequences/{id} gives
    nlohmann::json errors;       // what its errors are, as GET /v1/sequences/{id}/errors has it; or null
    std::vector<uint8_t> sheet;  // PNG of frames beside each other; empty: there is none
};

struct SequenceReport {
    std::vector<ReportedSequence> sequences;  // at least one
    std::vector<std::string> notes;           // what is not shown, and why
    std::string version;                      // of the daemon
};

/// Every name is escaped; style, script and images are inline.
std::string sequence_html(const SequenceReport& report);

}  // namespace photond
