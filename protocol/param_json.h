#pragma once
// Readers and writers of one parameter declaration: strict parse, echo, JSON Schema.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "protocol/param_info.h"

namespace photond {

/// Fills `params` from a JSON object; every fault found is appended to `faults` with a pointer below `pointer`.
void read_params(MethodParams& params, const nlohmann::json& source, const std::string& pointer,
                 std::vector<Fault>& faults);
/// Every parameter with its value now.
nlohmann::json params_to_json(MethodParams& params);
/// JSON Schema (2020-12) of the parameters, from a struct that holds the defaults.
nlohmann::json params_schema(MethodParams& defaults);

/// The known name nearest to a misspelt one (Damerau-Levenshtein at most a third of its length); empty when none is near.
std::string nearest_name(const std::string& wrong, const std::vector<std::string>& known);

}  // namespace photond
