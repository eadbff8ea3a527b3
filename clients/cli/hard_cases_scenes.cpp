#include "clients/cli/hard_cases_scenes.h"

#include <algorithm>
#include <cmath>

#include "clients/cli/failure.h"
#include "clients/cli/units.h"
#include "protocol/nearest_name.h"

namespace photond::cli {

namespace {

using nlohmann::json;

constexpr const char* kFamily = "hard-case/";
constexpr uint32_t kSmallestEdge = 8;  // pixels
constexpr double kWholePixel = 1e-6;   // how near a region's edge lies to a pixel's

/// A member that is null or absent counts as `otherwise`.
template <class T>
T value_or(const json& object, const char* key, T otherwise) {
    const auto found = object.find(key);
    return found == object.end() || found->is_null() ? otherwise : found->get<T>();
}

HardCheck check_from(const json& wire) {
    HardCheck check;
    const std::string relation = wire.at("relation").get<std::string>();
    const std::optional<Relation> known = relation_from(relation);
    if (!known)
        throw Failure("a hard case has a check '" + printable(relation) + "' unknown to this photonctl", nullptr);
    check.relation = *known;
    check.layer = value_or<std::string>(wire, "layer", "beauty");
    const auto region = value_or<std::array<double, 4>>(wire, "region", {0, 0, 1, 1});
    check.region = {region[0], region[1], region[2], region[3]};
    if (const json value = wire.value("value", json()); !value.is_null()) check.value = value.get<Radiance>();
    check.other_scene = value_or<std::string>(wire, "scene", "");
    check.scale = value_or(wire, "scale", 1.0);
    if (const json bounces = wire.value("bounces", json()); !bounces.is_null()) check.bounces = bounces.get<uint32_t>();
    check.tolerance = value_or(wire, "tolerance", 0.0);
    const bool needs_value = check.relation == Relation::Equals || check.relation == Relation::AtMost;
    if (needs_value && !check.value) throw Failure("a hard case's check '" + relation + "' has no value", nullptr);
    if (check.relation == Relation::SameAs && check.other_scene.empty())
        throw Failure("a hard case's check 'same_as' names no scene", nullptr);
    return check;
}

bool contains_ignoring_case(const std::string& text, const std::string& part) {
    const auto lower = [](unsigned char c) { return c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c; };
    return std::search(text.begin(), text.end(), part.begin(), part.end(), [&](char a, char b) {
               return lower(static_cast<unsigned char>(a)) == lower(static_cast<unsigned char>(b));
           }) != text.end();
}

bool is_meant(const HardCase& hard_case, const std::string& name) {
    if (hard_case.scene == name || hard_case.name() == name) return true;
    return !name.empty() && contains_ignoring_case(hard_case.row, name);
}

bool whole(double pixels) { return std::abs(pixels - std::round(pixels)) < kWholePixel; }

bool has_whole_pixels(const ImageRegion& region, ImageSize size) {
    return whole(region.x0 * size.width) && whole(region.x1 * size.width) && whole(region.y0 * size.height) &&
           whole(region.y1 * size.height);
}

}  // namespace

std::string HardCase::name() const {
    if (scene.empty()) return row;
    return scene.starts_with(kFamily) ? scene.substr(std::string(kFamily).size()) : scene;
}

HardCase hard_case_from(const json& scene) {
    const json& answer = scene.at("known_answer");
    HardCase found;
    found.row = answer.at("case").get<std::string>();
    found.test = value_or<std::string>(answer, "test", value_or<std::string>(scene, "test", ""));
    found.scene = found.test.empty() ? scene.at("name").get<std::string>() : "";
    found.strains = value_or<std::string>(answer, "strains", "");
    found.text = value_or<std::string>(answer, "text", "");
    if (!found.test.empty()) return found;
    for (const json& check : answer.at("checks")) found.checks.push_back(check_from(check));
    found.passes = answer.at("passes").get<uint32_t>();
    found.size = {answer.at("width").get<uint32_t>(), answer.at("height").get<uint32_t>()};
    found.not_applicable = value_or<std::map<std::string, std::string>>(answer, "not_applicable", {});
    return found;
}

std::vector<HardCase> hard_cases_of(DaemonClient& daemon) {
    const std::string path = "/v1/scenes?family=hard-cases";
    std::vector<HardCase> cases;
    for (const json& scene : daemon.list(path, SIZE_MAX)) cases.push_back(hard_case_from(scene));
    const json tests = daemon.get(path + "&limit=1").value("tests", json::array());
    for (const json& test : tests) {
        HardCase covered = hard_case_from(test);
        const auto last =
            std::find_if(cases.rbegin(), cases.rend(), [&](const HardCase& one) { return one.row == covered.row; });
        cases.insert(last == cases.rend() ? cases.end() : last.base(), std::move(covered));
    }
    return cases;
}

std::vector<HardCase> chosen_cases(const std::vector<HardCase>& all, const std::vector<std::string>& names) {
    for (const std::string& name : names) {
        if (std::any_of(all.begin(), all.end(), [&](const HardCase& one) { return is_meant(one, name); })) continue;
        std::vector<std::string> known;
        known.reserve(all.size());
        for (const HardCase& one : all) known.push_back(one.name());
        const std::string near = nearest_name(name, known);
        throw Failure(ExitCode::Usage, "there is no hard case " + printable(name),
                      near.empty() ? "photonctl hard-cases --list lists them" : "did you mean " + near + "?");
    }
    std::vector<HardCase> chosen;
    for (const HardCase& one : all)
        if (names.empty() ||
            std::any_of(names.begin(), names.end(), [&](const auto& name) { return is_meant(one, name); }))
            chosen.push_back(one);
    return chosen;
}

ImageSize small_image(const HardCase& hard_case) {
    for (const uint32_t divisor : {4U, 3U, 2U}) {
        const ImageSize smaller{hard_case.size.width / divisor, hard_case.size.height / divisor};
        const bool divides = smaller.width * divisor == hard_case.size.width &&
                             smaller.height * divisor == hard_case.size.height &&
                             std::min(smaller.width, smaller.height) >= kSmallestEdge;
        const bool keeps_regions =
            std::all_of(hard_case.checks.begin(), hard_case.checks.end(), [&](const HardCheck& check) {
                return has_whole_pixels(check.region, smaller) || !has_whole_pixels(check.region, hard_case.size);
            });
        if (divides && keeps_regions) return smaller;
    }
    return hard_case.size;
}

}  // namespace photond::cli
