#pragma once
// Readers and writers of one parameter declaration: strict parse, echo, JSON Schema.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "protocol/param_info.h"

namespace photond {

/// Fills `params` from a JSON object; every fault found is appended to `faults` with a pointer below `pointer`. Where
/// each field is good, params.check() has its say too.
void read_params(MethodParams& params, const nlohmann::json& source, const std::string& pointer,
                 std::vector<Fault>& faults);
/// Every parameter with its value now. read_params() of it gives the same values, bit by bit.
nlohmann::json params_to_json(MethodParams& params);
/// JSON Schema (2020-12) of the parameters, from a struct that holds the defaults. Beside what the standard knows:
/// `x-order`, the names as declared, and `x-groups`, the titles of the groups; of a parameter `x-unit` and `x-group`.
nlohmann::json params_schema(MethodParams& defaults);

/// The shortest decimal that reads back as the same float, as a double: 0.1f gives 0.1, not 0.10000000149.
double shortest_double(float value);
/// A number as a person would write it: "1e+09", "0.5", "64".
std::string number_text(double value);
/// A JSON value as it may stand in a message: cut after some sixty characters.
std::string value_text(const nlohmann::json& value);
/// " (did you mean \"NAME\"?)" with the nearest known name; empty when none is near.
std::string did_you_mean(const std::string& wrong, const std::vector<std::string>& known);

}  // namespace photond
