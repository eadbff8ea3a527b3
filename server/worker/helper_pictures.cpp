#include "server/worker/helper_pictures.h"

#include <algorithm>
#include <fstream>

#include "protocol/job.h"
#include "renderer/film/box_downscale.h"
#include "renderer/film/png_file.h"
#include "renderer/film/tone_curve.h"
#include "server/worker/helper_message.h"
#include "server/worker/job_runner.h"
#include "server/worker/preview_image.h"

namespace photond {

using nlohmann::json;

namespace {

constexpr uint32_t kThumbnailWidth = 256, kThumbnailHeight = 192, kThumbnailPasses = 32;
constexpr double kMostSeconds = 1;  // of rendering: other tasks wait meanwhile
constexpr uint32_t kBounces = 3;
constexpr int kQuickCompression = 1;
constexpr uint32_t kExposureTile = 8;  // pixels: over as many the eye averages a noisy image, to judge its exposure

JobRequest picture_request(Size2 size, uint32_t passes) {
    JobRequest request;
    request.scene = "picture";
    request.width = size.width, request.height = size.height;
    request.method.name = "path_tracing";
    request.method.parameters = {{"indirect_bounces", kBounces}};
    request.stop.passes = passes, request.stop.seconds = kMostSeconds;
    return request;
}

PreviewImage draw(const json& message, const JobRequest& request, uint64_t memory_bytes, SceneCache& scenes) {
    Stats stats;
    MemoryBudget budget(memory_bytes);
    SceneVariant variant;
    variant.light_if_dark = true;
    const std::shared_ptr<const ReadyScene> ready =
        scenes.get(SceneSource::from_json(message.at("scene")), variant, budget, stats);
    const std::unique_ptr<Method> method = make_method(request);
    const RenderContext context{ready->scene, ready->intersector.get(), resolve_view(request, ready->scene),
                                request.seed, budget};
    const CancelToken never;
    PassLoop loop{*method, context, request.stop, never, nullptr};
    const Film film = loop.run(stats).film;
    const Size2 size = film.size();
    const std::vector<float> beauty = film.resolve_beauty();
    const Size2 tiles{std::max(1u, size.width / kExposureTile), std::max(1u, size.height / kExposureTile)};
    const float exposure_stops = auto_exposure_stops(box_downscaled(beauty, 3, size, tiles));
    return {size, tone_mapped(beauty, exposure_stops, ToneCurve::Filmic)};
}

std::array<double, 3> point_in(const json& source) {
    return {source.at(0).get<double>(), source.at(1).get<double>(), source.at(2).get<double>()};
}

JobCamera camera_in(const json& message) {
    JobCamera camera;
    if (const json name = message.value("camera", json(nullptr)); name.is_string()) camera.name = name;
    if (const json look_at = message.value("look_at", json(nullptr)); look_at.is_object())
        camera.look_at = {.eye = point_in(look_at.at("eye")),
                          .target = point_in(look_at.at("target")),
                          .up = point_in(look_at.at("up")),
                          .yfov = look_at.at("yfov").get<double>()};
    return camera;
}

}  // namespace

json thumbnail(const json& message, uint64_t memory_bytes, SceneCache& scenes) {
    const JobRequest request = picture_request({kThumbnailWidth, kThumbnailHeight}, kThumbnailPasses);
    const PreviewImage picture = draw(message, request, memory_bytes, scenes);
    write_png(picture.size, picture.rgb, text_of(message, "out"));
    return json::object();
}

json preview_scene(const json& message, uint64_t memory_bytes, SceneCache& scenes) {
    JobRequest request = picture_request({message.at("width").get<uint32_t>(), message.at("height").get<uint32_t>()},
                                         message.at("passes").get<uint32_t>());
    request.camera = camera_in(message);
    const PreviewImage picture = draw(message, request, memory_bytes, scenes);
    const std::vector<uint8_t> png = encode_png(picture.size, picture.rgb, kQuickCompression);
    // Nobody keeps it: what a power cut leaves of it does not matter, and waiting for the disk would be felt.
    std::ofstream out(text_of(message, "out"), std::ios::binary);
    out.write(reinterpret_cast<const char*>(png.data()), static_cast<std::streamsize>(png.size()));
    out.close();
    if (!out) throw Error(ErrorCode::NoSpace, "the picture cannot be written");
    return json::object();
}

}  // namespace photond
