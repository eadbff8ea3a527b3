#include "clients/cli/job_view.h"

#include <iostream>

#include "clients/cli/job_follower.h"
#include "clients/cli/progress_view.h"
#include "clients/cli/statistics_report.h"
#include "clients/cli/text_table.h"
#include "clients/cli/units.h"

namespace photond::cli {

namespace {

using nlohmann::json;

std::string stop_text(const json& stop) {
    std::string text;
    if (!stop.is_object()) return "-";
    const auto add = [&](const std::string& part) { text += (text.empty() ? "" : " or ") + part; };
    if (stop.contains("passes") && stop["passes"].is_number()) add(plain_text(stop["passes"]) + " passes");
    if (stop.contains("seconds") && stop["seconds"].is_number()) add(human_seconds(stop["seconds"].get<double>()));
    return text;
}

std::string pairs_text(const json& object) {
    std::string text;
    if (object.is_object())
        for (const auto& [key, value] : object.items())
            text += (text.empty() ? "" : ", ") + printable(key) + "=" + plain_text(value);
    return text;
}

}  // namespace

void add_wait_options(CLI::App& command, WaitOptions& options) {
    command
        .add_option("--timeout", options.timeout_seconds,
                    "give up waiting after this many seconds; the job goes on (exit code 6)")
        ->type_name("SECONDS")
        ->check(CLI::Range(0.001, 1e9).description(""));
    command.add_flag("--cancel-on-interrupt", options.cancel_on_interrupt,
                     "Ctrl-C cancels the job; without this it only stops watching");
}

void add_output_options(CLI::App& command, JobOutputs& outputs) {
    command
        .add_option("-o,--output", outputs.images,
                    "save the image: .exr has every layer, .png is a preview; may be repeated")
        ->type_name("FILE")
        ->expected(1)
        ->take_all();
    command.add_option("--preview", outputs.preview, "save a tone-mapped PNG")->type_name("FILE");
    command.add_option("--exposure", outputs.exposure_stops, "exposure of the PNG in stops; default: 0")
        ->type_name("NUMBER");
    command.add_option("--curve", outputs.curve, "tone curve of the PNG")
        ->type_name("srgb|filmic")
        ->check(CLI::IsMember({"srgb", "filmic"}).description(""));
    command
        .add_option("--photon-map", outputs.photon_map,
                    "save the photons as a glTF point cloud (.glb), where the method has keep_photon_map")
        ->type_name("FILE");
    command.add_option("--precision", outputs.precision, "of the EXR; default: float")
        ->type_name("half|float")
        ->check(CLI::IsMember({"half", "float"}).description(""));
}

json wait_for_job(Session& session, const std::string& id, const WaitOptions& options, bool print_changes) {
    if (options.timeout_seconds > 0)
        session.interrupt().set_deadline(std::chrono::duration<double>(options.timeout_seconds));
    const std::string go_on = "watch it: photonctl jobs watch " + id + "; end it: photonctl jobs cancel " + id;
    try {
        ProgressView view(session.error_is_terminal());
        return follow_job(session.daemon(), id, [&](const json& job, const std::string&) {
            view.show(job);
            if (print_changes && !is_over(job)) session.print_json(job);
        });
    } catch (const Failure& failure) {
        if (failure.code == ExitCode::TimedOut)
            throw Failure(ExitCode::TimedOut, "--timeout passed; job " + id + " goes on", go_on);
        if (failure.code == ExitCode::Unreachable)
            throw Failure(ExitCode::Unreachable, std::string(failure.what()) + "; job " + id + " is kept", go_on);
        if (failure.code != ExitCode::Interrupted) throw;
        if (!options.cancel_on_interrupt)
            throw Failure(ExitCode::Interrupted, "interrupted; job " + id + " goes on", go_on);
    }
    session.interrupt().acknowledge();
    session.remark("cancelling " + id);
    session.daemon().send("DELETE", resource_path("jobs", id), nullptr, Repeat::Safely);
    return follow_job(session.daemon(), id, [](const json&, const std::string&) {});
}

ExitCode exit_code_of(const json& job) {
    const std::string state = job.value("state", "");
    if (state == "failed") return ExitCode::JobFailed;
    return state == "cancelled" ? ExitCode::Cancelled : ExitCode::Ok;
}

void print_job(const Session& session, const json& job) {
    const std::string state = plain_text(job.value("state", json()));
    std::cout << session.bold(plain_text(job.value("id", json()))) << ' ' << session.coloured_state(state, state)
              << '\n';
    const json request = job.value("request", json::object());
    const json image = request.value("image", json::object());
    const json method = request.value("method", json::object());
    TextTable table({{""}, {""}});
    const auto add = [&](const char* label, const std::string& text) {
        if (!text.empty() && text != "-") table.add_row({label, text});
    };
    add("scene", plain_text(request.value("scene", json())));
    add("method", plain_text(method.value("name", json())) + " on " + plain_text(method.value("device", json())));
    add("parameters", pairs_text(method.value("parameters", json())));
    add("image", plain_text(image.value("width", json())) + " x " + plain_text(image.value("height", json())) + ", " +
                     plain_text(image.value("filter", json())) + " filter");
    add("stop", stop_text(request.value("stop", json())));
    add("labels", pairs_text(request.value("labels", json())));
    add("passes done", plain_text(job.value("passes_done", json())));
    const json seconds = job.value("seconds", json());
    add("rendered for", seconds.is_number() ? human_seconds(seconds.get<double>()) : "");
    for (const char* time : {"created", "started", "finished"}) add(time, human_time(job.value(time, json())));
    const json attempts = job.value("attempts", json());
    if (attempts.is_array() && attempts.size() > 1) add("attempts", std::to_string(attempts.size()));
    table.print(std::cout, "  ");
    const json statistics = job.value("statistics", json());
    if (statistics.is_object()) {
        std::cout << '\n';
        print_statistics(std::cout, statistics);
    }
}

void remark_failure(const Session& session, const json& job) {
    const json failure = job.value("failure", json());
    if (!failure.is_object()) return;
    const json detail = failure.contains("detail") ? failure["detail"] : failure.value("title", json());
    session.remark("job " + plain_text(job.value("id", json())) + " failed: " + plain_text(detail));
    if (failure.contains("errors") && failure["errors"].is_array())
        for (const json& fault : failure["errors"])
            session.remark("  " + plain_text(fault.value("pointer", json())) + ": " +
                           plain_text(fault.value("detail", json())));
    session.remark("its log: photonctl jobs fetch " + plain_text(job.value("id", json())) + " --log -");
}

}  // namespace photond::cli
