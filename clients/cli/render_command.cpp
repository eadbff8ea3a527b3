// photonctl render SCENE

#include "clients/cli/commands.h"
#include "clients/cli/job_run.h"
#include "clients/cli/json_member.h"
#include "clients/cli/method_catalogue.h"
#include "clients/cli/render_options.h"

namespace photond::cli {

namespace {

using nlohmann::json;

struct JobOptions : RenderOptions {
    std::optional<uint32_t> first_pass;
    JobRun run;
};

ExitCode render(Session& session, const JobOptions& options, const CatalogueMethod& known) {
    JobRun run = options.run;
    run.idempotency_key = options.request.idempotency_key;
    run.check(session);
    RenderOptions rendered = options;
    if (!run.outputs.photon_map.empty()) rendered.parameters.emplace("keep_photon_map", "true");
    json request = job_body(session, rendered, known);
    if (options.first_pass) request["first_pass"] = *options.first_pass;
    const bool has_reference = !options.request.reference.empty() || !member(request, "reference").is_null();
    run.check_results(session, member(request, "layers"), has_reference);
    send_parts(session, request, rendered.request);
    return run_job(session, request, run);
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
    add_run_options(*command, options->run);

    command->callback([&session, options, vocabulary] {
        session.action = [&session, options, vocabulary] { return render(session, *options, vocabulary.method); };
    });
}

}  // namespace photond::cli
