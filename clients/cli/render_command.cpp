// photonctl render SCENE

#include <algorithm>
#include <fstream>
#include <iostream>
#include <map>
#include <random>
#include <sstream>

#include "clients/cli/commands.h"
#include "clients/cli/job_view.h"
#include "clients/cli/scene_upload.h"
#include "clients/cli/statistics_report.h"
#include "clients/cli/units.h"
#include "clients/cli/upload.h"
#include "protocol/nearest_name.h"

namespace photond::cli {

namespace {

using nlohmann::json;

constexpr uint32_t kDefaultEdgePixels = 512;
constexpr uint32_t kDefaultPasses = 64;

/// What the command line says; empty: not given, so that --request and the daemon's defaults stand.
struct RenderOptions {
    std::string scene, request_file, method, device, filter, glass, camera, environment;
    std::optional<uint32_t> width, height, passes;
    std::optional<double> seconds, yfov, aperture, focus_distance, environment_scale, environment_rotation, time;
    std::optional<uint64_t> seed;
    std::optional<int> priority;
    std::vector<double> eye, target, up;
    std::vector<std::string> layers, labels, settings;
    std::map<std::string, std::string> parameters;  // by wire name, from --parameter-name options
    std::string idempotency_key;
    bool no_wait = false;
    bool dry_run = false;
    WaitOptions wait;
    JobOutputs outputs;
};

json read_request(const std::string& file) {
    std::ifstream in(file);
    std::istream& source = file == "-" ? std::cin : in;
    if (!source) throw Failure(ExitCode::Usage, "cannot read " + file);
    json request = json::parse(source, nullptr, false);
    if (!request.is_object()) throw Failure(ExitCode::Usage, file + " is not a JSON object");
    return request;
}

/// The member that is an object, made where there is none.
json& object_in(json& request, const char* key) {
    json& member = request.emplace(key, json::object()).first.value();
    if (!member.is_object()) throw Failure(ExitCode::Usage, std::string(key) + " in --request is not an object");
    return member;
}

std::pair<std::string, std::string> key_and_value(const std::string& text, const char* option) {
    const size_t equals = text.find('=');
    if (equals == 0 || equals == std::string::npos)
        throw Failure(ExitCode::Usage, std::string(option) + " " + text + " is not KEY=VALUE");
    return {text.substr(0, equals), text.substr(equals + 1)};
}

/// Parameters of the command line over those of the request; every name and value checked against the schema.
void add_parameters(json& parameters, const RenderOptions& options, const RenderVocabulary& vocabulary) {
    std::map<std::string, std::string> given = options.parameters;
    if (!options.outputs.photon_map.empty()) given.emplace("keep_photon_map", "true");
    for (const std::string& setting : options.settings)
        given.insert_or_assign(key_and_value(setting, "--set").first, key_and_value(setting, "--set").second);
    for (const auto& [name, text] : given) {
        const auto found = std::find_if(vocabulary.parameters.begin(), vocabulary.parameters.end(),
                                        [&key = name](const Parameter& parameter) { return parameter.name == key; });
        if (found == vocabulary.parameters.end()) {
            std::vector<std::string> known;
            for (const Parameter& parameter : vocabulary.parameters) known.push_back(parameter.name);
            const std::string near = nearest_name(name, known);
            throw Failure(
                ExitCode::Usage, vocabulary.method + " has no parameter " + printable(name),
                near.empty() ? "photonctl methods " + vocabulary.method + " lists them" : "did you mean " + near + "?");
        }
        parameters[name] = found->parse(text);
    }
}

void add_camera(json& request, const RenderOptions& options) {
    json& camera = object_in(request, "camera");
    if (!options.camera.empty()) camera["name"] = options.camera;
    if (options.eye.empty() != options.target.empty())
        throw Failure(ExitCode::Usage, "--eye and --target belong together");
    if (options.eye.empty() && (!options.up.empty() || options.yfov))
        throw Failure(ExitCode::Usage, "--up and --yfov belong to --eye and --target");
    if (!options.eye.empty()) {
        if (!options.camera.empty()) throw Failure(ExitCode::Usage, "--camera and --eye exclude each other");
        camera.erase("name");
        camera["look_at"] = {{"eye", options.eye}, {"target", options.target}};
        if (!options.up.empty()) camera["look_at"]["up"] = options.up;
        if (options.yfov) camera["look_at"]["yfov"] = *options.yfov;
    }
    if (options.aperture) camera["aperture"] = *options.aperture;
    if (options.focus_distance) camera["focus_distance"] = *options.focus_distance;
    if (camera.empty()) request.erase("camera");
}

/// The job but for its scene and environment, which may have to be sent first.
json build_request(const RenderOptions& options, const RenderVocabulary& vocabulary) {
    json request = options.request_file.empty() ? json::object() : read_request(options.request_file);
    const auto set = [&request](const char* key, const auto& value) {
        if (value) request[key] = *value;
    };
    json& image = object_in(request, "image");
    image["width"] = options.width.value_or(image.value("width", kDefaultEdgePixels));
    image["height"] = options.height.value_or(image.value("height", kDefaultEdgePixels));
    if (!options.filter.empty()) image["filter"] = options.filter;

    json& method = object_in(request, "method");
    method["name"] = vocabulary.method;
    if (!options.device.empty()) method["device"] = options.device;
    add_parameters(object_in(method, "parameters"), options, vocabulary);

    if (options.passes || options.seconds) {
        request["stop"] = json::object();
        if (options.passes) request["stop"]["passes"] = *options.passes;
        if (options.seconds) request["stop"]["seconds"] = *options.seconds;
    } else if (!request.contains("stop")) {
        request["stop"] = {{"passes", kDefaultPasses}};
    }
    add_camera(request, options);
    set("seed", options.seed);
    set("priority", options.priority);
    set("time", options.time);
    if (!options.glass.empty()) request["glass"] = options.glass;
    if (!options.layers.empty()) request["layers"] = options.layers;
    for (const std::string& label : options.labels) {
        const auto [key, value] = key_and_value(label, "--label");
        object_in(request, "labels")[key] = value;
    }
    return request;
}

void add_scene(Session& session, json& request, const RenderOptions& options) {
    if (options.scene.empty()) {
        if (!request.contains("scene"))
            throw Failure(ExitCode::Usage, "which scene? a name, an id or a path is needed",
                          "photonctl scenes list shows what is there");
        return;
    }
    request["scene"] = looks_like_scene_path(options.scene)
                           ? upload_scene(session, options.scene, "").scene.at("id").get<std::string>()
                           : options.scene;
}

void add_environment(Session& session, json& request, const RenderOptions& options) {
    if (options.environment.empty()) {
        if ((options.environment_scale || options.environment_rotation) && !request.contains("environment"))
            throw Failure(ExitCode::Usage, "--environment-scale and --environment-rotation belong to --environment");
    } else {
        object_in(request, "environment")["image"] = options.environment.starts_with("image:")
                                                         ? options.environment
                                                         : "image:" + upload_image(session, options.environment);
    }
    if (options.environment_scale) object_in(request, "environment")["scale"] = *options.environment_scale;
    if (options.environment_rotation) object_in(request, "environment")["rotation"] = *options.environment_rotation;
}

/// 128 random bits: a repeat of this submission, and nothing else, will carry them.
std::string random_key() {
    std::random_device device;
    std::ostringstream key;
    key << "photonctl-" << std::hex;
    for (int i = 0; i < 4; ++i) key << device();
    return key.str();
}

ExitCode print_estimate(Session& session, const json& request) {
    const json estimate = session.daemon().send("POST", "/v1/jobs?dry_run=true", request, Repeat::Safely);
    if (session.json_output) {
        session.print_json(estimate);
        return ExitCode::Ok;
    }
    const json seconds = estimate.value("seconds", json());
    std::cout << "memory " << human_bytes(estimate.at("memory_bytes").get<double>()) << "\ntime   "
              << (seconds.is_number() ? human_seconds(seconds.get<double>())
                                      : "not known: the daemon has rendered nothing with this method yet")
              << '\n';
    return ExitCode::Ok;
}

ExitCode render(Session& session, const RenderOptions& options, const RenderVocabulary& vocabulary) {
    options.outputs.check();
    if (options.no_wait && (options.outputs.any() || options.wait.timeout_seconds > 0))
        throw Failure(ExitCode::Usage, "--no-wait saves nothing and needs no --timeout",
                      "photonctl jobs fetch saves it later");
    if (options.dry_run && (options.no_wait || options.outputs.any() || options.wait.timeout_seconds > 0))
        throw Failure(ExitCode::Usage, "--dry-run renders nothing: there is nothing to save or to wait for");
    json request = build_request(options, vocabulary);
    add_scene(session, request, options);
    add_environment(session, request, options);
    if (options.dry_run) return print_estimate(session, request);

    HttpRequest submission;
    submission.method = "POST";
    submission.path = "/v1/jobs";
    submission.body = request.dump();
    submission.content_type = "application/json";
    submission.headers.emplace_back("Idempotency-Key",
                                    options.idempotency_key.empty() ? random_key() : options.idempotency_key);
    const json accepted = json_of(session.daemon().ask(submission, Repeat::Safely));
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

void add_view_options(CLI::App& command, RenderOptions& options) {
    const char* group = "Camera and light";
    command.add_option("--camera", options.camera, "name of one of the scene's cameras; default: its first")
        ->type_name("CAMERA")
        ->group(group);
    const auto point = [&](const char* name, std::vector<double>& value, const char* text) {
        command.add_option(name, value, text)->expected(3)->delimiter(',')->type_name("X,Y,Z")->group(group);
    };
    point("--eye", options.eye, "look from here [m]");
    point("--target", options.target, "look at this [m]");
    point("--up", options.up, "upward direction; default: 0,1,0");
    const auto number = [&](const char* name, auto& value, const char* text, const char* type) {
        command.add_option(name, value, text)->type_name(type)->group(group);
    };
    number("--yfov", options.yfov, "vertical angle of view [radians]", "RADIANS");
    number("--aperture", options.aperture, "radius of the lens [m]; default: 0, everything is sharp", "METRES");
    number("--focus-distance", options.focus_distance, "distance that is sharp [m]", "METRES");
    number("--environment", options.environment, "light all around: .hdr or .exr to send, or image:ID", "FILE");
    number("--environment-scale", options.environment_scale, "factor on its radiance; default: 1", "NUMBER");
    number("--environment-rotation", options.environment_rotation, "turn it about +Y [radians]; default: 0", "RADIANS");
    number("--glass", options.glass, "sheets as the scene says, or every closed transmissive mesh a solid",
           "as_stored|solid");
    number("--time", options.time, "moment of the animation [s]; default: 0", "SECONDS");
}

}  // namespace

RenderVocabulary ask_render_vocabulary(Session& session, const std::vector<std::string>& arguments) {
    RenderVocabulary vocabulary;
    vocabulary.method = argument_of(arguments, {"--method", "-m"});
    if (const std::string file = argument_of(arguments, {"--request"});
        vocabulary.method.empty() && !file.empty() && file != "-") {
        const json request = read_request(file);
        if (request.contains("method") && request["method"].is_object())
            vocabulary.method = request["method"].value("name", "");
    }
    if (vocabulary.method.empty()) vocabulary.method = kDefaultMethod;
    std::vector<std::string> names;
    const json methods = session.daemon().get("/v1/methods").at("items");
    for (const json& method : methods) {
        names.push_back(method.value("name", ""));
        if (names.back() != vocabulary.method) continue;
        vocabulary.parameters = parameters_of(method);
        for (const json& layer : method.value("layers", json::array())) vocabulary.layers.push_back(plain_text(layer));
        vocabulary.known = true;
    }
    if (!vocabulary.known) {
        const std::string near = nearest_name(vocabulary.method, names);
        throw Failure(ExitCode::Usage, "the daemon has no method " + printable(vocabulary.method),
                      near.empty() ? "photonctl methods lists them" : "did you mean " + near + "?");
    }
    return vocabulary;
}

void add_render_command(CLI::App& program, Session& session, const RenderVocabulary& vocabulary) {
    CLI::App* command = program.add_subcommand("render", "Render a scene: submit, watch, save");
    const auto options = std::make_shared<RenderOptions>();
    const auto add = [&](const char* name, auto& value, const char* text, const char* type) {
        return command->add_option(name, value, text)->type_name(type);
    };
    add("scene", options->scene, "name or id of a scene, or a path to send: .glb, .zip, .gltf with its files, folder",
        "SCENE");
    add("-m,--method", options->method, "method of light transport; default: path_tracing", "METHOD");
    add("--device", options->device, "where to render; default: cpu", "DEVICE");
    add("--set", options->settings, "set a parameter of the method; may be repeated", "NAME=VALUE")
        ->expected(1)
        ->take_all();
    add("--width", options->width, "pixels; default: 512", "INT");
    add("--height", options->height, "pixels; default: 512", "INT");
    add("--passes", options->passes, "stop after this many samples a pixel; default, without --seconds: 64", "INT");
    add("--seconds", options->seconds, "stop after rendering this long", "SECONDS");
    add("--seed", options->seed, "of the random numbers; default: 1", "INT");
    std::string layers_text = "more layers for the EXR, separated by commas";
    for (const std::string& layer : vocabulary.layers)
        layers_text += (layer == vocabulary.layers.front() ? ": " : ", ") + layer;
    add("--layers", options->layers, layers_text.c_str(), "LAYERS")->expected(1)->delimiter(',')->take_all();
    add("--filter", options->filter, "pixel filter; default: box", "box|gaussian|blackman_harris");
    add("--priority", options->priority, "-100 to 100, higher first; default: 0", "INT");
    add("--label", options->labels, "note on the job, to find it by; may be repeated", "KEY=VALUE")
        ->expected(1)
        ->take_all();
    add("--request", options->request_file, "start from this job in JSON ('-': standard input); options change it",
        "FILE");
    add_output_options(*command, options->outputs);
    command->add_flag("--dry-run", options->dry_run,
                      "print the memory and the time it would take, and render nothing; files it needs are sent");
    command->add_flag("--no-wait", options->no_wait, "print the job's id and leave");
    add("--idempotency-key", options->idempotency_key, "the same key and job is the same submission; default: random",
        "TEXT");
    add_wait_options(*command, options->wait);
    add_view_options(*command, *options);

    for (const Parameter& parameter : vocabulary.parameters) {
        if (command->get_option_no_throw(parameter.option_name()))
            continue;  // the name is taken: --set still reaches it
        command
            ->add_option_function<std::string>(
                parameter.option_name(),
                [options, name = parameter.name](const std::string& text) { options->parameters[name] = text; },
                parameter.help())
            ->type_name(parameter.value_name())
            ->group("Parameters of " + vocabulary.method);
    }
    if (!vocabulary.known)
        command->footer("The parameters of a method are listed here when the daemon can be reached.");
    command->callback([&session, options, vocabulary] {
        session.action = [&session, options, vocabulary] { return render(session, *options, vocabulary); };
    });
}

}  // namespace photond::cli
