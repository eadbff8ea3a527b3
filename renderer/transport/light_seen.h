#pragma once
// What is known of a light source at a point before a shadow ray is traced.

#include <cstdint>

namespace photond {

enum class LightSeen : uint8_t {
    Whole,    // all of it: no shadow ray is needed
    Nothing,  // none of it: its light need not be asked for
    Unknown,  // a border, or nothing is known: trace the ray
};

}  // namespace photond
