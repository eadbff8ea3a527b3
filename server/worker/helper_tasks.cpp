#include "server/worker/helper_tasks.h"

#include <spdlog/spdlog.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>

#include "protocol/worker_messages.h"
#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/core/atomic_file.h"
#include "renderer/film/exr_file.h"
#include "renderer/film/film_file.h"
#include "renderer/film/png_file.h"
#include "renderer/film/tone_curve.h"
#include "renderer/scene/baked_scene.h"
#include "server/worker/helper_errors.h"
#include "server/worker/helper_merge.h"
#include "server/worker/helper_message.h"
#include "server/worker/job_runner.h"
#include "server/worker/preview_image.h"
#include "server/worker/process_memory.h"
#include "server/worker/scene_summary.h"
#include "server/worker/statistics.h"
#include "server/worker/unpack.h"

namespace photond {

using nlohmann::json;

namespace {

constexpr uint32_t kThumbnailWidth = 256, kThumbnailHeight = 192, kThumbnailPasses = 32;
constexpr double kThumbnailSeconds = 1;  // other tasks wait meanwhile
constexpr uint32_t kThumbnailBounces = 3;
constexpr uint64_t kKeptBytes = 512ull << 20;

Precision precision_of(const json& message) {
    const std::string name = text_of(message, "precision");
    if (name == "float") return Precision::Float;
    if (name == "half") return Precision::Half;
    throw Error(ErrorCode::UnknownName, "/precision", "precision \"" + name + "\" is neither float nor half");
}

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

/// A scene that brings no light is shown under a white sky: a thumbnail is there to recognise a scene by.
void light_if_dark(Scene& scene) {
    const Needs& needs = scene.needs;
    if (needs.area_lights || needs.punctual_lights || needs.environment || needs.unlit) return;
    Environment sky;
    sky.map.size = {2, 1};
    sky.map.radiance.assign(2, Rgb(1));
    scene.environment = std::move(sky);
    scene.needs = find_needs(scene);
}

/// Means over tiles of 8x8 pixels: what the eye averages in a noisy image, from which to judge its exposure.
std::vector<float> tile_means(const std::vector<float>& rgb, Size2 size) {
    constexpr size_t kTile = 8;
    static_assert(kThumbnailWidth % kTile == 0 && kThumbnailHeight % kTile == 0, "whole tiles only");
    const size_t columns = size.width / kTile;
    std::vector<float> means(3 * columns * (size.height / kTile));
    for (size_t y = 0; y < size.height; ++y)
        for (size_t x = 0; x < size.width; ++x)
            for (size_t k = 0; k < 3; ++k)
                means[3 * (y / kTile * columns + x / kTile) + k] += rgb[3 * (y * size.width + x) + k] / (kTile * kTile);
    return means;
}

json thumbnail(const json& message, const HelperLimits& limits) {
    JobRequest request;
    request.scene = "thumbnail";
    request.width = kThumbnailWidth, request.height = kThumbnailHeight;
    request.method.name = "path_tracing";
    request.method.parameters = {{"indirect_bounces", kThumbnailBounces}};
    request.stop.passes = kThumbnailPasses, request.stop.seconds = kThumbnailSeconds;

    Stats stats;
    Scene scene = load_scene(SceneSource::from_json(message.at("scene")), {}, stats);
    light_if_dark(scene);
    MemoryBudget budget(limits.memory_bytes);
    scene.account(budget);
    const std::unique_ptr<Intersector> intersector = make_embree_intersector(scene, budget, stats);
    const std::unique_ptr<Method> method = make_method(request);
    const RenderContext context{scene, intersector.get(), resolve_view(request, scene), request.seed, budget};
    const CancelToken never;
    PassLoop loop{*method, context, request.stop, never, nullptr};
    const Film film = loop.run(stats).film;
    const std::vector<float> beauty = film.resolve_beauty();
    write_png(film.size(), tone_mapped(beauty, auto_exposure_stops(tile_means(beauty, film.size())), ToneCurve::Filmic),
              text_of(message, "out"));
    return json::object();
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
    return {{"width", header.size.width}, {"height", header.size.height}, {"channels", header.channels}};
}

json encode_exr(const json& message, const HelperLimits& limits) {
    const Film film = FilmFile::load(text_of(message, "film"), limits.memory_bytes).film;
    const std::vector<ImageAttribute> attributes = statistics_attributes(message.value("statistics", json(nullptr)));
    return {{"overflowed", write_exr(film, precision_of(message), attributes, text_of(message, "out"))}};
}

/// Throws Error(UnknownName) where the film has no layer of that name.
const LayerInfo& film_layer(const Film& film, const std::string& name) {
    const auto info = std::find_if(kLayers.begin(), kLayers.end(), [&](const LayerInfo& l) { return l.name == name; });
    if (info == kLayers.end() || !film.layers().has(info->layer))
        throw Error(ErrorCode::UnknownName, "/layer", "the film has no layer \"" + name + "\"");
    return *info;
}

json encode_preview(const json& message, const HelperLimits& limits) {
    const std::string curve_name = text_of(message, "curve");
    const std::optional<ToneCurve> curve = tone_curve_named(curve_name);
    if (!curve)
        throw Error(ErrorCode::UnknownName, "/curve", "curve \"" + curve_name + "\" is neither srgb nor filmic");
    const Film film = FilmFile::load(text_of(message, "film"), limits.memory_bytes).film;
    const std::string layer = message.value("layer", "beauty");
    const float exposure = message.value("exposure", 0.0f);
    std::vector<uint8_t> rgb;
    if (layer == "beauty") {
        rgb = tone_mapped(film.resolve_beauty(), exposure, *curve);
    } else {
        const LayerInfo& info = film_layer(film, layer);
        if (preview_of(info) == LayerPreview::None)
            throw Error(ErrorCode::UnknownName, "/layer", "the layer \"" + layer + "\" has no preview");
        rgb = preview_image(film, info, exposure, *curve);
    }
    write_png(film.size(), rgb, text_of(message, "out"));
    return json::object();
}

json encode_pixels(const json& message, const HelperLimits& limits) {
    const Film film = FilmFile::load(text_of(message, "film"), limits.memory_bytes).film;
    const std::string wanted = message.value("layer", "beauty");
    std::vector<float> pixels;
    uint32_t channels = 3;
    if (wanted.empty() || wanted == "beauty") {
        pixels = film.resolve_beauty();
    } else {
        const LayerInfo& info = film_layer(film, wanted);
        pixels = film.resolve(info.layer);
        channels = info.channel_count;
    }
    uint64_t overflowed = 0;
    AtomicFile out(text_of(message, "out"));
    if (precision_of(message) == Precision::Half) {
        const std::vector<uint16_t> halves = to_half(pixels, overflowed);
        out.write(halves.data(), halves.size() * sizeof(uint16_t));
    } else {
        out.write(pixels.data(), pixels.size() * sizeof(float));
    }
    out.commit();
    return {{"width", film.size().width},
            {"height", film.size().height},
            {"channels", channels},
            {"overflowed", overflowed}};
}

json run_task(const json& message, const HelperLimits& limits) {
    const std::string type = message.value("type", "");
    if (type == "judge_scene") return judge_scene(message);
    if (type == "unpack") return unpack(message);
    if (type == "thumbnail") return thumbnail(message, limits);
    if (type == "bake") return bake(message, limits);
    if (type == "judge_image") return judge_image_file(message);
    if (type == "measure") return measure_images(message, limits.memory_bytes);
    if (type == "encode_difference") return encode_difference(message, limits.memory_bytes);
    if (type == "encode_flip") return encode_flip(message, limits.memory_bytes);
    if (type == "encode_error_map") return encode_error_map(message, limits.memory_bytes);
    if (type == "merge_films") return merge_films(message, limits.memory_bytes);
    if (type == "encode_exr") return encode_exr(message, limits);
    if (type == "encode_preview") return encode_preview(message, limits);
    if (type == "encode_pixels") return encode_pixels(message, limits);
    throw Error(ErrorCode::UnknownName, "/type", "the helper has no task \"" + type + "\"");
}

}  // namespace

json run_helper_task(const json& message, const HelperLimits& limits) noexcept {
    json result = nullptr, failure = nullptr;
    try {
        const tbb::global_control bound(tbb::global_control::max_allowed_parallelism, limits.threads);
        tbb::task_arena arena(static_cast<int>(limits.threads));
        arena.execute([&] { result = run_task(message, limits); });
    } catch (const Error& error) {
        failure = failure_json(error);
    } catch (const std::bad_alloc&) {
        failure = failure_json(ErrorCode::OutOfMemory, "ran out of memory under the helper's limit of " +
                                                           std::to_string(limits.memory_bytes) + " bytes");
    } catch (const std::exception& defect) {
        spdlog::error("helper task {}: {}", message.value("type", "?"), defect.what());
        failure = failure_json(ErrorCode::Internal, "internal error in the helper, written to its log");
    }
    // Memory kept from one small task to the next saves the kernel clearing it again.
    if (resident_bytes() > kKeptBytes) release_free_memory();
    return {{"type", "reply"},
            {"request", message.value("request", json(nullptr))},
            {"result", result},
            {"failure", failure}};
}

}  // namespace photond
