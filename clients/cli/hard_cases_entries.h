#pragma once
// The columns of the table: methods and variants of them, each with the number of bounces a known answer is for.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "clients/cli/hard_cases_scenes.h"
#include "clients/cli/method_catalogue.h"

namespace photond::cli {

struct EntryOptions {
    std::vector<std::string> methods;  // only these of the daemon's; empty: all
    std::vector<std::string> entries;  // more, as "LABEL=METHOD[,NAME=VALUE...]"
    bool entries_only = false;         // none of the daemon's own
    std::string device;                // of entries that name none; empty: the daemon's default
    std::optional<uint64_t> photons;   // a pass, of entries whose method has them and that do not say
};

struct TableEntry {
    std::string label;
    nlohmann::json method;               // the wire's: name, and device and parameters where they are given
    std::optional<Parameter> bounces;    // indirect_bounces, or bounces; none: the method has neither
    std::vector<CatalogueLimit> limits;  // its method's
};

/// Every method of the daemon with its default parameters; in place of those with variants worth a column of their own,
/// these; then the options' entries. Throws Failure(Usage).
std::vector<TableEntry> entries_from(const MethodCatalogue& catalogue, const EntryOptions& options);

/// The method as a job asks for it, so that its indirect light has the bounces an answer is for.
struct BouncedMethod {
    nlohmann::json method;
    std::string note;            // how it falls short of the answer's; empty where it does not
    std::string not_applicable;  // why it cannot be asked; else empty
};
/// `bounces`: none for all. A method that must name a number is then given 8, or the most it can.
BouncedMethod with_bounces(const TableEntry& entry, std::optional<uint32_t> bounces);

/// What is known of why an approximation breaks a case, shown beside the measured figure; empty where nothing is.
std::string known_reason(const TableEntry& entry, const HardCase& hard_case);

}  // namespace photond::cli
