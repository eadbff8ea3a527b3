// photonctl render SCENE

#include <iostream>

#include "clients/cli/commands.h"
#include "clients/cli/job_view.h"
#include "clients/cli/method_catalogue.h"
#include "clients/cli/render_options.h"
#include "clients/cli/statistics_report.h"
#include "clients/cli/units.h"

namespace photond::cli {

namespace {

using nlohmann::json;

struct JobOptions : RenderOptions {
    std::optional<uint32_t> first_pass;
    bool no_wait = false;
    bool dry_run = false;
    WaitOptions wait;
    JobOutputs outputs;
};

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

ExitCode render(Session& session, const JobOptions& options, const CatalogueMethod& known) {
    options.outputs.check();
    if (options.no_wait && (options.outputs.any() || options.wait.timeout_seconds > 0))
        throw Failure(ExitCode::Usage, "--no-wait saves nothing and needs no --timeout",
                      "photonctl jobs fetch saves it later");
    if (options.dry_run && (options.no_wait || options.outputs.any() || options.wait.timeout_seconds > 0))
        throw Failure(ExitCode::Usage, "--dry-run renders nothing: there is nothing to save or to wait for");
    RenderOptions rendered = options;
    if (!options.outputs.photon_map.empty()) rendered.parameters.emplace("keep_photon_map", "true");
    json request = job_request(session, rendered, known);
    if (options.first_pass) request["first_pass"] = *options.first_pass;
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
    const auto options = std::make_shared<JobOptions>();
    add_job_options(*command, options, vocabulary);
    command
        ->add_option(
            "--first-pass", options->first_pass,
            "index of the first pass, for one part of a larger job that `photonctl merge` puts together; default: 0")
        ->type_name("INT");
    add_output_options(*command, options->outputs);
    command->add_flag("--dry-run", options->dry_run,
                      "print the memory and the time it would take, and render nothing; files it needs are sent");
    command->add_flag("--no-wait", options->no_wait, "print the job's id and leave");
    add_wait_options(*command, options->wait);

    command->callback([&session, options, vocabulary] {
        session.action = [&session, options, vocabulary] { return render(session, *options, vocabulary.method); };
    });
}

}  // namespace photond::cli
