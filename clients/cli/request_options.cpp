#include "clients/cli/request_options.h"

#include <charconv>
#include <fstream>
#include <iostream>
#include <random>
#include <sstream>

#include "clients/cli/method_catalogue.h"
#include "clients/cli/reference_option.h"
#include "clients/cli/scene_upload.h"
#include "clients/cli/units.h"
#include "clients/cli/upload.h"

namespace photond::cli {

using nlohmann::json;

namespace {

constexpr uint32_t kDefaultEdgePixels = 512;

/// Those of a list "0,0.5,1"; empty when something in it is no number.
std::vector<double> numbers_of(const std::string& list) {
    std::vector<double> numbers;
    for (const std::string& piece : split(list, ',')) {
        double x = 0;
        const auto [end, error] = std::from_chars(piece.data(), piece.data() + piece.size(), x);
        if (piece.empty() || error != std::errc() || end != piece.data() + piece.size()) return {};
        numbers.push_back(x);
    }
    return numbers;
}

/// --target was where the camera looks before it was what the error is to reach: X,Y,Z still is a point.
void part_targets(RequestOptions& options) {
    std::vector<std::string> errors;
    for (const std::string& target : options.stop.error_target) {
        const std::vector<double> point = numbers_of(target);
        if (point.size() == 3)
            options.look_at = point;
        else
            errors.push_back(target);
    }
    options.stop.error_target = errors;
}

void put_camera(json& request, const RequestOptions& options) {
    json& camera = object_in(request, "camera");
    if (!options.camera.empty()) camera["name"] = options.camera;
    if (options.eye.empty() != options.look_at.empty())
        throw Failure(ExitCode::Usage, "--eye and --look-at belong together");
    if (options.eye.empty() && (!options.up.empty() || options.yfov))
        throw Failure(ExitCode::Usage, "--up and --yfov belong to --eye and --look-at");
    if (!options.eye.empty()) {
        if (!options.camera.empty()) throw Failure(ExitCode::Usage, "--camera and --eye exclude each other");
        camera.erase("name");
        camera["look_at"] = {{"eye", options.eye}, {"target", options.look_at}};
        if (!options.up.empty()) camera["look_at"]["up"] = options.up;
        if (options.yfov) camera["look_at"]["yfov"] = *options.yfov;
    }
    if (options.aperture) camera["aperture"] = *options.aperture;
    if (options.focus_distance) camera["focus_distance"] = *options.focus_distance;
    if (camera.empty()) request.erase("camera");
}

void send_scene(Session& session, json& request, const RequestOptions& options) {
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

void send_environment(Session& session, json& request, const RequestOptions& options) {
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

}  // namespace

void add_source_options(CLI::App& command, RequestOptions& options) {
    command
        .add_option("scene", options.scene,
                    "name or id of a scene, or a path to send: .glb, .zip, .gltf with its files, folder")
        ->type_name("SCENE");
    command
        .add_option("--request", options.request_file,
                    "start from this request in JSON ('-': standard input); options change it")
        ->type_name("FILE");
    command
        .add_option("--idempotency-key", options.idempotency_key,
                    "the same key and request is the same submission; default: random")
        ->type_name("TEXT");
}

void add_image_options(CLI::App& command, RequestOptions& options, const std::vector<std::string>& layers) {
    const auto add = [&](const char* name, auto& value, const std::string& text, const char* type) {
        return command.add_option(name, value, text)->type_name(type);
    };
    add("--width", options.width, "pixels; default: 512. The image may have 67,108,864 (photond --max-pixels)", "INT");
    add("--height", options.height, "pixels; default: 512", "INT");
    std::string layers_text = "more layers for the EXR, separated by commas";
    for (const std::string& layer : layers) layers_text += (layer == layers.front() ? ": " : ", ") + layer;
    add("--layers", options.layers, layers_text, "LAYERS")->expected(1)->delimiter(',')->take_all();
    add("--filter", options.filter, "pixel filter; default: box", "box|gaussian|blackman_harris");
    add("--priority", options.priority, "-100 to 100, higher first; default: 0", "INT");
    command
        .add_flag("--quiet-machine{600}", options.quiet_seconds,
                  "begin when nothing else runs on the daemon's machine, or after 600 seconds, or =SECONDS")
        ->type_name("SECONDS");
    add("--label", options.labels, "note on the job, to find it by; may be repeated", "KEY=VALUE")
        ->expected(1)
        ->take_all();
    add_reference_options(command, options.reference, options.metrics);
}

void add_view_options(CLI::App& command, RequestOptions& options) {
    const char* group = "Camera and light";
    command.add_option("--camera", options.camera, "name of one of the scene's cameras; default: its first")
        ->type_name("CAMERA")
        ->group(group);
    const auto point = [&](const char* name, std::vector<double>& value, const char* text) {
        command.add_option(name, value, text)->expected(3)->delimiter(',')->type_name("X,Y,Z")->group(group);
    };
    point("--eye", options.eye, "look from here [m]");
    point("--look-at", options.look_at, "look at this [m]");
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
    number("--animation", options.animation,
           "name or index of one of the scene's; default: none, or with --time the first", "NAME");
    number("--time", options.time, "moment of the animation [s]", "SECONDS");
    number("--shutter", options.shutter, "keep it open for so long from that moment on [s]; default: 0", "SECONDS");
}

/// "2" is an index, and any other text a name.
json name_or_index(const std::string& text) {
    const bool whole = text.size() < 6 && text.find_first_not_of("0123456789") == text.npos;
    return whole ? json(std::stoul(text)) : json(text);
}

json read_json_file(const std::string& file) {
    std::ifstream in(file);
    std::istream& source = file == "-" ? std::cin : in;
    if (!source) throw Failure(ExitCode::Usage, "cannot read " + file);
    json request = json::parse(source, nullptr, false);
    if (!request.is_object()) throw Failure(ExitCode::Usage, file + " is not a JSON object");
    return request;
}

json start_request(const RequestOptions& given) {
    RequestOptions options = given;
    part_targets(options);
    json request = options.request_file.empty() ? json::object() : read_json_file(options.request_file);
    json& image = object_in(request, "image");
    image["width"] = options.width.value_or(image.value("width", kDefaultEdgePixels));
    image["height"] = options.height.value_or(image.value("height", kDefaultEdgePixels));
    if (!options.filter.empty()) image["filter"] = options.filter;
    if (options.stop.any()) request["stop"] = options.stop.body();
    put_camera(request, options);
    if (options.priority) request["priority"] = *options.priority;
    if (options.quiet_seconds >= 0) request["quiet_machine"] = options.quiet_seconds;
    if (options.time) request["time"] = *options.time;
    if (options.shutter) request["shutter"] = *options.shutter;
    if (!options.animation.empty()) request["animation"] = name_or_index(options.animation);
    if (!options.glass.empty()) request["glass"] = options.glass;
    if (!options.layers.empty()) request["layers"] = options.layers;
    if (!options.metrics.empty()) request["metrics"] = options.metrics;
    for (const std::string& label : options.labels) {
        const auto [key, value] = key_and_value(label, "--label");
        object_in(request, "labels")[key] = value;
    }
    return request;
}

void send_parts(Session& session, json& request, const RequestOptions& options) {
    send_scene(session, request, options);
    send_environment(session, request, options);
    if (!options.reference.empty()) request["reference"] = reference_from(session, options.reference);
}

json submit(Session& session, const std::string& path, const json& request, const std::string& idempotency_key) {
    HttpRequest submission;
    submission.method = "POST";
    submission.path = path;
    submission.body = request.dump();
    submission.content_type = "application/json";
    submission.headers.emplace_back("Idempotency-Key", idempotency_key.empty() ? random_key() : idempotency_key);
    return json_of(session.daemon().ask(submission, Repeat::Safely));
}

json& object_in(json& request, const char* key) {
    json& member = request.emplace(key, json::object()).first.value();
    if (!member.is_object()) throw Failure(ExitCode::Usage, std::string(key) + " in --request is not an object");
    return member;
}

}  // namespace photond::cli
