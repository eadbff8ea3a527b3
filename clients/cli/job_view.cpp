#include "clients/cli/job_view.h"

#include <iostream>

#include "clients/cli/job_follower.h"
#include "clients/cli/json_member.h"
#include "clients/cli/problem_view.h"
#include "clients/cli/progress_view.h"
#include "clients/cli/statistics_report.h"
#include "clients/cli/stop_options.h"
#include "clients/cli/text_table.h"
#include "clients/cli/units.h"

namespace photond::cli {

namespace {

using nlohmann::json;

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
                    "give up waiting after this many seconds; what was started goes on (exit code 6)")
        ->type_name("SECONDS")
        ->check(CLI::Range(0.001, 1e9).description(""));
    command.add_flag("--cancel-on-interrupt", options.cancel_on_interrupt,
                     "Ctrl-C cancels what is watched; without this it only stops watching");
}

void add_output_options(CLI::App& command, JobOutputs& outputs) {
    command
        .add_option("-o,--output", outputs.images,
                    "save the image: .exr has every layer, .png is a preview, - is standard output; may be repeated")
        ->type_name("FILE")
        ->expected(1)
        ->take_all();
    command.add_option("--format", outputs.format, "what -o - writes; default: exr")
        ->type_name("exr|png")
        ->check(CLI::IsMember({"exr", "png"}).description(""));
    command.add_option("--preview", outputs.preview, "save a tone-mapped PNG")->type_name("FILE");
    command
        .add_option(
            "--preview-layer", outputs.preview_layer,
            "what the PNG shows; default: beauty. A layer of those asked for with --layers, where it has a preview "
            "(GET /v1/layers)")
        ->type_name("LAYER");
    command.add_option("--exposure", outputs.exposure_stops, "exposure of the PNG in stops; default: 0")
        ->type_name("NUMBER");
    command.add_option("--tone-curve", outputs.tone_curve, "tone curve of the PNG")
        ->type_name("srgb|filmic")
        ->check(CLI::IsMember({"srgb", "filmic"}).description(""));
    const auto file = [&](const char* name, std::string& value, const char* text) {
        command.add_option(name, value, text)->type_name("FILE")->group("Error");
    };
    // --curve was the PNG's tone curve before there were errors to draw: its two words still are.
    command
        .add_option_function<std::string>(
            "--curve",
            [&outputs](const std::string& text) {
                (text == "srgb" || text == "filmic" ? outputs.tone_curve : outputs.error_curve) = text;
            },
            "save the error over time as CSV ('-': standard output)")
        ->type_name("FILE")
        ->group("Error");
    file("--difference", outputs.difference, "save image minus reference (.exr)");
    file("--flip", outputs.flip, "save the FLIP map, what an eye would see of the error (.png)");
    file("--error-map", outputs.error_map, "save the error of each pixel in false colours (.png)");
    file("--film", outputs.film, "save the film itself: sums, squares and counts of every pass");
    command
        .add_option("--photon-map", outputs.photon_map,
                    "save the photons as a glTF point cloud (.glb), where the method has keep_photon_map")
        ->type_name("FILE");
    command.add_option("--precision", outputs.precision, "of the EXR; default: float")
        ->type_name("half|float")
        ->check(CLI::IsMember({"half", "float"}).description(""));
}

std::optional<json> wait_for(Session& session, const std::string& kind, const std::string& id,
                             const WaitOptions& options, const std::function<json()>& follow) {
    if (options.timeout_seconds > 0)
        session.interrupt().set_deadline(std::chrono::duration<double>(options.timeout_seconds));
    const std::string command = "photonctl " + kind + "s ";
    const std::string go_on = "watch it: " + command + "watch " + id + "; end it: " + command + "cancel " + id;
    const std::string subject = kind + " " + id;
    try {
        return follow();
    } catch (const Failure& failure) {
        if (failure.code == ExitCode::TimedOut)
            throw Failure(ExitCode::TimedOut, "--timeout passed; " + subject + " goes on", go_on);
        if (failure.code == ExitCode::Unreachable)
            throw Failure(ExitCode::Unreachable, std::string(failure.what()) + "; " + subject + " is kept", go_on);
        if (failure.code != ExitCode::Interrupted) throw;
        if (!options.cancel_on_interrupt)
            throw Failure(ExitCode::Interrupted, "interrupted; " + subject + " goes on", go_on);
    }
    session.interrupt().acknowledge();
    session.remark("cancelling " + id);
    session.daemon().send("DELETE", resource_path(kind + "s", id), nullptr, Repeat::Safely);
    return std::nullopt;
}

ExitCode cancel_all(Session& session, const std::string& kind, const std::vector<std::string>& ids, bool remove,
                    const std::string& what_stays) {
    for (const std::string& id : ids) {
        HttpRequest request;
        request.method = "DELETE";
        request.path = resource_path(kind, id) + (remove ? "?purge=true" : "");
        const HttpReply reply = session.daemon().ask(request, Repeat::Safely);
        const json object = json_of(reply);
        const std::string state = plain_text(member(object, "state"));
        const bool was_over = reply.status == 200;
        if (session.json_output && object.is_object()) session.print_json(object);
        if (remove)
            session.remark(id + (was_over ? " removed" : " is being ended, and is removed then"));
        else if (was_over)
            session.remark(id + " was over before: it had " + (state == "cancelled" ? "been cancelled" : state));
        else
            session.remark(id + (state == "cancelled" ? " cancelled; " : " is being cancelled; ") + what_stays);
    }
    return ExitCode::Ok;
}

json wait_for_job(Session& session, const std::string& id, const WaitOptions& options, bool print_changes) {
    const std::optional<json> job = wait_for(session, "job", id, options, [&] {
        ProgressView view(session.error_is_terminal());
        return follow_job(session.daemon(), id, [&](const json& now, const std::string&) {
            view.show(now);
            if (print_changes && !is_over(now)) session.print_json(now);
        });
    });
    return job ? *job : follow_job(session.daemon(), id, [](const json&, const std::string&) {});
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
    if (state == "queued") add("waits for", plain_text(job.value("waiting_for", json())));
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

void remark_disturbance(const Session& session, const json& job) {
    const json warning = member(member(member(job, "statistics"), "shared"), "warning");
    if (!warning.is_string()) return;
    session.remark("warning: " + plain_text(warning));
    session.remark("to run it again: photonctl jobs repeat " + plain_text(member(job, "id")));
}

void remark_failure(const Session& session, const json& job) {
    const json failure = job.value("failure", json());
    if (!failure.is_object()) return;
    const json detail = failure.contains("detail") ? failure["detail"] : failure.value("title", json());
    remark_problem(session, "job " + plain_text(job.value("id", json())) + " failed: ", plain_text(detail), failure);
    session.remark("its log: photonctl jobs fetch " + plain_text(job.value("id", json())) + " --log -");
}

}  // namespace photond::cli
