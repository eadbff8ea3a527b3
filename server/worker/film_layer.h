#pragma once
// A layer of a film by its name, as requests of the helper name it.

#include <string>

#include "protocol/error.h"
#include "renderer/film/film.h"

namespace photond {

/// Throws ErrorCode::UnknownName where the film has no layer of that name.
inline const LayerInfo& film_layer(const Film& film, const std::string& name) {
    const LayerInfo* info = find_layer(name);
    if (!info || !film.layers().has(info->layer))
        throw Error(ErrorCode::UnknownName, "/layer", "the film has no layer \"" + name + "\"");
    return *info;
}

}  // namespace photond
