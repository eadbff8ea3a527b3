#pragma once
#include <array>
#include <string_view>

namespace photond {

/// Families of built-in scenes, which are listed only when a family is asked for.
inline constexpr std::array<std::string_view, 10> kSceneFamilies = {
    "hard-cases", "photon-splatting",     "details",   "caustics", "progressive", "small-vcm",
    "doors",      "visibility-filtering", "real-time", "moving"};

}  // namespace photond
