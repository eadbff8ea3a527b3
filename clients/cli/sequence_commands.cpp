// photonctl sequence SCENE, and sequences list|show|watch|cancel|remove|fetch|errors

#include <chrono>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <set>

#include "clients/cli/commands.h"
#include "clients/cli/job_follower.h"
#include "clients/cli/job_view.h"
#include "clients/cli/output_file.h"
#include "clients/cli/render_options.h"
#include "clients/cli/sequence_follower.h"
#include "clients/cli/text_table.h"
#include "clients/cli/transfer.h"
#include "clients/cli/units.h"

namespace photond::cli {

namespace {

using nlohmann::json;

/// Where the frames are saved: FOLDER/0000.exr, FOLDER/0001.exr ...
struct FrameOutputs {
    std::string folder;
    bool png = false;

    bool any() const { return !folder.empty(); }
    /// Makes the folder, and sees before anything is rendered whether a file can be written there. Throws
    /// Failure(LocalFile).
    void check() const {
        if (!any()) return;
        std::error_code error;
        std::filesystem::create_directories(folder, error);
        if (error) throw Failure(ExitCode::LocalFile, "cannot make the folder " + folder + ": " + error.message());
        OutputFile::check_place(std::filesystem::path(folder) / "0000.exr");
    }
};

struct SequenceOptions : RenderOptions {
    std::optional<uint32_t> frames;
    std::optional<double> from, to, fps, turns;
    std::string noise;
    bool no_wait = false, dry_run = false;
    WaitOptions wait;
    FrameOutputs outputs;
};

struct SequencesOptions {
    std::vector<std::string> ids;
    size_t limit = 50;
    bool purge = false;
    std::vector<std::string> references;
    std::string layer = "beauty";
    std::vector<std::string> beside;
    std::string video, report;
    WaitOptions wait;
    FrameOutputs outputs;
};

void add_frame_options(CLI::App& command, FrameOutputs& outputs) {
    command.add_option("-o,--output", outputs.folder, "save the frames there, as 0000.exr, 0001.exr ...")
        ->type_name("FOLDER");
    command.add_flag("--png", outputs.png, "save previews, as 0000.png, instead");
}

/// Saves frames as they come.
class FrameSaver {
public:
    FrameSaver(Session& session, const std::string& id, const FrameOutputs& outputs)
        : session_(session), id_(id), outputs_(outputs) {}

