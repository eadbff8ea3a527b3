#include "server/worker/helper_tasks.h"

#include <spdlog/spdlog.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>

#include "protocol/worker_messages.h"
#include "renderer/film/exr_file.h"
#include "renderer/film/film_file.h"
#include "renderer/film/png_file.h"
#include "renderer/film/tone_curve.h"
#include "renderer/scene/baked_scene.h"
#include "server/worker/film_layer.h"
#include "server/worker/helper_errors.h"
#include "server/worker/helper_merge.h"
#include "server/worker/helper_message.h"
#include "server/worker/helper_pictures.h"
#include "server/worker/job_runner.h"
#include "server/worker/preview_image.h"
#include "server/worker/process_memory.h"
#include "server/worker/raw_pixels.h"
#include "server/worker/scene_summary.h"
#include "server/worker/statistics.h"
#include "server/worker/unpack.h"

namespace photond {

using nlohmann::json;

namespace {

constexpr uint64_t kKeptBytes = 512ull << 20;
constexpr uint64_t kWarmSceneDivisor = 4;  // share of the memory limit that a scene kept for the next picture may take

json judge_scene(const json& message) {
    Stats stats;
    const bool builtin = message.contains("builtin") && message["builtin"].is_string();
    const Scene scene = load_scene(SceneSource::from_json(message), {}, stats);
    const std::string name = message.contains("name") && message["name"].is_string()
                                 ? message["name"].get<std::string>()
                                 : (builtin ? message["builtin"].get<std::string>() : "");
    return scene_summary(scene, name, builtin);
}

json unpack(const json& message) {
    return {{"file", unpack_scene(text_of(message, "zip"), text_of(message, "root")).string()}};
}

json bake(const json& message, const HelperLimits& limits) {
    const uint64_t free = message.at("max_bytes").get<uint64_t>();
    Stats stats;
    const Scene scene = load_scene(SceneSource::from_json(message.at("scene")), {}, stats);
    const uint64_t bytes = baked_scene_bytes(scene);
    const auto too_large = [&](ErrorCode code, uint64_t limit, const char* what) {
        if (bytes > limit)
            throw Error(code, "the baked scene takes " + std::to_string(bytes) + " bytes, more than the " +
                                  std::to_string(limit) + " " + what);
    };
    too_large(ErrorCode::OutOfMemory, limits.memory_bytes, "bytes that the helper may hold");
    too_large(ErrorCode::NoSpace, free, "bytes of disk that may be used");
    write_baked_scene(scene, text_of(message, "out"));
    return {{"bytes", bytes}};
}

json judge_image_file(const json& message) {
    const JudgedImage header = judge_image(text_of(message, "path"));
    json layers = json::array();
    for (const NamedLayer& layer : header.layers)
        layers.push_back({{"name", layer.name}, {"channels", layer.channels.size()}});
    return {{"width", header.size.width},
            {"height", header.size.height},
            {"channels", header.channels},
            {"layers", layers}};
}

json encode_exr(const json& message, const HelperLimits& limits) {
    const Film film = FilmFile::load(text_of(message, "film"), limits.memory_bytes).film;
    const std::vector<ImageAttribute> attributes = statistics_attributes(message.value("statistics", json(nullptr)));
    return {{"overflowed", write_exr(film, precision_of(message), attributes, text_of(message, "out"))}};
}

json encode_preview(const json& message, const HelperLimits& limits) {
    const std::string curve_name = text_of(message, "curve");
    const std::optional<ToneCurve> curve = tone_curve_named(curve_name);
    if (!curve)
        throw Error(ErrorCode::UnknownName, "/curve", "curve \"" + curve_name + "\" is neither srgb nor filmic");
    const Film film = FilmFile::load(text_of(message, "film"), limits.memory_bytes).film;
    const std::string layer = message.value("layer", "beauty");
    const float exposure = message.value("exposure", 0.0f);
    const json max_size = message.value("max_size", json(nullptr));
    const LayerInfo* info = nullptr;
    if (layer != "beauty") {
        info = &film_layer(film, layer);
        if (info->preview == LayerPreview::None)
            throw Error(ErrorCode::UnknownName, "/layer", "the layer \"" + layer + "\" has no preview");
    }
    const PreviewImage shown =
        preview_image(film, info, exposure, *curve, max_size.is_null() ? UINT32_MAX : max_size.get<uint32_t>());
    write_png(shown.size, shown.rgb, text_of(message, "out"));
    return json::object();
}

json run_task(const json& message, const HelperLimits& limits, SceneCache& scenes) {
    const std::string type = message.value("type", "");
    if (type == "judge_scene") return judge_scene(message);
    if (type == "unpack") return unpack(message);
    if (type == "thumbnail") return thumbnail(message, limits.memory_bytes, scenes);
    if (type == "preview_scene") return preview_scene(message, limits.memory_bytes, scenes);
    if (type == "bake") return bake(message, limits);
    if (type == "judge_image") return judge_image_file(message);
    if (type == "measure") return measure_images(message, limits.memory_bytes);
    if (type == "encode_difference") return encode_difference(message, limits.memory_bytes);
    if (type == "encode_flip") return encode_flip(message, limits.memory_bytes);
    if (type == "encode_flip_map") return encode_flip_map(message, limits.memory_bytes);
    if (type == "encode_error_map") return encode_error_map(message, limits.memory_bytes);
    if (type == "merge_films") return merge_films(message, limits.memory_bytes);
    if (type == "encode_exr") return encode_exr(message, limits);
    if (type == "encode_preview") return encode_preview(message, limits);
    if (type == "encode_pixels") return encode_pixels(message, limits.memory_bytes);
    throw Error(ErrorCode::UnknownName, "/type", "the helper has no task \"" + type + "\"");
}

/// "result" or "failure" of the request.
struct Outcome {
    json result = nullptr, failure = nullptr;
    bool out_of_memory = false;
};

Outcome try_task(const json& message, const HelperLimits& limits, SceneCache& scenes) {
    Outcome outcome;
    try {
        const tbb::global_control bound(tbb::global_control::max_allowed_parallelism, limits.threads);
        tbb::task_arena arena(static_cast<int>(limits.threads));
        arena.execute([&] { outcome.result = run_task(message, limits, scenes); });
    } catch (const Error& error) {
        outcome.failure = failure_json(error);
        outcome.out_of_memory = error.code == ErrorCode::OutOfMemory;
    } catch (const std::bad_alloc&) {
        outcome.failure = failure_json(ErrorCode::OutOfMemory, "ran out of memory under the helper's limit of " +
                                                                   std::to_string(limits.memory_bytes) + " bytes");
        outcome.out_of_memory = true;
    } catch (const std::exception& defect) {
        spdlog::error("helper task {}: {}", message.value("type", "?"), defect.what());
        outcome.failure = failure_json(ErrorCode::Internal, "internal error in the helper, written to its log");
    }
    return outcome;
}

/// Those that load a scene of their own, as large as may be, or whose traces a second try would find.
bool needs_all_memory(const std::string& type) { return type == "judge_scene" || type == "bake" || type == "unpack"; }
/// Those whose budget the warm scene is part of.
bool draws_scene(const std::string& type) { return type == "thumbnail" || type == "preview_scene"; }

}  // namespace

json run_helper_task(const json& message, const HelperLimits& limits, SceneCache& scenes) noexcept {
    const json named = message.value("type", json(nullptr));
    const std::string type = named.is_string() ? named.get<std::string>() : "";
    if (needs_all_memory(type)) scenes.clear();
    HelperLimits left = limits;
    if (!draws_scene(type)) left.memory_bytes -= std::min(left.memory_bytes, scenes.bytes());
    Outcome outcome = try_task(message, left, scenes);
    if (outcome.out_of_memory && scenes.bytes() > 0) {
        scenes.clear();
        release_free_memory();
        outcome = try_task(message, limits, scenes);
    }
    if (scenes.bytes() > limits.memory_bytes / kWarmSceneDivisor) scenes.clear();
    // Memory kept from one small task to the next saves the kernel clearing it again.
    if (resident_bytes() > kKeptBytes + scenes.bytes()) release_free_memory();
    return {{"type", "reply"},
            {"request", message.value("request", json(nullptr))},
            {"result", outcome.result},
            {"failure", outcome.failure}};
}

}  // namespace photond
