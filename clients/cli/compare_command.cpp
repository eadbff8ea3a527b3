// photonctl compare SCENE, photonctl compare --preset NAME

#include <algorithm>
#include <charconv>
#include <iostream>

#include "clients/cli/commands.h"
#include "clients/cli/compare_memory.h"
#include "clients/cli/compare_presets.h"
#include "clients/cli/comparison_follower.h"
#include "clients/cli/method_catalogue.h"
#include "clients/cli/request_options.h"
#include "clients/cli/units.h"

namespace photond::cli {

namespace {

using nlohmann::json;

struct CompareOptions {
    RequestOptions request;
    std::string preset, device;
    std::optional<uint32_t> reference_passes;
    std::vector<std::string> entries, sweeps;
    std::vector<uint64_t> seeds;
    bool no_wait = false;
    WaitOptions wait;
    ReportOutputs outputs;
};

/// "LABEL:PARAMETER=V1,V2,..." into the entry of that label.
void put_sweep(json& entries, const MethodCatalogue& catalogue, const std::string& text) {
    const size_t colon = text.rfind(':', text.find('='));
    if (colon == std::string::npos || text.find('=') == std::string::npos)
        throw Failure(ExitCode::Usage, "--sweep " + printable(text) + " is not LABEL:PARAMETER=VALUE,VALUE");
    const std::string label = text.substr(0, colon);
    const auto entry = std::find_if(entries.begin(), entries.end(),
                                    [&](const json& candidate) { return candidate.value("label", "") == label; });
    if (entry == entries.end())
        throw Failure(ExitCode::Usage, "--sweep " + printable(text) + ": no --entry has the label " + printable(label));
    const auto [name, values] = key_and_value(text.substr(colon + 1), "--sweep");
    const Parameter& parameter = catalogue.method(entry->at("method").at("name").get<std::string>()).parameter(name);
    json& swept = (*entry)["sweep"][name];
    for (const std::string& value : split(values, ',')) swept.push_back(parameter.parse(value));
}

/// The comparison but for its scene, environment and reference, which may have to be sent first.
json build_request(Session& session, const CompareOptions& options) {
    json request = start_request(options.request);
    if (!options.entries.empty() || !options.sweeps.empty()) {
        const MethodCatalogue catalogue(session.daemon(), options.device);
        if (!options.entries.empty()) request["entries"] = json::array();
        for (const std::string& entry : options.entries) request["entries"].push_back(catalogue.entry_from(entry));
        if (!request.contains("entries") || !request["entries"].is_array())
            throw Failure(ExitCode::Usage, "--sweep belongs to an --entry");
        for (const std::string& sweep : options.sweeps) put_sweep(request["entries"], catalogue, sweep);
    }
    if (!request.contains("entries"))
        throw Failure(ExitCode::Usage, "what is compared? at least one --entry is needed",
                      "for example --entry path_tracing --entry 'photon mapping=photon_mapping,photons=200000'");
    if (!request.contains("stop"))
        throw Failure(ExitCode::Usage, "when does each job end? --seconds, --passes or --target is needed",
                      "for example --seconds 30");
    if (!options.seeds.empty()) request["seeds"] = options.seeds;
    return request;
}

/// The preset as options: what the command line says stands, its entries and sweeps come after the preset's.
CompareOptions with_preset(const CompareOptions& given, const ComparePreset& preset) {
    CompareOptions options = given;
    const auto put_first = [](std::vector<std::string>& list, const std::vector<std::string_view>& first) {
        list.insert(list.begin(), first.begin(), first.end());
    };
    put_first(options.entries, preset.entries);
    put_first(options.sweeps, preset.sweeps);
    RequestOptions& request = options.request;
    request.width = request.width.value_or(preset.width);
    request.height = request.height.value_or(preset.height);
    if (request.metrics.empty()) put_first(request.metrics, preset.metrics);
    if (!request.stop.any()) request.stop.seconds = preset.seconds;
    if (request.reference.empty())
        request.reference = std::string(preset.reference) + ":" +
                            std::to_string(options.reference_passes.value_or(preset.reference_passes));
    return options;
}

CompareOptions for_scene(CompareOptions options, std::string_view scene) {
    options.request.scene = scene;
    for (std::string& page : options.outputs.html) page = of_scene(page, scene);
    options.outputs.csv = of_scene(options.outputs.csv, scene);
    options.outputs.json = of_scene(options.outputs.json, scene);
    // The same key twice would be the same submission.
    if (!options.request.idempotency_key.empty()) options.request.idempotency_key += "-" + std::string(scene);
    return options;
}

ExitCode compare_one(Session& session, const CompareOptions& options, const ComparePreset* preset) {
    json request = build_request(session, options);
    send_parts(session, request, options.request);
    const json accepted = submit(session, "/v1/comparisons", request, options.request.idempotency_key);
    const std::string id = accepted.at("id").get<std::string>();
    if (!options.no_wait) {
        const ExitCode code = finish_comparison(session, id, options.wait, options.outputs, false);
        if (session.json_output || !preset) return code;
        const json comparison = session.daemon().get(resource_path("comparisons", id));
        print_published(std::cout, structures_of(session.daemon(), comparison), *preset);
        return code;
    }
    if (session.json_output)
        session.print_json(accepted);
    else
        std::cout << id << '\n';
    session.remark("watch it: photonctl comparisons watch " + id);
    return ExitCode::Ok;
}

ExitCode compare(Session& session, const CompareOptions& options) {
    options.outputs.check();
    if (options.no_wait && (options.outputs.any() || options.wait.timeout_seconds > 0))
        throw Failure(ExitCode::Usage, "--no-wait saves nothing and needs no --timeout",
                      "photonctl comparisons fetch saves it later");
    if (options.preset.empty()) {
        if (options.reference_passes)
            throw Failure(ExitCode::Usage,
                          "--reference-passes belongs to --preset; --reference METHOD:PASSES says both");
        return compare_one(session, options, nullptr);
    }
    const ComparePreset& preset = compare_preset(options.preset);
    if (options.reference_passes && !options.request.reference.empty())
        throw Failure(ExitCode::Usage, "--reference and --reference-passes exclude each other");
    const CompareOptions whole = with_preset(options, preset);
    if (!whole.request.scene.empty()) return compare_one(session, whole, &preset);
    ExitCode worst = ExitCode::Ok;
    for (const std::string_view scene : preset.scenes) {
        const ExitCode code = compare_one(session, for_scene(whole, scene), &preset);
        if (worst == ExitCode::Ok) worst = code;
    }
    return worst;
}

}  // namespace

void add_compare_command(CLI::App& program, Session& session) {
    CLI::App* command = program.add_subcommand(
        "compare", "Which method reaches which error first on a scene: render with each, measure, report");
    const auto options = std::make_shared<CompareOptions>();
    const auto add_list = [&](const char* name, std::vector<std::string>& value, const char* text, const char* type) {
        command->add_option(name, value, text)->type_name(type)->expected(1)->take_all();
    };
    add_source_options(*command, options->request);
    command
        ->add_option("--preset", options->preset,
                     "an experiment by its name, on its own scenes (a report each, with the scene in its name) unless "
                     "SCENE is given; other options change it. 'help' lists them")
        ->type_name("NAME");
    command->add_option("--reference-passes", options->reference_passes, "of the preset's reference")
        ->type_name("INT")
        ->check(CLI::Range(1, 1'000'000'000).description(""));
    add_list(
        "--entry", options->entries,
        "what is compared, once for each: 'photon mapping=photon_mapping,photons=200000'; METHOD@DEVICE says where",
        kEntryKind);
    command->add_option("--device", options->device, "where entries render that name none; default: cpu")
        ->type_name("DEVICE");
    add_list("--sweep", options->sweeps, "try an entry with each of these values; several sweeps of one entry multiply",
             "LABEL:NAME=VALUE,VALUE");
    command->add_option("--seeds", options->seeds, "repeat every job with each of these, for error bars; default: 1")
        ->type_name("INT,INT")
        ->expected(1)
        ->delimiter(',')
        ->take_all();
    add_stop_options(*command, options->request.stop, "stop each job after this many samples a pixel");
    add_image_options(*command, options->request, {});
    add_report_options(*command, options->outputs);
    command->add_flag("--no-wait", options->no_wait, "print the comparison's id and leave");
    add_wait_options(*command, options->wait);
    add_view_options(*command, options->request);
    command->callback(
        [&session, options] { session.action = [&session, options] { return compare(session, *options); }; });
}

}  // namespace photond::cli
