#pragma once
#include <nlohmann/json.hpp>

#include "renderer/scene/hard_cases.h"

namespace photond {

/// The member `known_answer` of a scene (openapi.h); null for a scene that is no hard case.
nlohmann::json known_answer_of(const std::string& scene_name);

/// The hard cases that are no scenes: name, known answer (without checks) and the program that tests it.
nlohmann::json hard_cases_tested_elsewhere();

}  // namespace photond
