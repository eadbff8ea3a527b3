#pragma once
// The hard cases: small scenes that each strain one assumption of a renderer, with what must come out. They are
// built-in scenes named "hard-case/NAME"; what can be no scene is named here with the test that does it.

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/core/geometry.h"

namespace photond {

struct Scene;

/// What a layer's mean radiance over a region of the image must be.
struct KnownCheck {
    enum class Relation : uint8_t {
        Equals,     // `value`
        AtMost,     // `value`
        SameAs,     // the same layer of the scene `same_as` by the same method, times `scale`
        Reference,  // what path tracing gives
        Zero,       // exactly 0 in every pixel
        Finite,     // no NaN, no infinity, nothing negative
    };
    Relation relation = Relation::Finite;
    std::string_view layer = "beauty";               // or "direct", "indirect", "emitted"
    std::array<double, 4> region{0, 0, 1, 1};        // x0, y0, x1, y1: fractions of the image, row 0 at the top
    std::optional<dvec3> value = std::nullopt;       // mean over the region [W m^-2 sr^-1]
    std::string same_as = {};                        // a scene's whole name
    double scale = 1;                                // of the other scene's radiance
    std::optional<uint32_t> bounces = std::nullopt;  // of the indirect layer; none: unlimited
    double tolerance = 0;                            // relative error of the answer itself, not of a measurement
};

/// Name of a relation on the wire.
std::string_view relation_name(KnownCheck::Relation relation);

struct KnownAnswer {
    std::string row;      // of the table of hard cases; several scenes make one
    std::string strains;  // what is hard about it
    std::string text;     // one line: what must come out
    std::vector<KnownCheck> checks;
    uint32_t passes = 64;  // suggested, with the size: enough for an error of about a percent by path tracing
    Size2 size{32, 32};
};

struct HardCase {
    std::string name;  // "hard-case/..."
    KnownAnswer answer;
    std::function<Scene()> make = {};  // not finished yet (finish_scene); empty where a test takes the scene's place
    std::string test = {};             // that test's program; empty for a scene
};

/// All, rows together in the table's order.
std::span<const HardCase> hard_cases();
/// Of a scene; none for any other name.
const HardCase* find_hard_case(std::string_view scene_name);

// The table's subjects, one file each.
void add_furnace_cases(std::vector<HardCase>& cases);     // hard_case_furnace.cpp: energy balance
void add_patch_cases(std::vector<HardCase>& cases);       // hard_case_patches.cpp: form factors
void add_room_cases(std::vector<HardCase>& cases);        // hard_case_room.cpp: one room in many guises; walls
void add_light_cases(std::vector<HardCase>& cases);       // hard_case_lights.cpp: grazing, range, number
void add_degenerate_cases(std::vector<HardCase>& cases);  // hard_case_degenerate.cpp: nothing to divide by; odd cameras
void add_glass_cases(std::vector<HardCase>& cases);  // hard_case_glass.cpp: caustics, Snell at the limit, near-deltas

}  // namespace photond
