// photonctl repeat IMAGE: the job again that made an image.

#include "clients/cli/commands.h"
#include "clients/cli/exr_attribute.h"
#include "clients/cli/job_run.h"
#include "clients/cli/json_member.h"
#include "clients/cli/request_options.h"
#include "clients/cli/stop_options.h"
#include "clients/cli/units.h"

namespace photond::cli {

namespace {

using nlohmann::json;

constexpr const char* kRequestAttribute = "photond:request";  // the daemon writes it: the job's request as JSON

struct RepeatOptions {
    std::string image, device;
    std::optional<uint64_t> seed;
    StopOptions stop;
    JobRun run;
};

json request_in(const std::string& image) {
    const std::optional<std::string> text = exr_text_attribute(image, kRequestAttribute);
    if (!text)
        throw Failure(
            ExitCode::Usage, image + " does not say which job made it: it has no attribute " + kRequestAttribute,
            "an EXR that this daemon saved has one; --request of photonctl render takes a job's request as a file");
    json request = json::parse(*text, nullptr, false);
    if (!request.is_object())
        throw Failure(ExitCode::Usage,
                      "the attribute " + std::string(kRequestAttribute) + " of " + image + " is not a JSON object");
    return request;
}

ExitCode repeat(Session& session, const RepeatOptions& options) {
    options.run.check(session);
    json request = request_in(options.image);
    if (options.stop.any()) request["stop"] = options.stop.body();
    if (options.seed) request["seed"] = *options.seed;
    if (!options.device.empty()) object_in(request, "method")["device"] = options.device;
    options.run.check_results(session, member(request, "layers"), !member(request, "reference").is_null());
    return run_job(session, request, options.run);
}

}  // namespace

void add_repeat_command(CLI::App& program, Session& session) {
    CLI::App* command = program.add_subcommand("repeat", "Render the job again that made an image, by its header");
    const auto options = std::make_shared<RepeatOptions>();
    command->add_option("image", options->image, "an EXR saved of a job, from this daemon or another")
        ->required()
        ->type_name("FILE");
    add_stop_options(*command, options->stop, "stop after this many samples a pixel; default: as the image says",
                     "--passes,--samples");
    command->add_option("--seed", options->seed, "of the random numbers; default: as the image says")->type_name("INT");
    command->add_option("--device", options->device, "where to render; default: as the image says")
        ->type_name("DEVICE");
    add_run_options(*command, options->run);
    command
        ->add_option("--idempotency-key", options->run.idempotency_key,
                     "the same key and request is the same submission; default: random")
        ->type_name("TEXT");
    command->callback(
        [&session, options] { session.action = [&session, options] { return repeat(session, *options); }; });
}

}  // namespace photond::cli
