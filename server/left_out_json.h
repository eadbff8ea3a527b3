#pragma once
// Kinds of path that images leave out, as JSON: `left_out` of statistics and dry runs.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "renderer/frame/left_out.h"

namespace photond {

/// [{"kind", "text", "most_bounces"}]; most_bounces is null but of further_bounces.
nlohmann::json to_json(const PathsLeftOut& left_out);

/// What a method leaves out; none for a name that is not known. What is no parameter of it is not looked at.
std::optional<PathsLeftOut> left_out_by(const std::string& method, const nlohmann::json& parameters,
                                        const Needs& needs);

/// Of a scene's summary, or of statistics: `needs` and, beside them, `least_glossy_alpha`.
Needs needs_read(const nlohmann::json& object);

/// What a job left out, by its statistics; by its method where they are of before they said it. None where neither
/// tells. `method`: of its request.
std::optional<PathsLeftOut> left_out_of_job(const nlohmann::json& statistics, const nlohmann::json& method);

}  // namespace photond
