#include "clients/cli/hard_cases_entries.h"

#include <algorithm>
#include <cmath>

#include "clients/cli/stop_options.h"
#include "clients/cli/units.h"

namespace photond::cli {

namespace {

using nlohmann::json;

constexpr uint32_t kManyBounces = 254;  // for answers with all of them, where a number must be named

const Parameter* find_parameter(const CatalogueMethod& method, const std::string& name) {
    const auto found = std::find_if(method.parameters.begin(), method.parameters.end(),
                                    [&](const Parameter& parameter) { return parameter.name == name; });
    return found == method.parameters.end() ? nullptr : &*found;
}

TableEntry complete(const CatalogueMethod& method, const std::string& label, json wire, const EntryOptions& options) {
    TableEntry entry{label, std::move(wire), std::nullopt, method.limits};
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
    const json by_default = catalogue.method_from(method.name);
    for (const CatalogueVariant& variant : method.variants) {
        json wire = by_default;
        wire["parameters"] = variant.parameters;
        entries.push_back(complete(method, method.name + ", " + variant.label, std::move(wire), options));
    }
    if (method.variants.empty()) entries.push_back(complete(method, method.name, by_default, options));
}

/// The entry has these settings. Variants name theirs, so that a default need not be looked up.
bool has_settings(const TableEntry& entry, const json& settings) {
    const json given = entry.method.value("parameters", json::object());
    return std::all_of(settings.items().begin(), settings.items().end(), [&](const auto& setting) {
        return given.contains(setting.key()) && given[setting.key()] == setting.value();
    });
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
    if (!bounces) asked.note = counted(number, "bounce") + ", where the answer has all";
    return asked;
}

std::string known_reason(const TableEntry& entry, const HardCase& hard_case) {
    const auto found = std::find_if(entry.limits.begin(), entry.limits.end(), [&](const CatalogueLimit& limit) {
        return has_settings(entry, limit.parameters) && hard_case.row.find(limit.row) != std::string::npos;
    });
    return found == entry.limits.end() ? "" : found->text;
}

}  // namespace photond::cli