    /// Those of a sequence that have succeeded and are not saved yet.
    void save(const json& sequence) {
        for (const json& frame : sequence.at("frames")) {
            const int number = frame.at("frame").get<int>();
            if (frame.value("state", "") != "succeeded" || !saved_.insert(number).second) continue;
            char name[32];
            std::snprintf(name, sizeof name, "%04d.%s", number, outputs_.png ? "png" : "exr");
            const std::string job = resource_path("jobs", frame.at("id").get<std::string>());
            download(session_, job + (outputs_.png ? "/preview.png" : "/image.exr"),
                     (std::filesystem::path(outputs_.folder) / name).string());
        }
    }
    /// Looks for more of them where the summary says that there are, now and then.
    void look(const json& summary) {
        constexpr std::chrono::seconds kEvery{2};
        const auto now = std::chrono::steady_clock::now();
        if (now < next_ || frames_over(summary).first <= saved_.size()) return;
        save(session_.daemon().get(resource_path("sequences", id_)));
        next_ = std::chrono::steady_clock::now() + kEvery;
    }
    size_t saved() const { return saved_.size(); }

private:
    Session& session_;
    const std::string id_;
    const FrameOutputs& outputs_;
    std::set<int> saved_;
    std::chrono::steady_clock::time_point next_{};
};

void tell_saved(Session& session, const FrameSaver& saver, const FrameOutputs& outputs) {
    session.remark("saved " + counted(saver.saved(), "frame") + " in " + outputs.folder);
}

void print_sequence(Session& session, const json& sequence) {
    const std::string state = plain_text(sequence.value("state", json()));
    const json request = sequence.value("request", json::object());
    std::cout << session.bold(plain_text(sequence.value("id", json()))) << ' ' << session.coloured_state(state, state)
              << ", " << plain_text(request.value("scene", json())) << ", " << sequence_figures(sequence) << '\n';
    for (const json& frame : sequence.value("frames", json::array()))
        if (frame.value("state", "") == "failed" || frame.value("state", "") == "cancelled")
            std::cout << "  frame " << frame.at("frame").dump() << " " << plain_text(frame.at("state"))
                      << ": photonctl jobs show " << plain_text(frame.at("id")) << ", jobs retry\n";
}

ExitCode finish_sequence(Session& session, const std::string& id, const WaitOptions& wait,
                         const FrameOutputs& outputs) {
    FrameSaver saver(session, id, outputs);
    const json sequence = wait_for_sequence(session, id, wait, [&](const json& summary) {
        if (outputs.any()) saver.look(summary);
    });
    if (outputs.any()) saver.save(sequence), tell_saved(session, saver, outputs);
    if (session.json_output)
        session.print_json(sequence);
    else
        print_sequence(session, sequence);
    if (!outputs.any()) session.remark("save its frames: photonctl sequences fetch " + id + " -o FOLDER");
    return exit_code_of(sequence);
}

json sequence_request(Session& session, const SequenceOptions& options, const CatalogueMethod& known) {
    json request = job_request(session, options, known);
    request.erase("time");
    const auto put = [&](const char* key, const auto& value) {
        if (value) request[key] = *value;
    };
    put("frames", options.frames), put("from", options.from), put("to", options.to), put("fps", options.fps);
    if (options.turns) request["camera_path"] = {{"turns", *options.turns}};
    if (!options.noise.empty()) request["noise"] = options.noise;
    return request;
}

json estimate_sequence(Session& session, const json& request) {
    return session.daemon().send("POST", "/v1/sequences?dry_run=true", request, Repeat::Safely);
}

/// Says before it is begun what will take long or much.
void warn_of_large(Session& session, const json& request) {
    constexpr double kLongSeconds = 120, kManyBytes = 1e9;
    const json estimate = estimate_sequence(session, request), seconds = estimate.value("seconds", json());
    const double bytes = estimate.at("disk_bytes").get<double>();
    const bool is_long = seconds.is_number() && seconds.get<double>() > kLongSeconds;
    if (!is_long && !(bytes > kManyBytes)) return;
    session.remark(counted(estimate.at("frames").get<size_t>(), "frame") + ", " + human_bytes(bytes) + " of the disk" +
                   (is_long ? ", about " + human_seconds(seconds.get<double>()) : "") +
                   "; fewer by --fps and --to, smaller by --width and --height, sooner by --passes");
}

ExitCode print_sequence_estimate(Session& session, const json& request) {
    const json estimate = estimate_sequence(session, request);
    if (session.json_output) {
        session.print_json(estimate);
        return ExitCode::Ok;
    }
    const json seconds = estimate.value("seconds", json());
    std::cout << estimate.at("frames").dump() << " frames\nmemory "
              << human_bytes(estimate.at("memory_bytes").get<double>()) << "\ndisk   "
              << human_bytes(estimate.at("disk_bytes").get<double>()) << "\ntime   "
              << (seconds.is_number() ? human_seconds(seconds.get<double>())
                                      : "not known: the daemon has rendered nothing with this method yet")
              << '\n';
    return ExitCode::Ok;
}

ExitCode render_sequence(Session& session, const SequenceOptions& options, const CatalogueMethod& known) {
    if (options.request.time)
        throw Failure(ExitCode::Usage, "--time is of one image: a sequence has --from, --fps, and --frames or --to");
    options.outputs.check();
    const json request = sequence_request(session, options, known);
    if (options.dry_run) return print_sequence_estimate(session, request);
    warn_of_large(session, request);
    const json accepted = submit(session, "/v1/sequences", request, options.request.idempotency_key);
    const std::string id = accepted.at("id").get<std::string>();
    if (!options.no_wait) return finish_sequence(session, id, options.wait, options.outputs);
    if (session.json_output)
        session.print_json(accepted);
    else
        std::cout << id << '\n';
    session.remark("watch it: photonctl sequences watch " + id);
    return ExitCode::Ok;
}

ExitCode list_sequences(Session& session, const SequencesOptions& options) {
    TextTable table({{"SEQUENCE"}, {"STATE"}, {"SCENE"}, {"METHOD"}, {"FRAMES", Align::Right}, {"CREATED (UTC)"}});
    for (const json& sequence : session.daemon().list("/v1/sequences", options.limit)) {
        if (session.json_output) {
            session.print_json(sequence);
            continue;
        }
        const json request = sequence.value("request", json::object());
        const json states = sequence.value("job_states", json::object());
        table.add_row({plain_text(sequence.value("id", json())), plain_text(sequence.value("state", json())),
                       plain_text(request.value("scene", json())),
                       plain_text(request.value("method", json::object()).value("name", json())),
                       states.value("succeeded", json(0)).dump() + "/" + request.value("frames", json(0)).dump(),
                       human_time(sequence.value("created", json()))});
    }
    if (!session.json_output) table.print(std::cout);
    return ExitCode::Ok;
}

ExitCode show_sequences(Session& session, const SequencesOptions& options) {
    for (const std::string& id : options.ids) {
        const json sequence = session.daemon().get(resource_path("sequences", id));
        session.json_output ? session.print_json(sequence) : print_sequence(session, sequence);
    }
    return ExitCode::Ok;
}

ExitCode watch_sequence(Session& session, const SequencesOptions& options) {
    return finish_sequence(session, options.ids.front(), options.wait, {});
}

ExitCode cancel_sequences(Session& session, const SequencesOptions& options) {
    return cancel_all(session, "sequences", options.ids, options.purge, "frames that are done stay");
}

ExitCode remove_sequences(Session& session, const SequencesOptions& options) {
    return cancel_all(session, "sequences", options.ids, true, "");
}

/// An MP4 or, by its name, a PNG of frames beside each other.
void save_video(Session& session, const std::string& id, const std::string& file) {
    const std::string ending = std::filesystem::path(file).extension().string();
    if (ending != ".mp4" && ending != ".png")
        throw Failure(ExitCode::Usage, "cannot tell what to save as " + file + ": name it .mp4 or .png");
    download(session, resource_path("sequences", id) + "/video?format=" + ending.substr(1), file);
    session.remark("saved " + file);
}

ExitCode fetch_sequence(Session& session, const SequencesOptions& options) {
    FrameOutputs outputs = options.outputs;
    if (!options.video.empty()) {
        save_video(session, options.ids.front(), options.video);
        if (!outputs.any()) return ExitCode::Ok;
    }
    if (!outputs.any()) outputs.folder = options.ids.front();
    outputs.check();
    FrameSaver saver(session, options.ids.front(), outputs);
    saver.save(session.daemon().get(resource_path("sequences", options.ids.front())));
    tell_saved(session, saver, outputs);
    return ExitCode::Ok;
}

/// "0.0123 (0.0119 to 0.0127)"; "-" where there is none.
std::string figure_text(const json& figure) {
    if (!figure.is_object()) return "-";
    const json& interval = figure.at("interval");
    return human_number(figure.at("value").get<double>()) + " (" + human_number(interval.at(0).get<double>()) + " to " +
           human_number(interval.at(1).get<double>()) + ")";
}

ExitCode sequence_errors(Session& session, const SequencesOptions& options) {
    const std::string sequence = resource_path("sequences", options.ids.front());
    const std::string query = "?first=" + percent_encode(options.references.at(0)) +
                              "&second=" + percent_encode(options.references.at(1)) +
                              "&layer=" + percent_encode(options.layer);
    if (!options.report.empty()) {
        std::string beside;
        for (const std::string& id : options.beside) beside += (beside.empty() ? "&beside=" : ",") + percent_encode(id);
        save_resource(session, sequence + "/report.html" + query + beside, options.report);
        return ExitCode::Ok;
    }
    if (!options.beside.empty()) throw Failure(ExitCode::Usage, "--beside is of the page that -o saves");
    const json errors = session.daemon().get(sequence + "/errors" + query);
    if (session.json_output) {
        session.print_json(errors);
        return ExitCode::Ok;
    }
    TextTable table({{"FRAME", Align::Right}, {"RELATIVE_MSE"}, {"FLICKER"}, {"LAG"}, {"MOTION"}});
    const auto add_row = [&](const std::string& name, const json& figures) {
        table.add_row({name, figure_text(figures.at("relative_mse")), figure_text(figures.at("flicker")),
                       figure_text(figures.at("lag")), figure_text(figures.at("change"))});
    };
    for (const json& frame : errors.at("frames")) add_row(frame.at("frame").dump(), frame);
    add_row("mean", errors.at("mean"));
    table.print(std::cout);
    if (const json& late = errors.at("frames_late"); late.is_number())
        std::cout << "what moves is shown " << human_number(std::round(100 * late.get<double>()) / 100 + 0.0)
                  << " frames late\n";
    return ExitCode::Ok;
}

void add_sequence_command(CLI::App& program, Session& session, const RenderVocabulary& vocabulary) {
    CLI::App* command = program.add_subcommand("sequence", "Render frames of a moving scene, or along a camera path");
    const auto options = std::make_shared<SequenceOptions>();
    add_job_options(*command, options, vocabulary);
    const char* group = "Frames";
    const auto add = [&](const char* name, auto& value, const char* text, const char* type) {
        command->add_option(name, value, text)->type_name(type)->group(group);
    };
    add("--frames", options->frames, "how many, or else --to", "INT");
    add("--from", options->from, "the first one's moment [s]; default: 0", "SECONDS");
    add("--to", options->to, "no frame comes after this moment [s]", "SECONDS");
    add("--fps", options->fps, "frames a second; default: 24", "NUMBER");
    add("--turns", options->turns, "turn the eye about --look-at so many times, from --eye on", "NUMBER");
    add("--noise", options->noise, "a seed of its own for each frame, or one for all; default: fresh", "fresh|still");
    add_frame_options(*command, options->outputs);
    command->add_flag("--dry-run", options->dry_run, "print memory, disk and time it would take, and render nothing");
    command->add_flag("--no-wait", options->no_wait, "print the sequence's id and leave");
    add_wait_options(*command, options->wait);
    command->callback([&session, options, vocabulary] {
        session.action = [&session, options, vocabulary] {
            return render_sequence(session, *options, vocabulary.method);
        };
    });
}

}  // namespace

void add_sequence_commands(CLI::App& program, Session& session, const RenderVocabulary& vocabulary) {
    add_sequence_command(program, session, vocabulary);
    CLI::App* sequences =
        program.add_subcommand("sequences", "Sequences: list, show, watch, cancel, remove, fetch, errors");
    sequences->require_subcommand(1);
    const auto options = std::make_shared<SequencesOptions>();
    const auto command = [&](const char* name, const char* text, int most_ids,
                             ExitCode (*run)(Session&, const SequencesOptions&)) {
        CLI::App* sub = sequences->add_subcommand(name, text);
        if (most_ids != 0) {
            CLI::Option* ids = sub->add_option("sequence", options->ids, most_ids == 1 ? "sequence id" : "sequence ids")
                                   ->required()
                                   ->type_name("SEQUENCE");
            if (most_ids == 1) ids->expected(1);
        }
        sub->callback(
            [&session, options, run] { session.action = [&session, options, run] { return run(session, *options); }; });
        return sub;
    };
    constexpr int kMany = -1;
    command("list", "Sequences, newest first", 0, list_sequences)
        ->add_option("--limit", options->limit, "at most this many")
        ->type_name("INT")
        ->capture_default_str();
    command("show", "How far they are", kMany, show_sequences);
    add_wait_options(*command("watch", "Follow a sequence to its end", 1, watch_sequence), options->wait);
    command("cancel", "End sequences; frames that are done stay", kMany, cancel_sequences)
        ->add_flag("--purge", options->purge, "also remove the sequence, its frames and their files");
    command("remove", "Remove sequences with their frames and files; one that runs is ended first", kMany,
            remove_sequences);
    CLI::App* fetch = command("fetch", "Save the frames; default: in a folder of its name", 1, fetch_sequence);
    add_frame_options(*fetch, options->outputs);
    fetch->add_option("--video", options->video, "save a video, or by the name .png a sheet of at most 100 frames")
        ->type_name("FILE.mp4");
    CLI::App* errors =
        command("errors", "Error, flicker and lag by frame, against two sequences of other seeds", 1, sequence_errors);
    errors->add_option("--references", options->references, "two sequences of the same frames")
        ->required()
        ->expected(2)
        ->type_name("SEQUENCE SEQUENCE");
    errors->add_option("--layer", options->layer, "which layer")->capture_default_str();
    errors->add_option("-o,--output", options->report, "save a page with curves by frame and pictures instead")
        ->type_name("FILE.html");
    errors->add_option("--beside", options->beside, "other sequences of the same frames on that page")
        ->type_name("SEQUENCE ...");
}

}  // namespace photond::cli
