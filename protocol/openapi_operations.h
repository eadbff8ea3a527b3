#pragma once
// The paths of the OpenAPI document: what can be asked, what each takes and answers.

#include <nlohmann/json.hpp>

#include "protocol/openapi.h"

namespace photond {

/// "paths" of the document: an object by path and lower-case method; bodies refer to /components/schemas by name.
nlohmann::json openapi_paths(const ApiVocabulary& vocabulary);

}  // namespace photond
