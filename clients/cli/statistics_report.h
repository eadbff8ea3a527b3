#pragma once
// The statistics of a finished job as tables.

#include <iosfwd>
#include <nlohmann/json.hpp>

namespace photond::cli {

/// `statistics`: the object of protocol.md, "Shapes"; what is null in it is left out.
void print_statistics(std::ostream& out, const nlohmann::json& statistics);

}  // namespace photond::cli
