// photonctl methods|devices|status

#include <iostream>

#include "clients/cli/commands.h"
#include "clients/cli/text_table.h"
#include "clients/cli/units.h"

namespace photond::cli {

namespace {

using nlohmann::json;

std::string words_of(const json& list) {
    std::string text;
    if (list.is_array())
        for (const json& word : list) text += (text.empty() ? "" : ", ") + plain_text(word);
    return text;
}

/// {"cpu": true, "gpu": false} as "cpu".
std::string true_members(const json& object) {
    std::string text;
    if (object.is_object())
        for (const auto& [name, value] : object.items())
            if (value == true) text += (text.empty() ? "" : ", ") + printable(name);
    return text.empty() ? "no" : text;
}

void print_method(const Session& session, const json& method) {
    const std::string name = plain_text(method.value("name", json()));
    std::cout << session.bold(name) << ": " << plain_text(method.value("title", json())) << '\n';
    if (const json line = method.value("line", json()); line.is_string()) std::cout << "  " << plain_text(line) << '\n';
    TextTable facts({{""}, {""}});
    facts.add_row({"family", plain_text(method.value("family", json()))});
    facts.add_row({"devices", words_of(method.value("devices", json()))});
    facts.add_row({"same bits every time on", true_members(method.value("deterministic", json()))});
    facts.add_row({"can be cut and merged", method.value("mergeable", false) ? "yes" : "no"});
    facts.add_row({"layers on request", words_of(method.value("layers", json()))});
    for (const json& artefact : method.value("artefacts", json::array()))
        facts.add_row({"can keep", plain_text(artefact.value("description", json())) + ": " +
                                       plain_text(artefact.value("name", json())) + ", by " +
                                       plain_text(artefact.value("parameter", json()))});
    for (const json& source : method.value("sources", json::array())) facts.add_row({"source", plain_text(source)});
    facts.print(std::cout, "  ");

    TextTable table({{"parameter"}, {"values"}, {"unit"}, {"default"}, {""}});
    for (const Parameter& parameter : parameters_of(method))
        table.add_row({parameter.name, parameter.range_text(), parameter.unit,
                       parameter.default_value.is_null() ? "none" : plain_text(parameter.default_value),
                       parameter.text});
    if (table.empty()) return;
    std::cout << '\n';
    table.print(std::cout, "  ");
    std::cout << "\n  photonctl render SCENE --method " << name << " --set PARAMETER=VALUE\n";
}

ExitCode show_methods(Session& session, const std::string& name) {
    if (!name.empty()) {
        const json method = session.daemon().get(resource_path("methods", name));
        if (session.json_output)
            session.print_json(method);
        else
            print_method(session, method);
        return ExitCode::Ok;
    }
    TextTable table({{"NAME"}, {"TITLE"}, {"FAMILY"}, {"DEVICES"}, {"PARAMETERS", Align::Right}});
    const json methods = session.daemon().get("/v1/methods").at("items");
    for (const json& method : methods) {
        if (session.json_output) session.print_json(method);
        table.add_row({plain_text(method.value("name", json())), plain_text(method.value("title", json())),
                       plain_text(method.value("family", json())), words_of(method.value("devices", json())),
                       std::to_string(parameters_of(method).size())});
    }
    if (!session.json_output) table.print(std::cout);
    return ExitCode::Ok;
}

/// "ready", "not used", "failed, lacks shaderInt64".
std::string state_of(const json& device) {
    const std::string lacks = words_of(device.value("lacks", json::array()));
    if (!lacks.empty()) return plain_text(device.value("state", json())) + ", lacks " + lacks;
    return device.value("served", true) ? plain_text(device.value("state", json())) : "not used";
}

ExitCode show_devices(Session& session) {
    TextTable table({{"ID"}, {"STATE"}, {"NAME"}, {"DRIVER"}, {"MEMORY", Align::Right}, {"KIND"}});
    const json devices = session.daemon().get("/v1/devices").at("items");
    for (const json& device : devices) {
        if (session.json_output) session.print_json(device);
        const json memory = device.value("memory_bytes", json());
        const json kind = device.value("kind", json());
        // A processor is what it says; only a GPU can be one in name alone.
        const bool in_software = kind == "gpu" && device.value("software", json()) == true;
        table.add_row({plain_text(device.value("id", json())), state_of(device),
                       plain_text(device.value("name", json())), plain_text(device.value("driver", json())),
                       memory.is_number() ? human_bytes(memory.get<double>()) : "-",
                       plain_text(kind) + (in_software ? ", software" : "")});
    }
    if (session.json_output) return ExitCode::Ok;
    table.print(std::cout);
    for (const json& device : devices)
        if (!device.value("served", true) && device.value("lacks", json::array()).empty())
            session.remark("jobs can be rendered on " + plain_text(device.value("id", json())) +
                           " when the daemon is started with --devices naming it too");
    return ExitCode::Ok;
}

void add_status_rows(TextTable& table, const json& object, const std::string& prefix) {
    for (const auto& [key, value] : object.items()) {
        const std::string label = prefix + printable(key);
        if (value.is_object()) {
            add_status_rows(table, value, label + ".");
        } else if (value.is_array()) {
            for (size_t i = 0; i < value.size(); ++i) {
                if (value[i].is_object())
                    add_status_rows(table, value[i], label + "[" + std::to_string(i) + "].");
                else
                    table.add_row({label, plain_text(value[i])});
            }
        } else if (value.is_number() && key.ends_with("bytes")) {
            // "store.bytes" is the store's, "peak_bytes" the peak.
            const size_t unit = label.size() - std::string_view("bytes").size();
            table.add_row({label.substr(0, unit > 0 ? unit - 1 : 0), human_bytes(value.get<double>())});
        } else if (value.is_number() && key.ends_with("_seconds")) {
            table.add_row({label.substr(0, label.size() - 8), human_seconds(value.get<double>())});
        } else {
            table.add_row({label, plain_text(value)});
        }
    }
}

ExitCode show_status(Session& session) {
    const json status = session.daemon().get("/v1/status");
    if (session.json_output) {
        session.print_json(status);
        return ExitCode::Ok;
    }
    TextTable table({{""}, {""}});
    add_status_rows(table, status, "");
    table.print(std::cout);
    return ExitCode::Ok;
}

}  // namespace

void add_catalogue_commands(CLI::App& program, Session& session) {
    const auto name = std::make_shared<std::string>();
    CLI::App* methods = program.add_subcommand("methods", "Methods of light transport, or one with its parameters");
    methods->add_option("method", *name, "show this one")->type_name("METHOD");
    methods->callback([&session, name] { session.action = [&session, name] { return show_methods(session, *name); }; });

    program.add_subcommand("devices", "What the daemon renders on")->callback([&session] {
        session.action = [&session] { return show_devices(session); };
    });
    program.add_subcommand("status", "The daemon: version, uptime, queue, workers")->callback([&session] {
        session.action = [&session] { return show_status(session); };
    });
}

}  // namespace photond::cli
