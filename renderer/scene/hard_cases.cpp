#include "renderer/scene/hard_cases.h"

namespace photond {

namespace {

constexpr std::string_view kRelationNames[] = {"equals", "at_most", "same_as", "reference", "zero", "finite"};

std::vector<HardCase> make_hard_cases() {
    std::vector<HardCase> cases;
    add_furnace_cases(cases);
    add_patch_cases(cases);
    add_room_cases(cases);
    add_light_cases(cases);
    add_degenerate_cases(cases);
    add_glass_cases(cases);
    return cases;
}

}  // namespace

std::string_view relation_name(KnownCheck::Relation relation) { return kRelationNames[static_cast<size_t>(relation)]; }

std::span<const HardCase> hard_cases() {
    static const std::vector<HardCase> kCases = make_hard_cases();
    return kCases;
}

const HardCase* find_hard_case(std::string_view scene_name) {
    for (const HardCase& hard_case : hard_cases())
        if (hard_case.make && hard_case.name == scene_name) return &hard_case;
    return nullptr;
}

}  // namespace photond
