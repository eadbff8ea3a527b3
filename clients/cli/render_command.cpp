// photonctl render SCENE

#include <iostream>
#include <map>

#include "clients/cli/commands.h"
#include "clients/cli/job_view.h"
#include "clients/cli/method_catalogue.h"
#include "clients/cli/request_options.h"
#include "clients/cli/statistics_report.h"
#include "clients/cli/units.h"

namespace photond::cli {

namespace {

using nlohmann::json;

constexpr uint32_t kDefaultPasses = 64;

/// What the command line says of one job, besides what a comparison says as well.
struct RenderOptions {
    RequestOptions request;
    std::string method, device;
    std::optional<uint32_t> first_pass;
    std::optional<uint64_t> seed;
    std::vector<std::string> settings;
    std::map<std::string, std::string> parameters;  // by wire name, from --parameter-name options
    bool no_wait = false;
    bool dry_run = false;
    WaitOptions wait;
    JobOutputs outputs;
};

/// Parameters of the command line over those of the request; every name and value checked against the schema.
void put_parameters(json& parameters, const RenderOptions& options, const CatalogueMethod& method) {
    std::map<std::string, std::string> given = options.parameters;
    if (!options.outputs.photon_map.empty()) given.emplace("keep_photon_map", "true");
    for (const std::string& setting : options.settings) {
        const auto [name, value] = key_and_value(setting, "--set");
        given.insert_or_assign(name, value);
    }
    for (const auto& [name, text] : given) parameters[name] = method.parameter(name).parse(text);
}

/// What only a job says, not a comparison.
void put_method(json& request, const RenderOptions& options, const CatalogueMethod& known) {
    json& method = object_in(request, "method");
    method["name"] = known.name;
    if (!options.device.empty()) method["device"] = options.device;
    put_parameters(object_in(method, "parameters"), options, known);
    if (!request.contains("stop") || request["stop"].empty()) request["stop"] = {{"passes", kDefaultPasses}};
    if (options.seed) request["seed"] = *options.seed;
    if (options.first_pass) request["first_pass"] = *options.first_pass;
}

ExitCode print_estimate(Session& session, const json& request) {
    const json estimate = session.daemon().send("POST", "/v1/jobs?dry_run=true", request, Repeat::Safely);
    if (session.json_output) {
        session.print_json(estimate);
        return ExitCode::Ok;
    }
    const json seconds = estimate.value("seconds", json()), on_device = estimate.value("device_memory_bytes", json());
    std::cout << "memory " << human_bytes(estimate.at("memory_bytes").get<double>());
    if (on_device.is_number()) std::cout << ", and " << human_bytes(on_device.get<double>()) << " of the GPU's";
    std::cout << "\ntime   "
              << (seconds.is_number() ? human_seconds(seconds.get<double>())
                                      : "not known: the daemon has rendered nothing with this method yet")
              << '\n';
    for (const json& kind : estimate.value("left_out", json::array()))
        std::cout << "left out: " << plain_text(kind.at("text")) << '\n';
    for (const json& warning : estimate.value("warnings", json::array()))
        std::cout << "warning: " << plain_text(warning) << '\n';
    return ExitCode::Ok;
}

/// The method that renders: the command line's, else that of a request from standard input, which nobody had read when
/// the options were made.
CatalogueMethod method_of(Session& session, const RenderOptions& options, const CatalogueMethod& known,
                          const json& request) {
    if (!options.method.empty() || !request.contains("method") || !request["method"].is_object()) return known;
    const std::string name = request["method"].value("name", known.name);
    return name == known.name ? known : MethodCatalogue(session.daemon()).method(name);
}

ExitCode render(Session& session, const RenderOptions& options, const CatalogueMethod& known) {
    options.outputs.check();
    if (options.no_wait && (options.outputs.any() || options.wait.timeout_seconds > 0))
        throw Failure(ExitCode::Usage, "--no-wait saves nothing and needs no --timeout",
                      "photonctl jobs fetch saves it later");
    if (options.dry_run && (options.no_wait || options.outputs.any() || options.wait.timeout_seconds > 0))
        throw Failure(ExitCode::Usage, "--dry-run renders nothing: there is nothing to save or to wait for");
    json request = start_request(options.request);
    put_method(request, options, method_of(session, options, known, request));
    send_parts(session, request, options.request);
    if (options.outputs.needs_reference() && !request.contains("reference"))
        throw Failure(ExitCode::Usage, "--difference, --flip and --error-map show the error against a --reference");
    if (options.dry_run) return print_estimate(session, request);

    const json accepted = submit(session, "/v1/jobs", request, options.request.idempotency_key);
    const std::string id = accepted.at("id").get<std::string>();
    if (options.no_wait) {
        if (session.json_output)
            session.print_json(accepted);
        else
            std::cout << id << '\n';
        session.remark("watch it: photonctl jobs watch " + id);
        return ExitCode::Ok;
    }

    const json job = wait_for_job(session, id, options.wait, false);
    remark_failure(session, job);
    remark_disturbance(session, job);
    const bool has_film = job.value("state", "") == "succeeded" || job.value("passes_done", 0) > 0;
    if (has_film) save_job_outputs(session, id, options.outputs);
    if (session.json_output)
        session.print_json(job);
    else
        print_statistics(std::cout, job.value("statistics", json()));
    if (has_film && !options.outputs.any_image())
        session.remark("save its image: photonctl jobs fetch " + id + " -o image.exr");
    return exit_code_of(job);
}

}  // namespace

RenderVocabulary ask_render_vocabulary(Session& session, const std::vector<std::string>& arguments) {
    std::string name = argument_of(arguments, {"--method", "-m"});
    if (const std::string file = argument_of(arguments, {"--request"}); name.empty() && !file.empty() && file != "-") {
        const json request = read_json_file(file);
        if (request.contains("method") && request["method"].is_object()) name = request["method"].value("name", "");
    }
    if (name.empty()) name = kDefaultMethod;
    return {MethodCatalogue(session.daemon()).method(name), true};
}

void add_render_command(CLI::App& program, Session& session, const RenderVocabulary& vocabulary) {
    CLI::App* command = program.add_subcommand("render", "Render a scene: submit, watch, save");
    const auto options = std::make_shared<RenderOptions>();
    const auto add = [&](const char* name, auto& value, const char* text, const char* type) {
        return command->add_option(name, value, text)->type_name(type);
    };
    add_source_options(*command, options->request);
    add("-m,--method", options->method, "method of light transport; default: path_tracing", "METHOD");
    add("--device", options->device, "where to render; default: cpu", "DEVICE");
    add("--set", options->settings, "set a parameter of the method; may be repeated", "NAME=VALUE")
        ->expected(1)
        ->take_all();
    add_stop_options(*command, options->request.stop,
                     "stop after this many samples a pixel; default, without --seconds and --target: 64");
    add_image_options(*command, options->request, vocabulary.method.layers);
    add("--seed", options->seed, "of the random numbers; default: 1", "INT");
    add("--first-pass", options->first_pass,
        "index of the first pass, for one part of a larger job that `photonctl merge` puts together; default: 0",
        "INT");
    add_output_options(*command, options->outputs);
    command->add_flag("--dry-run", options->dry_run,
                      "print the memory and the time it would take, and render nothing; files it needs are sent");
    command->add_flag("--no-wait", options->no_wait, "print the job's id and leave");
    add_wait_options(*command, options->wait);
    add_view_options(*command, options->request);

    for (const Parameter& parameter : vocabulary.method.parameters) {
        if (command->get_option_no_throw(parameter.option_name()))
            continue;  // the name is taken: --set still reaches it
        command
            ->add_option_function<std::string>(
                parameter.option_name(),
                [options, name = parameter.name](const std::string& text) { options->parameters[name] = text; },
                parameter.help())
            ->type_name(parameter.value_name())
            ->group("Parameters of " + vocabulary.method.name);
    }
    if (!vocabulary.known)
        command->footer("The parameters of a method are listed here when the daemon can be reached.");
    command->callback([&session, options, vocabulary] {
        session.action = [&session, options, vocabulary] { return render(session, *options, vocabulary.method); };
    });
}

}  // namespace photond::cli
