#include "server/service/scenes.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "protocol/helper_messages.h"
#include "protocol/nearest_name.h"
#include "protocol/param_json.h"
#include "renderer/core/sha256.h"
#include "renderer/scene/builtin_scenes.h"
#include "server/clock_text.h"
#include "server/known_answer.h"
#include "server/service/page_cursor.h"
#include "server/service/uploads.h"

namespace photond {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr size_t kMaxBundleFiles = 10'000;
constexpr size_t kMaxNameBytes = 256;

void check_name(const std::string& name) {
    const bool printable =
        std::all_of(name.begin(), name.end(), [](char c) { return static_cast<unsigned char>(c) >= 32 && c != 127; });
    if (name.size() > kMaxNameBytes || !printable || name.find('/') != std::string::npos)
        throw Error(
            ErrorCode::OutOfRange, "/name",
            "a scene's name has at most " + std::to_string(kMaxNameBytes) + " bytes, no control character, no '/'");
    if (is_builtin_scene(name)) throw Error(ErrorCode::Conflict, "/name", "'" + name + "' is a built-in scene");
}

/// The one glTF of an uploaded folder.
fs::path main_file(const std::vector<fs::path>& files) {
    std::vector<fs::path> found;
    for (const fs::path& file : files) {
        std::string extension = file.extension().string();
        std::transform(extension.begin(), extension.end(), extension.begin(),
                       [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
        if (extension == ".gltf" || extension == ".glb") found.push_back(file);
    }
    if (found.size() != 1)
        throw Error(ErrorCode::BadScene, "",
                    "the upload must hold exactly one .gltf or .glb file, found " + std::to_string(found.size()));
    return found.front();
}

constexpr const char* kExposure = "X-Exposure-Stops";

/// To a hundredth, which nobody sees.
std::string exposure_text(const PreviewSceneReply& drawn) {
    std::ostringstream text;
    text << std::round(100 * drawn.exposure_stops) / 100;
    return text.str();
}

std::string bytes_of(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

json scene_object(const SceneRow& row) {
    json object = json::parse(row.summary);
    object.emplace("acceleration_bytes", nullptr);
    object.emplace("photon_yield", nullptr);  // scenes uploaded before it was measured
    object.emplace("default_view", nullptr);  // likewise; get_scene() has it noted
    object.emplace("motion", nullptr);        // likewise
    for (json& camera : object["cameras"]) {
        camera.emplace("look_at", nullptr);
        camera.emplace("aspect", nullptr);
    }
    object["id"] = row.id;
    object["name"] = row.name;
    object["builtin"] = false;
    object["known_answer"] = nullptr;
    return object;
}

}  // namespace

std::optional<SceneRef> Scenes::find_scene(const std::string& id_or_name) {
    if (is_builtin_scene(id_or_name)) return SceneRef{id_or_name, true, std::nullopt};
    auto row = core_.store.scene(id_or_name);
    if (!row) row = core_.store.scene_named(id_or_name);
    if (!row) return std::nullopt;
    return SceneRef{row->id, false, std::move(row)};
}

SceneRef Scenes::require_scene(const std::string& id_or_name) {
    const std::lock_guard lock(core_.mutex);
    if (auto scene = find_scene(id_or_name)) return *std::move(scene);
    throw Error(ErrorCode::NotFound, "there is no scene '" + id_or_name + "'");
}

json Scenes::builtin_object(const std::string& name) {
    {
        const std::lock_guard lock(summaries_mutex_);
        if (const auto found = builtin_summaries_.find(name); found != builtin_summaries_.end()) return *found->second;
    }
    json object = core_.helper->ask(JudgeSceneRequest{.builtin = name});
    object["id"] = object["name"] = name;
    object["builtin"] = true;
    object["bytes"] = 0;
    object["known_answer"] = known_answer_of(name);
    const std::lock_guard lock(summaries_mutex_);
    return *builtin_summaries_.insert_or_assign(name, std::make_shared<const json>(std::move(object))).first->second;
}

void Scenes::know_scene(const std::string& id_or_name) {
    if (!is_builtin_scene(id_or_name)) {
        std::optional<SceneRef> scene;
        {
            const std::lock_guard lock(core_.mutex);
            scene = find_scene(id_or_name);
        }
        if (scene) summary_of(*scene);
        return;
    }
    try {
        builtin_object(id_or_name);
    } catch (const Error& error) {
        spdlog::warn("{} is not judged yet: {}", id_or_name, error.what());
    }
}

std::shared_ptr<const json> Scenes::summary_of(const SceneRef& scene) {
    std::unique_lock lock(summaries_mutex_);
    if (scene.builtin) {
        // One that has not been judged yet counts nothing: the worker holds it to the limit all the same.
        const auto found = builtin_summaries_.find(scene.id);
        return found != builtin_summaries_.end() ? found->second : std::make_shared<const json>(json::object());
    }
    if (last_summary_ && last_text_ == scene.row->summary) return last_summary_;
    lock.unlock();
    const auto summary = std::make_shared<const json>(json::parse(scene.row->summary));
    lock.lock();
    last_text_ = scene.row->summary;
    return last_summary_ = summary;
}

SceneSource Scenes::scene_source(const SceneRef& scene) const {
    if (scene.builtin) return {.id = scene.id, .builtin = scene.id};
    const fs::path root = core_.files.scenes / scene.id;
    return {.id = scene.id, .root = root, .file = root / scene.row->file};
}

Added Scenes::add_scene(SceneUpload upload) {
    Spooled spooled{upload.path};
    check_name(upload.name);

    Spooled root{upload.path};
    fs::path file;  // relative to root
    if (upload.kind == SceneUpload::Kind::Directory) {
        spooled.path.clear();
    } else {
        root.path = core_.files.fresh_spool_path();
        fs::create_directory(root.path);
        if (upload.kind == SceneUpload::Kind::Zip) {
            const UnpackReply unpacked = judged(ErrorCode::BadScene, [&] {
                return core_.bulk_helper->ask(UnpackRequest{upload.path, root.path});
            });
            file = unpacked.file.lexically_relative(root.path);
        } else {
            file = "scene.glb";
            fs::rename(upload.path, root.path / file);
        }
    }
    const std::vector<fs::path> tree = list_tree(root.path, kMaxBundleFiles);
    if (file.empty()) file = main_file(tree);
    if (std::find(tree.begin(), tree.end(), file) == tree.end())
        throw Error(ErrorCode::BadScene, "", "the upload does not hold '" + file.string() + "'");

    SceneRow row;
    row.id = hash_tree(root.path, tree).substr(0, kContentIdDigits);
    row.file = file.generic_string();
    row.name = upload.name.empty() ? row.id : upload.name;
    {
        const std::lock_guard lock(core_.mutex);
        if (const auto known = core_.store.scene(row.id)) return {scene_object(*known), false};
    }
    json summary = judged(ErrorCode::BadScene, [&] {
        return core_.bulk_helper->ask(JudgeSceneRequest{.root = root.path, .file = root.path / file, .name = row.name});
    });
    uint64_t bytes = 0;
    for (const fs::path& part : tree) bytes += fs::file_size(root.path / part);
    summary["bytes"] = bytes;
    row.summary = summary.dump(-1, ' ', false, json::error_handler_t::replace);
    row.created_ms = now_ms();

    const std::lock_guard publish_lock(core_.publish_mutex);
    {
        const std::lock_guard lock(core_.mutex);
        if (const auto known = core_.store.scene(row.id)) return {scene_object(*known), false};
    }
    const fs::path place = core_.files.scenes / row.id;
    core_.note_upload(path_of_scene(row.id));
    remove_quietly(place);  // of a scene whose row never came, or has been deleted
    sync_tree(root.path, tree);
    publish(root.path, place);
    root.path.clear();
    const std::lock_guard lock(core_.mutex);
    auto transaction = core_.store.transaction();
    core_.store.forget_unnamed_file(path_of_scene(row.id));
    core_.store.insert_scene(row);
    transaction.commit();
    return {scene_object(row), true};
}

Page Scenes::list_family(const std::string& family, uint32_t limit, const std::string& cursor) {
    const auto names = builtin_scene_names(family);
    size_t next = cursor.empty() ? 0 : static_cast<size_t>(read_cursor(cursor, 0));
    json items = json::array();
    for (; next < names.size() && items.size() < limit; ++next)
        items.push_back(builtin_object(std::string(names[next])));
    return {{"items", std::move(items)},
            {"next_cursor", next < names.size() ? json(std::to_string(next)) : json()},
            {"tests", family == "hard-cases" ? hard_cases_tested_elsewhere() : json()}};
}

Page Scenes::list_scenes(const std::string& family, uint32_t limit, const std::string& cursor) {
    check_limit(limit);
    if (!family.empty()) return list_family(family, limit, cursor);
    // The built-in scenes are older than any other: after the uploaded ones, in their own order, under "b" and a
    // number.
    const auto names = builtin_scene_names();
    json items = json::array();
    size_t builtin = 0;
    json next;
    if (cursor.starts_with("b")) {
        builtin = static_cast<size_t>(read_cursor(cursor.substr(1), 0));
    } else {
        const std::lock_guard lock(core_.mutex);
        const auto rows = core_.store.scenes(read_cursor(cursor, INT64_MAX), limit);
        for (const SceneRow& row : rows) items.push_back(scene_object(row));
        if (items.size() == limit)
            return {{"items", std::move(items)}, {"next_cursor", std::to_string(rows.back().seq)}, {"tests", nullptr}};
    }
    for (; builtin < names.size() && items.size() < limit; ++builtin)
        items.push_back(builtin_object(std::string(names[builtin])));
    if (builtin < names.size()) next = "b" + std::to_string(builtin);
    return {{"items", std::move(items)}, {"next_cursor", std::move(next)}, {"tests", nullptr}};
}

json Scenes::get_scene(const std::string& id_or_name) {
    SceneRef scene = require_scene(id_or_name);
    if (scene.builtin) return builtin_object(scene.id);
    json object = scene_object(*scene.row);
    if (!object["default_view"].is_null() && !object["motion"].is_null()) return object;
    const SceneSource source = scene_source(scene);
    json summary =
        core_.helper->ask(JudgeSceneRequest{.root = source.root, .file = source.file, .name = scene.row->name});
    summary["bytes"] = object["bytes"];
    scene.row->summary = summary.dump(-1, ' ', false, json::error_handler_t::replace);
    const std::lock_guard lock(core_.mutex);
    core_.store.set_scene_summary(scene.id, scene.row->summary);
    return scene_object(*scene.row);
}

Artefact Scenes::thumbnail(const std::string& id_or_name) {
    const SceneRef scene = require_scene(id_or_name);
    const std::string key = "scene/" + scene.id + "/filtered_thumbnail";  // older daemons kept noisy ones
    return pictures_.picture(key, key, "image/png",
                             [source = scene_source(scene)](const Draughtsman& by, const fs::path& path) {
                                 by.helper.ask(ThumbnailRequest{source, by.most_seconds, path});
                                 return std::map<std::string, std::string>();
                             });
}

DrawnPreview Scenes::scene_preview(const std::string& id_or_name, const ScenePreview& wanted) {
    const SceneRef scene = require_scene(id_or_name);
    if (!wanted.camera.empty()) {
        const json object = get_scene(id_or_name);
        std::vector<std::string> names;
        for (const json& camera : object.at("cameras")) names.push_back(camera.at("name").get<std::string>());
        if (std::find(names.begin(), names.end(), wanted.camera) == names.end())
            throw Error(ErrorCode::UnknownName, "/camera",
                        "the scene has no camera '" + wanted.camera + "'" + did_you_mean(wanted.camera, names));
    }
    const PreviewSceneRequest view{.scene = scene_source(scene),
                                   .camera = wanted.camera,
                                   .look_at = wanted.look_at ? to_json(*wanted.look_at) : json(),
                                   .width = wanted.width,
                                   .height = wanted.height,
                                   .passes = wanted.passes};
    const auto draw = [view](const Draughtsman& by, const fs::path& path) {
        PreviewSceneRequest request = view;
        request.most_seconds = by.most_seconds;
        request.out = path;
        return std::map<std::string, std::string>{{kExposure, exposure_text(by.helper.ask(std::move(request)))}};
    };
    const Spooled out{core_.files.fresh_spool_path()};
    std::map<std::string, std::string> headers;
    if (pictures_.drawn_at_once([&](const Draughtsman& by) { headers = draw(by, out.path); }))
        return {bytes_of(out.path), headers[kExposure]};
    const std::string name = message_json(view).dump();
    const std::string key = "scene/" + scene.id + "/preview/" + sha256_hex(name.data(), name.size());
    Artefact kept = pictures_.picture(key, key, "image/png", draw);
    return {bytes_of(kept.path), kept.headers[kExposure]};
}

Artefact Scenes::baked_scene(const std::string& id_or_name) {
    const SceneRef scene = require_scene(id_or_name);
    return artefact_files_.artefact(
        "scene/" + scene.id + "/baked", "application/octet-stream", [&](const fs::path& path) {
            const uint64_t free = core_.files.free_bytes(), reserve = core_.options.limits.disk_reserve_bytes;
            try {
                core_.bulk_helper->ask(BakeRequest{scene_source(scene), free - std::min(free, reserve), path});
            } catch (const Error& error) {
                switch (error.code) {
                    case ErrorCode::OutOfMemory:
                    case ErrorCode::NoSpace:
                    case ErrorCode::TimedOut:
                        throw Error(error.code, "scene '" + scene.id + "' cannot be baked: " + error.what());
                    default: throw;
                }
            }
            std::string name = scene.id;
            std::replace(name.begin(), name.end(), '/', '-');  // of a family's scenes
            return std::map<std::string, std::string>{
                {"Content-Disposition", "attachment; filename=\"" + name + ".baked\""}};
        });
}

json Scenes::delete_scene(const std::string& id_or_name) {
    const std::lock_guard publish_lock(core_.publish_mutex);
    const std::lock_guard lock(core_.mutex);
    const auto scene = find_scene(id_or_name);
    if (!scene) throw Error(ErrorCode::NotFound, "there is no scene '" + id_or_name + "'");
    if (scene->builtin) throw Error(ErrorCode::WrongState, "'" + id_or_name + "' is a built-in scene, always there");
    if (const int64_t users = core_.store.unfinished_jobs_of_scene(scene->id); users > 0)
        throw Error(ErrorCode::WrongState, std::to_string(users) + " jobs that are not over use this scene");
    auto transaction = core_.store.transaction();
    core_.store.delete_scene(scene->id);
    core_.store.note_unnamed_file(path_of_scene(scene->id));
    transaction.commit();
    core_.artefacts.forget("scene/" + scene->id + "/");
    remove_quietly(core_.files.scenes / scene->id);
    core_.store.unnamed_file_is_gone(path_of_scene(scene->id));
    return scene_object(*scene->row);
}

}  // namespace photond
