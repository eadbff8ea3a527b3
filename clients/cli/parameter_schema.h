#pragma once
// A method's parameters as its JSON Schema (GET /v1/methods) declares them: help, checks and completion come from here.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace photond::cli {

struct Parameter {
    std::string name;  // as on the wire
    bool is_boolean = false;
    bool is_integer = false;
    bool is_number = false;  // integers too
    bool is_nullable = false;
    std::vector<std::string> words;  // the only values, when not empty
    std::optional<double> minimum, maximum;
    nlohmann::json default_value;  // null: none
    std::string unit;
    std::string text;

    /// indirect_bounces is --indirect-bounces.
    std::string option_name() const;
    /// What stands for the value in help: INT, NUMBER, true|false, direct|final.
    std::string value_name() const;
    /// "0 to 1024", "direct, final", "true, false".
    std::string range_text() const;
    /// The help line: meaning, unit, range and default.
    std::string help() const;
    /// The value of a text from the command line; "none" where a null is allowed. Throws Failure(Usage) with the value
    /// and the limit.
    nlohmann::json parse(const std::string& value) const;
};

/// In the order of the schema's `x-order`, else by name. `method`: one item of GET /v1/methods.
std::vector<Parameter> parameters_of(const nlohmann::json& method);

}  // namespace photond::cli
