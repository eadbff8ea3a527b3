#pragma once
// The beauty of a film of few passes without their noise, for pictures to recognise a scene by
// (edge_avoiding_filter.h).

#include <string>
#include <vector>

#include "renderer/film/film.h"

namespace photond {

/// Names of the layers that filtered_beauty() goes by: a film to be filtered has them.
std::vector<std::string> guide_layers();

/// As resolve_beauty() gives it. What surfaces scatter is filtered; what lights send is not.
std::vector<float> filtered_beauty(const Film& film);

}  // namespace photond
