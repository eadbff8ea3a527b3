#include "clients/cli/hard_cases_entries.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "clients/cli/stop_options.h"
#include "clients/cli/units.h"

namespace photond::cli {

namespace {

using nlohmann::json;

/// Variants that have a column of their own wherever the daemon has the method and the values.
struct Variant {
    const char* method;
    const char* label;
    const char* settings;  // NAME=VALUE, separated by commas
};
constexpr std::array<Variant, 7> kVariants = {
    {{"photon_mapping", "photon_mapping, final", "gather=final"},
     {"photon_mapping", "photon_mapping, direct", "gather=direct"},
     {"photon_splatting", "photon_splatting, connect", "weighting=radiometric,estimator=connect"},
     {"photon_splatting", "photon_splatting, kernel", "weighting=radiometric,estimator=kernel"},
     {"photon_splatting", "photon_splatting, normalised", "weighting=normalised"},
     {"svo_many_lights", "svo_many_lights, rays", "visibility=rays"},
     {"svo_many_lights", "svo_many_lights, voxels", "visibility=svo"}}};

/// Why approximations break where they do (design: methods.md). `setting`: of the entry, or of the method's default.
struct Reason {
    const char* method;   // empty: any
    const char* setting;  // "NAME=VALUE"; empty: any
    const char* row;      // part of the row's name; empty: any
    const char* text;
};
constexpr std::array<Reason, 16> kReasons = {
    {{"", "", "dynamic range", "light paths start from lights by their power: next to none from the dim one"},
     {"photon_splatting", "weighting=normalised", "",
      "a weighted mean of the photons' colours: it discards how dense they are, so no exposure makes it converge"},
     {"photon_splatting", "estimator=kernel", "thin wall",
      "a depth map lights borderline depths, to a texel's width, which is more than the wall's"},
     {"photon_splatting", "", "furnace", "as many bounces as it was given here, where the answer has all of them"},
     {"photon_splatting", "", "glass", "beams from specular surfaces are as wide as a quarter of a splat"},
     {"photon_splatting", "estimator=kernel", "corner", "the kernel darkens within a radius of edges, by half there"},
     {"photon_splatting", "estimator=kernel", "facing", "the kernel darkens within a radius of edges, by half there"},
     {"photon_mapping", "", "thin wall", "a disc of the density estimate does not see a wall thinner than its radius"},
     {"photon_mapping", "", "corner", "lookups of the density estimate reach past the edge"},
     {"photon_mapping", "", "facing", "the density estimate loses light within its radius of edges"},
     {"photon_mapping", "", "caustic", "the density estimate smears light within its radius"},
     {"photon_mapping", "gather=direct", "sphere", "the density estimate takes a curved surface for a flat one"},
     {"svo_many_lights", "", "furnace", "as many bounces as it was given here, where the answer has all of them"},
     {"svo_many_lights", "visibility=svo", "thin wall",
      "where both ends lie within a voxel or two of a wall thinner than one, the voxels they are freed of are the "
      "wall"},
     {"reflective_shadow_maps", "", "", "nobody asks what stands between, and what the clamp takes is not given back"},
     {"imperfect_shadow_maps", "", "",
      "maps of a few texels, by points instead of triangles, and what the clamp takes is not given back"}}};

constexpr uint32_t kManyBounces = 8;  // for answers with all of them, where a number must be named

const Parameter* find_parameter(const CatalogueMethod& method, const std::string& name) {
    const auto found = std::find_if(method.parameters.begin(), method.parameters.end(),
                                    [&](const Parameter& parameter) { return parameter.name == name; });
    return found == method.parameters.end() ? nullptr : &*found;
}

/// The method has every parameter of the variant, with that value among its words.
bool offers(const CatalogueMethod& method, const Variant& variant) {
    if (method.name != variant.method) return false;
    for (const std::string& setting : split(variant.settings, ',')) {
        const auto [name, value] = key_and_value(setting, variant.label);
        const Parameter* parameter = find_parameter(method, name);
        if (!parameter || std::find(parameter->words.begin(), parameter->words.end(), value) == parameter->words.end())
            return false;
    }
    return true;
}

TableEntry complete(const CatalogueMethod& method, const std::string& label, json wire, const EntryOptions& options) {
    TableEntry entry{label, std::move(wire), std::nullopt};
    for (const char* name : {"indirect_bounces", "bounces"})
        if (const Parameter* parameter = find_parameter(method, name); parameter && !entry.bounces)
            entry.bounces = *parameter;
    const json given = entry.method.value("parameters", json::object());
    if (entry.bounces && given.contains(entry.bounces->name))
        throw Failure(ExitCode::Usage,
                      "--entry " + printable(label) + " sets " + entry.bounces->name + ", which each case decides");
    if (options.photons && find_parameter(method, "photons") && !given.contains("photons"))
        entry.method["parameters"]["photons"] = *options.photons;
    return entry;
}

void add_method(std::vector<TableEntry>& entries, const MethodCatalogue& catalogue, const CatalogueMethod& method,
                const EntryOptions& options) {
    const size_t before = entries.size();
    for (const Variant& variant : kVariants)
        if (offers(method, variant))
            entries.push_back(
                complete(method, variant.label, catalogue.method_from(method.name + "," + variant.settings), options));
    if (entries.size() == before)
        entries.push_back(complete(method, method.name, catalogue.method_from(method.name), options));
}

/// The entry has that setting. Variants name theirs, so that a default need not be looked up.
bool has_setting(const TableEntry& entry, const std::string& setting) {
    if (setting.empty()) return true;
    const auto [name, value] = key_and_value(setting, "setting");
    const json given = entry.method.value("parameters", json::object());
    return given.contains(name) && given[name] == value;
}

}  // namespace

std::vector<TableEntry> entries_from(const MethodCatalogue& catalogue, const EntryOptions& options) {
    std::vector<TableEntry> entries;
    for (const std::string& name : options.methods) (void)catalogue.method(name);  // throws for one that is not there
    for (const CatalogueMethod& method : catalogue.methods()) {
        const bool wanted = options.methods.empty() ? method.runs_on(options.device)
                                                    : std::find(options.methods.begin(), options.methods.end(),
                                                                method.name) != options.methods.end();
        if (wanted && !options.entries_only) add_method(entries, catalogue, method, options);
    }
    for (const std::string& text : options.entries) {
        const json entry = catalogue.entry_from(text);
        entries.push_back(complete(catalogue.method(entry.at("method").at("name").get<std::string>()),
                                   entry.at("label").get<std::string>(), entry.at("method"), options));
    }
    for (size_t i = 0; i < entries.size(); ++i)
        for (size_t j = 0; j < i; ++j)
            if (entries[i].label == entries[j].label)
                throw Failure(ExitCode::Usage, "two entries are called " + printable(entries[i].label));
    if (entries.empty()) throw Failure(ExitCode::Usage, "which methods? --entries-only needs at least one --entry");
    return entries;
}

BouncedMethod with_bounces(const TableEntry& entry, std::optional<uint32_t> bounces) {
    BouncedMethod asked{entry.method, "", ""};
    if (!entry.bounces) {
        if (bounces) asked.not_applicable = "it has no number of bounces to set";
        return asked;
    }
    const Parameter& parameter = *entry.bounces;
    if (!bounces && parameter.is_nullable) {
        asked.method["parameters"][parameter.name] = nullptr;
        return asked;
    }
    const double most = parameter.maximum.value_or(HUGE_VAL);
    if (bounces && *bounces > most) {
        asked.not_applicable =
            "it does at most " + human_number(most) + " bounces, the answer is for " + std::to_string(*bounces);
        return asked;
    }
    const auto number = bounces.value_or(static_cast<uint32_t>(std::min<double>(kManyBounces, most)));
    asked.method["parameters"][parameter.name] = number;
    if (!bounces) asked.note = std::to_string(number) + " bounces, where the answer has all";
    return asked;
}

std::string known_reason(const TableEntry& entry, const HardCase& hard_case) {
    const auto found = std::find_if(kReasons.begin(), kReasons.end(), [&](const Reason& reason) {
        return (*reason.method == '\0' || entry.method.at("name") == reason.method) &&
               has_setting(entry, reason.setting) && hard_case.row.find(reason.row) != std::string::npos;
    });
    return found == kReasons.end() ? "" : found->text;
}

}  // namespace photond::cli
