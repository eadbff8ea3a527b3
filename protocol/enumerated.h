#pragma once
// Names in a sentence. Standard library only.

#include <span>
#include <string>

namespace photond {

/// "a, b and c"; empty for none.
inline std::string enumerated(std::span<const std::string> names) {
    std::string text;
    for (size_t i = 0; i < names.size(); ++i) text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
    return text;
}

}  // namespace photond
