// photonctl compare SCENE, photonctl compare --preset NAME

#include <algorithm>
#include <filesystem>
#include <iostream>

#include "clients/cli/commands.h"
#include "clients/cli/compare_memory.h"
#include "clients/cli/compare_presets.h"
#include "clients/cli/compare_sequences.h"
#include "clients/cli/compare_stages.h"
#include "clients/cli/comparison_follower.h"
#include "clients/cli/method_catalogue.h"
#include "clients/cli/request_options.h"
#include "clients/cli/units.h"

namespace photond::cli {

namespace {

using nlohmann::json;

struct CompareOptions {
    RequestOptions request;
    std::string preset, device, scene_folder;
    bool builtin = false;  // stand-ins for the preset's files
    std::vector<std::string> parts;
    std::optional<uint32_t> reference_passes, frames;
    std::optional<double> fps;
    std::string videos;
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

/// "METHOD,..." on a device that is given.
std::string on_device(const std::string& method, const std::string& device) {
    if (device.empty()) return method;
    const size_t end = std::min(method.find(','), method.size());
    return method.substr(0, end) + "@" + device + method.substr(end);
}

/// When the jobs end, and what they are measured against but for frames, see render_frame(). Of frames only the number
/// can be given.
void put_ends(CompareOptions& options, const PresetComparison& part) {
    RequestOptions& request = options.request;
    if (part.frames > 0) {
        const uint32_t frames = request.stop.passes.value_or(part.frames);
        request.stop = {};
        request.stop.passes = frames;
        return;
    }
    if (!request.stop.any()) request.stop.seconds = part.seconds;
    if (part.sequence.count > 0) return;
    if (request.reference.empty())
        request.reference = on_device(part.reference, options.device) + ":" +
                            std::to_string(options.reference_passes.value_or(part.reference_passes));
}

/// Submits the reference of `comparison`, a body that lacks nothing else; its own body's `reference`.
json render_frame(Session& session, const json& comparison, const CompareOptions& options,
                  const PresetComparison& part) {
    json job = comparison;
    if (const json seeds = comparison.value("seeds", json()); seeds.is_array() && !seeds.empty())
        job["seed"] = seeds.front();
    for (const char* member : {"entries", "metrics", "seeds"}) job.erase(member);
    job["method"] = MethodCatalogue(session.daemon()).method_from(on_device(part.reference, options.device));
    const std::string& key = options.request.idempotency_key;
    const json accepted = submit(session, "/v1/jobs", job, key.empty() ? key : key + "-frame");
    return "job:" + accepted.at("id").get<std::string>();
}

std::filesystem::path file_of(const CompareOptions& options, const PresetComparison& part) {
    return std::filesystem::path(options.scene_folder.empty() ? "." : options.scene_folder) / part.file;
}

/// The preset's scene and where it is looked at from, in files with its name.
void put_scene(CompareOptions& options, const PresetComparison& part) {
    RequestOptions& request = options.request;
    if (part.file.empty() || options.builtin) {
        request.scene = part.scene;
    } else {
        request.scene = file_of(options, part).string();
        if (request.camera.empty() && request.eye.empty()) request.camera = part.camera;
    }
    for (std::string& page : options.outputs.html) page = of_part(page, part.name);
    options.outputs.csv = of_part(options.outputs.csv, part.name);
    options.outputs.json = of_part(options.outputs.json, part.name);
    // The same key twice would be the same submission.
    if (!request.idempotency_key.empty()) request.idempotency_key += "-" + std::string(part.name);
}

/// A comparison of the preset as options: what the command line says stands, its entries and sweeps come after the
/// preset's.
CompareOptions with_preset(const CompareOptions& given, const PresetComparison& part) {
    CompareOptions options = given;
    const auto put_first = [](std::vector<std::string>& list, const std::vector<std::string>& first) {
        list.insert(list.begin(), first.begin(), first.end());
    };
    put_first(options.entries, part.entries);
    put_first(options.sweeps, part.sweeps);
    RequestOptions& request = options.request;
    request.width = request.width.value_or(part.width);
    request.height = request.height.value_or(part.height);
    if (request.metrics.empty()) request.metrics = part.metrics;
    put_ends(options, part);
    if (request.scene.empty()) put_scene(options, part);
    return options;
}

/// Those that are asked for: on a scene of the caller's one, by itself the preset's first.
std::vector<const PresetComparison*> chosen_parts(const CompareOptions& options, const ComparePreset& preset) {
    std::vector<const PresetComparison*> chosen;
    for (const std::string& name : options.parts) {
        const auto part = std::find_if(preset.comparisons.begin(), preset.comparisons.end(),
                                       [&](const PresetComparison& candidate) { return candidate.name == name; });
        if (part == preset.comparisons.end()) {
            std::string all;
            for (const PresetComparison& known : preset.comparisons)
                all += (all.empty() ? "it has " : ", ") + std::string(known.name);
            throw Failure(ExitCode::Usage, "the preset has no part " + printable(name), all);
        }
        chosen.push_back(&*part);
    }
    if (chosen.empty())
        for (const PresetComparison& part : preset.comparisons) chosen.push_back(&part);
    if (options.request.scene.empty()) return chosen;
    if (options.parts.size() > 1) throw Failure(ExitCode::Usage, "on a scene of yours, --part names one");
    return {chosen.front()};
}

/// Drops what has no stand-in, with a remark. Throws Failure(Usage) for files that are not there, before anything is
/// rendered.
std::vector<const PresetComparison*> with_scenes(Session& session, const CompareOptions& options,
                                                 std::vector<const PresetComparison*> parts) {
    if (!options.request.scene.empty()) return parts;
    std::string missing;
    std::erase_if(parts, [&](const PresetComparison* part) {
        if (part->file.empty()) return false;
        if (options.builtin) {
            session.remark(std::string(part->name) + ": " +
                           (part->scene.empty() ? "nothing" : std::string(part->scene)) + " stands in for " +
                           std::string(part->file));
            return part->scene.empty();
        }
        std::error_code ignored;
        const std::string name(part->file);
        if (!std::filesystem::is_regular_file(file_of(options, *part), ignored) &&
            missing.find(name) == std::string::npos)
            missing += (missing.empty() ? "" : " and ") + name;
        return false;
    });
    if (!missing.empty()) {
        std::error_code ignored;
        const std::filesystem::path folder = options.scene_folder.empty() ? "." : options.scene_folder;
        throw Failure(
            ExitCode::Usage,
            missing + ": not in " + printable(std::filesystem::absolute(folder, ignored).lexically_normal().string()),
            "--scene-folder says where the preset's scenes are; --builtin renders scenes of the program's own "
            "in their place");
    }
    if (parts.empty()) throw Failure(ExitCode::Usage, "nothing stands in for the scenes of what --part names");
    return parts;
}

/// Throws Failure(Usage) for what is not of sequences.
ExitCode compare_moving(Session& session, const CompareOptions& options, const PresetComparison& part) {
    if (options.no_wait || !options.sweeps.empty() || !options.outputs.csv.empty() ||
        !options.request.reference.empty() || !options.request.metrics.empty() ||
        !options.request.idempotency_key.empty())
        throw Failure(ExitCode::Usage,
                      "--no-wait, --sweep, --csv, --reference, --metrics and --idempotency-key do not go with the "
                      "sequences of this preset");
    json request = build_request(session, options);
    send_parts(session, request, options.request);
    request["frames"] = options.frames.value_or(part.sequence.count);
    request["fps"] = options.fps.value_or(part.sequence.fps);
    if (!request.contains("animation")) request["animation"] = part.sequence.animation;
    const json reference{
        {"method", MethodCatalogue(session.daemon()).method_from(on_device(part.reference, options.device))},
        {"passes", options.reference_passes.value_or(part.reference_passes)}};
    std::string videos = options.videos;
    if (!videos.empty()) videos = (std::filesystem::path(videos) / part.name).string();
    return compare_sequences(session, request, reference, options.wait, {options.outputs, videos});
}

ExitCode compare_one(Session& session, const CompareOptions& options, const PresetComparison* part) {
    if (part && part->sequence.count > 0) return compare_moving(session, options, *part);
    if (options.frames || options.fps || !options.videos.empty())
        throw Failure(ExitCode::Usage, "--frames, --fps and --videos belong to --preset moving");
    json request = build_request(session, options);
    send_parts(session, request, options.request);
    if (part && part->frames > 0 && options.request.reference.empty())
        request["reference"] = render_frame(session, request, options, *part);
    const json accepted = submit(session, "/v1/comparisons", request, options.request.idempotency_key);
    const std::string id = accepted.at("id").get<std::string>();
    if (!options.no_wait) {
        const ExitCode code = finish_comparison(session, id, options.wait, options.outputs, false);
        if (session.json_output || !part) return code;
        const std::vector<RowStatistics> rows =
            statistics_of_rows(session.daemon(), session.daemon().get(resource_path("comparisons", id)));
        print_published(std::cout, structures_of(rows), part->structures);
        print_published_stages(std::cout, rows, part->stages);
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
        if (!options.parts.empty() || !options.scene_folder.empty() || options.builtin)
            throw Failure(ExitCode::Usage, "--part, --scene-folder and --builtin belong to --preset");
        return compare_one(session, options, nullptr);
    }
    const ComparePreset& preset = compare_preset(options.preset);
    if (options.reference_passes && !options.request.reference.empty())
        throw Failure(ExitCode::Usage, "--reference and --reference-passes exclude each other");
    if ((options.builtin && !options.scene_folder.empty()) ||
        (!options.request.scene.empty() && (options.builtin || !options.scene_folder.empty())))
        throw Failure(ExitCode::Usage, "SCENE, --scene-folder and --builtin exclude one another");
    ExitCode worst = ExitCode::Ok;
    for (const PresetComparison* part : with_scenes(session, options, chosen_parts(options, preset))) {
        const ExitCode code = compare_one(session, with_preset(options, *part), part);
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
    command
        ->add_option("--part", options->parts,
                     "only these of the preset's comparisons; on SCENE one, default: the first")
        ->type_name("NAME,NAME")
        ->expected(1)
        ->delimiter(',')
        ->take_all();
    command
        ->add_option("--scene-folder", options->scene_folder,
                     "where the preset's scenes lie that do not come with the program; default: here")
        ->type_name("FOLDER");
    command->add_flag("--builtin", options->builtin, "scenes of the program's own in the place of those");
    command->add_option("--reference-passes", options->reference_passes, "of the preset's reference")
        ->type_name("INT")
        ->check(CLI::Range(1, 1'000'000'000).description(""));
    command->add_option("--frames", options->frames, "of the preset's sequences, where its scenes move")
        ->type_name("INT")
        ->check(CLI::Range(2, 100'000).description(""));
    command->add_option("--fps", options->fps, "frames a second of those")->type_name("NUMBER");
    command->add_option("--videos", options->videos, "save them as MP4 there, a folder for each part")
        ->type_name("FOLDER");
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
