#include "clients/cli/job_run.h"

#include <iostream>

#include "clients/cli/request_options.h"
#include "clients/cli/statistics_report.h"
#include "clients/cli/units.h"

namespace photond::cli {

using nlohmann::json;

namespace {

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

}  // namespace

void JobRun::check(const Session& session) const {
    outputs.check(session);
    if (no_wait && (outputs.any() || wait.timeout_seconds > 0))
        throw Failure(ExitCode::Usage, "--no-wait saves nothing and needs no --timeout",
                      "photonctl jobs fetch saves it later");
    if (dry_run && (no_wait || outputs.any() || wait.timeout_seconds > 0))
        throw Failure(ExitCode::Usage, "--dry-run renders nothing: there is nothing to save or to wait for");
}

void JobRun::check_results(Session& session, const json& layers, bool has_reference) const {
    if (outputs.needs_reference() && !has_reference)
        throw Failure(ExitCode::Usage, "--difference, --flip and --error-map show the error against a --reference");
    outputs.check_preview_layer(session, layers);
}

void add_run_options(CLI::App& command, JobRun& run) {
    add_output_options(command, run.outputs);
    command.add_flag("--dry-run", run.dry_run,
                     "print the memory and the time it would take, and render nothing; files it needs are sent");
    command.add_flag("--no-wait", run.no_wait, "print the job's id and leave");
    add_wait_options(command, run.wait);
}

ExitCode run_job(Session& session, const json& request, const JobRun& run) {
    if (run.dry_run) return print_estimate(session, request);
    const json accepted = submit(session, "/v1/jobs", request, run.idempotency_key);
    const std::string id = accepted.at("id").get<std::string>();
    if (run.no_wait) {
        if (session.json_output)
            session.print_json(accepted);
        else
            std::cout << id << '\n';
        session.remark("watch it: photonctl jobs watch " + id);
        return ExitCode::Ok;
    }

    const json job = wait_for_job(session, id, run.wait, false);
    remark_failure(session, job);
    remark_disturbance(session, job);
    const bool has_film = job.value("state", "") == "succeeded" || job.value("passes_done", 0) > 0;
    if (has_film) save_job_outputs(session, id, run.outputs);
    if (session.json_output)
        session.print_json(job);
    else
        print_statistics(text_beside(run.outputs), job.value("statistics", json()));
    if (has_film && !run.outputs.any_image())
        session.remark("save its image: photonctl jobs fetch " + id + " -o image.exr");
    return exit_code_of(job);
}

}  // namespace photond::cli
