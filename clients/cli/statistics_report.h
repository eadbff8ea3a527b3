#pragma once
// The statistics of a finished job as tables.

#include <iosfwd>
#include <nlohmann/json.hpp>

namespace photond::cli {

/// `statistics`: the object of protocol.md, "Shapes"; what is null in it is left out.
void print_statistics(std::ostream& out, const nlohmann::json& statistics);

/// A table of errors with the reference's own noise beside them. `error`: metric to number, array or null;
/// `reference_error` and `intervals`: likewise, or null.
void print_errors(std::ostream& out, const nlohmann::json& error, const nlohmann::json& reference_error,
                  const nlohmann::json& intervals = nullptr);

}  // namespace photond::cli
