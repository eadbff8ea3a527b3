// photonctl merge|metrics: what is made of finished jobs and of images.

#include <iostream>

#include "clients/cli/commands.h"
#include "clients/cli/job_follower.h"
#include "clients/cli/job_view.h"
#include "clients/cli/reference_option.h"
#include "clients/cli/request_options.h"
#include "clients/cli/statistics_report.h"
#include "clients/cli/text_table.h"
#include "clients/cli/units.h"

namespace photond::cli {

namespace {

using nlohmann::json;

ExitCode merge(Session& session, const std::vector<std::string>& ids, const JobOutputs& outputs) {
    outputs.check(session);
    json job = submit(session, "/v1/jobs/merge", {{"jobs", ids}}, "");
    const std::string id = job.at("id").get<std::string>();
    if (!is_over(job)) job = wait_for_job(session, id, {}, false);
    remark_failure(session, job);
    if (job.value("state", "") == "succeeded") save_job_outputs(session, id, outputs);
    if (session.json_output) {
        session.print_json(job);
    } else {
        if (!outputs.to_standard_output()) print_job(session, job);
        if (!outputs.any_image()) session.remark("save its image: photonctl jobs fetch " + id + " -o image.exr");
    }
    return exit_code_of(job);
}

struct MeasuredImages {
    std::string image, reference, second_reference;  // the last one: of no length where there is none
};

ExitCode measure(Session& session, const MeasuredImages& images, const std::vector<std::string>& metrics) {
    json request{{"image", image_from(session, images.image)}};
    const std::string reference = image_from(session, images.reference);
    if (images.second_reference.empty())
        request["reference"] = reference;
    else
        request["references"] = {reference, image_from(session, images.second_reference)};
    if (!metrics.empty()) request["metrics"] = metrics;
    const json answer = session.daemon().send("POST", "/v1/metrics", request, Repeat::Safely);
    if (session.json_output) {
        session.print_json(answer);
        return ExitCode::Ok;
    }
    print_errors(std::cout, answer.at("metrics"), answer.value("reference_error", json()),
                 answer.value("intervals", json()));
    for (const json& note : answer.value("notes", json::array())) std::cout << "  note: " << plain_text(note) << '\n';
    return ExitCode::Ok;
}

}  // namespace

void add_film_commands(CLI::App& program, Session& session) {
    CLI::App* merge_command =
        program.add_subcommand("merge", "Put the passes of several jobs together: the same bits as one job with all");
    const auto ids = std::make_shared<std::vector<std::string>>();
    const auto outputs = std::make_shared<JobOutputs>();
    merge_command->add_option("job", *ids, "jobs that differ in their passes only (see render --first-pass)")
        ->required()
        ->type_name("JOB");
    add_output_options(*merge_command, *outputs);
    merge_command->callback([&session, ids, outputs] {
        session.action = [&session, ids, outputs] { return merge(session, *ids, *outputs); };
    });

    CLI::App* metrics_command = program.add_subcommand("metrics", "Errors of an image against a reference");
    const auto images = std::make_shared<MeasuredImages>();
    const auto metrics = std::make_shared<std::vector<std::string>>();
    metrics_command->add_option("image", images->image, "a job (J17), image:ID, or a .exr or .hdr to send")
        ->required()
        ->type_name("IMAGE");
    metrics_command->add_option("reference", images->reference, "what it is measured against, likewise")
        ->required()
        ->type_name("IMAGE");
    metrics_command
        ->add_option(
            "second_reference", images->second_reference,
            "one of another seed: mse, rmse and relative_mse are then without both references' noise, and have "
            "an interval")
        ->type_name("IMAGE");
    add_metrics_option(*metrics_command, *metrics,
                       "which ones, separated by commas; LAYER:METRIC is of one layer; default: all, of the beauty");
    metrics_command->callback([&session, images, metrics] {
        session.action = [&session, images, metrics] { return measure(session, *images, *metrics); };
    });
}

}  // namespace photond::cli
