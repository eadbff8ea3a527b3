// photonctl scenes add|list|show|remove, and bake

#include <iostream>

#include "clients/cli/commands.h"
#include "clients/cli/scene_upload.h"
#include "clients/cli/text_table.h"
#include "clients/cli/transfer.h"
#include "clients/cli/units.h"
#include "clients/cli/upload.h"
#include "protocol/scene_families.h"

namespace photond::cli {

namespace {

using nlohmann::json;

std::string count_cell(const json& scene, const char* key) {
    return scene.contains(key) && scene[key].is_number() ? human_count(scene[key].get<double>()) : "-";
}

std::string lights_text(const json& lights) {
    if (!lights.is_object()) return "-";
    std::string text;
    for (const auto& [kind, count] : lights.items()) {
        const bool some = count.is_boolean() ? count.get<bool>() : count.is_number() && count.get<double>() > 0;
        if (some)
            text +=
                (text.empty() ? "" : ", ") + (count.is_boolean() ? "" : human_count(count.get<double>()) + " ") + kind;
    }
    return text.empty() ? "none" : text;
}

std::string point_text(const json& point) {
    std::string text;
    if (point.is_array())
        for (const json& coordinate : point) text += (text.empty() ? "" : " ") + plain_text(coordinate);
    return text;
}

std::string camera_names(const json& scene) {
    std::string names;
    if (scene.contains("cameras") && scene["cameras"].is_array())
        for (const json& camera : scene["cameras"])
            names += (names.empty() ? "" : ", ") + plain_text(camera.value("name", json()));
    return names.empty() ? "none: views are framed on the scene's bounds" : names;
}

/// "walk, 2.5 s: moves 3 meshes, 1 camera".
std::string motion_text(const json& animation) {
    const json moves = animation.value("moves", json::object());
    std::string moved;
    const auto add = [&](const char* key, const std::string& what, const char* plural = "s") {
        const int64_t count = moves.value(key, int64_t{0});
        if (count == 0) return;
        moved += (moved.empty() ? "moves " : ", ") + std::to_string(count) + " " + what + (count == 1 ? "" : plural);
    };
    add("meshes", "mesh", "es"), add("cameras", "camera"), add("lights", "light"), add("materials", "material");
    char seconds[32];
    std::snprintf(seconds, sizeof seconds, "%.3g s", animation.value("duration_seconds", 0.0));
    const std::string name = plain_text(animation.value("name", json()));
    return (name.empty() ? "" : name + ", ") + seconds + ": " +
           (moved.empty() ? "moves nothing that is rendered" : moved);
}

void print_scene(const Session& session, const json& scene) {
    std::cout << session.bold(plain_text(scene.value("name", json()))) << '\n';
    TextTable table({{""}, {""}});
    table.add_row({"id", plain_text(scene.value("id", json()))});
    const json bytes = scene.value("bytes", json());
    table.add_row({"size", scene.value("builtin", false) ? "built in"
                           : bytes.is_number()           ? human_bytes(bytes.get<double>())
                                                         : "-"});
    for (const char* key : {"triangles", "vertices", "materials", "textures", "animations"})
        table.add_row({key, count_cell(scene, key)});
    table.add_row({"lights", lights_text(scene.value("lights", json()))});
    table.add_row({"cameras", camera_names(scene)});
    const json motion = scene.value("motion", json());
    for (const json& animation : motion.is_array() ? motion : json::array())
        table.add_row({"animation " + animation.value("index", json()).dump(), motion_text(animation)});
    const json bounds = scene.value("bounds", json());
    if (bounds.is_object())
        table.add_row({"bounds", "(" + point_text(bounds.value("min", json())) + ") to (" +
                                     point_text(bounds.value("max", json())) + ") m"});
    table.print(std::cout, "  ");
    const json warnings = scene.value("warnings", json::array());
    for (const json& warning : warnings) std::cout << "  warning: " << plain_text(warning) << '\n';
}

ExitCode add_scenes(Session& session, const std::vector<std::string>& paths, const std::string& name) {
    for (const std::string& path : paths) {
        const UploadedScene added = upload_scene(session, path, name);
        if (session.json_output)
            session.print_json(added.scene);
        else
            print_scene(session, added.scene);
    }
    return ExitCode::Ok;
}

std::string family_names() {
    std::string names;
    for (const std::string_view family : kSceneFamilies) names.append(names.empty() ? "" : ", ").append(family);
    return names;
}

ExitCode list_scenes(Session& session, const std::string& family, size_t limit) {
    const std::string path = "/v1/scenes" + (family.empty() ? "" : "?family=" + percent_encode(family));
    const std::vector<json> scenes = session.daemon().list(path, limit);
    TextTable table({{"NAME"},
                     {"TRIANGLES", Align::Right},
                     {"TEXTURES", Align::Right},
                     {"LIGHTS"},
                     {"SIZE", Align::Right},
                     {"ID"}});
    for (const json& scene : scenes) {
        if (session.json_output) {
            session.print_json(scene);
            continue;
        }
        const json bytes = scene.value("bytes", json());
        table.add_row(
            {plain_text(scene.value("name", json())), count_cell(scene, "triangles"), count_cell(scene, "textures"),
             lights_text(scene.value("lights", json())),
             scene.value("builtin", false) || !bytes.is_number() ? "built in" : human_bytes(bytes.get<double>()),
             plain_text(scene.value("id", json()))});
    }
    if (session.json_output) return ExitCode::Ok;
    table.print(std::cout);
    if (family.empty()) session.remark("more built-in scenes by --family: " + family_names());
    return ExitCode::Ok;
}

ExitCode show_scene(Session& session, const std::string& scene_name, const std::string& thumbnail) {
    const std::string path = resource_path("scenes", scene_name);
    const json scene = session.daemon().get(path);
    if (session.json_output)
        session.print_json(scene);
    else
        print_scene(session, scene);
    if (!thumbnail.empty()) save_resource(session, path + "/thumbnail.png", thumbnail);
    return ExitCode::Ok;
}

ExitCode remove_scenes(Session& session, const std::vector<std::string>& names) {
    for (const std::string& name : names) {
        HttpRequest request;
        request.method = "DELETE";
        request.path = resource_path("scenes", name);
        session.daemon().ask(request, Repeat::OnlyIfRefused);
        session.remark("removed " + name);
    }
    return ExitCode::Ok;
}

ExitCode bake_scene(Session& session, const std::string& scene_name, const std::string& file) {
    const json scene = looks_like_scene_path(scene_name) ? upload_scene(session, scene_name, "").scene
                                                         : session.daemon().get(resource_path("scenes", scene_name));
    save_resource(session, resource_path("scenes", scene.at("id").get<std::string>()) + "/baked", file);
    if (session.json_output) session.print_json(scene);
    return ExitCode::Ok;
}

}  // namespace

void add_scenes_commands(CLI::App& program, Session& session) {
    CLI::App* scenes = program.add_subcommand("scenes", "Scenes the daemon holds: add, list, show, remove");
    scenes->require_subcommand(1);

    struct Options {
        std::vector<std::string> arguments;
        std::string name, thumbnail, family;
        size_t limit = 1000;
    };
    const auto options = std::make_shared<Options>();

    CLI::App* add = scenes->add_subcommand("add", "Upload .glb, .zip, .gltf with all its files, or a folder with one");
    add->add_option("path", options->arguments, "what to upload")->required()->type_name("FILE");
    add->add_option("--name", options->name, "name of the scene; default: the file's")->type_name("TEXT");
    add->callback([&session, options] {
        session.action = [&session, options] {
            if (options->arguments.size() > 1 && !options->name.empty())
                throw Failure(ExitCode::Usage,
                              "--name fits one scene, and " + std::to_string(options->arguments.size()) + " are given");
            return add_scenes(session, options->arguments, options->name);
        };
    });

    CLI::App* list = scenes->add_subcommand("list", "All scenes, newest first, and the built-in ones");
    list->add_option("--limit", options->limit, "at most this many")->type_name("INT")->capture_default_str();
    list->add_option("--family", options->family, "built-in scenes of a family instead: " + family_names())
        ->type_name("NAME");
    list->callback([&session, options] {
        session.action = [&session, options] { return list_scenes(session, options->family, options->limit); };
    });

    CLI::App* show = scenes->add_subcommand("show", "What is in a scene, and what was wrong with it");
    show->add_option("scene", options->arguments, "id or name")->required()->expected(1)->type_name("SCENE");
    show->add_option("--thumbnail", options->thumbnail, "save its thumbnail (PNG)")->type_name("FILE");
    show->callback([&session, options] {
        session.action = [&session, options] {
            return show_scene(session, options->arguments.front(), options->thumbnail);
        };
    });

    CLI::App* remove = scenes->add_subcommand("remove", "Remove scenes; refused while a job uses one");
    remove->add_option("scene", options->arguments, "ids or names")->required()->type_name("SCENE");
    remove->callback([&session, options] {
        session.action = [&session, options] { return remove_scenes(session, options->arguments); };
    });

    CLI::App* bake = program.add_subcommand(
        "bake", "Save a scene as one file, textures decoded, for photond-gpu-bench on a machine without a daemon");
    const auto baked = std::make_shared<std::pair<std::string, std::string>>();
    bake->add_option("scene", baked->first, "id or name, or a path: .glb, .zip, .gltf with all its files, or a folder")
        ->required()
        ->type_name("SCENE");
    bake->add_option("out", baked->second, "the file to write, such as scene.baked")->required()->type_name("FILE");
    bake->callback([&session, baked] {
        session.action = [&session, baked] { return bake_scene(session, baked->first, baked->second); };
    });
}

}  // namespace photond::cli
