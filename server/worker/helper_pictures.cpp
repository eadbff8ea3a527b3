#include "server/worker/helper_pictures.h"

#include <algorithm>
#include <fstream>

#include "protocol/job.h"
#include "renderer/film/box_downscale.h"
#include "renderer/film/png_file.h"
#include "renderer/film/tone_curve.h"
#include "renderer/gbuffer/filtered_beauty.h"
#include "server/worker/job_runner.h"
#include "server/worker/preview_image.h"

namespace photond {

namespace {

constexpr uint32_t kThumbnailWidth = 256, kThumbnailHeight = 192, kThumbnailPasses = 32;
constexpr uint32_t kBounces = 3;
constexpr int kQuickCompression = 1;
constexpr uint32_t kExposureTile = 8;  // pixels: over as many the eye averages an image, to judge its exposure

JobRequest picture_request(Size2 size, uint32_t passes, std::optional<double> most_seconds) {
    JobRequest request;
    request.scene = "picture";
    request.width = size.width, request.height = size.height;
    request.method.name = "path_tracing";
    request.method.parameters = {{"indirect_bounces", kBounces}};
    request.layers = guide_layers();
    request.stop.passes = passes, request.stop.seconds = most_seconds;
    return request;
}

struct Drawn {
    PreviewImage picture;
    float exposure_stops = 0;
};

Drawn draw(const SceneSource& source, const JobRequest& request, uint64_t memory_bytes, SceneCache& scenes) {
    Stats stats;
    MemoryBudget budget(memory_bytes);
    SceneVariant variant;
    variant.light_if_dark = true;
    const std::shared_ptr<const ReadyScene> ready = scenes.get(source, variant, budget, stats);
    const std::unique_ptr<Method> method = make_method(request);
    const RenderContext context{ready->scene, ready->intersector.get(), resolve_view(request, ready->scene),
                                request.seed, budget};
    const CancelToken never;
    PassLoop loop{*method, context, request.stop, never, nullptr};
    const Film film = loop.run(stats).film;
    const Size2 size = film.size();
    const std::vector<float> beauty = filtered_beauty(film);
    const Size2 tiles{std::max(1u, size.width / kExposureTile), std::max(1u, size.height / kExposureTile)};
    const float exposure_stops = auto_exposure_stops(box_downscaled(beauty, 3, size, tiles));
    return {{size, tone_mapped(beauty, exposure_stops, ToneCurve::Filmic)}, exposure_stops};
}

JobCamera camera_of(const PreviewSceneRequest& asked) {
    JobCamera camera;
    camera.name = asked.camera;
    if (!asked.look_at.is_null()) {
        BodyFaults faults;
        camera.look_at = read_look_at(asked.look_at, "/look_at", faults);
        faults.throw_if_any();
    }
    return camera;
}

}  // namespace

void thumbnail(const ThumbnailRequest& asked, uint64_t memory_bytes, SceneCache& scenes) {
    const JobRequest request =
        picture_request({kThumbnailWidth, kThumbnailHeight}, kThumbnailPasses, asked.most_seconds);
    const PreviewImage picture = draw(asked.scene, request, memory_bytes, scenes).picture;
    write_png(picture.size, picture.rgb, asked.out);
}

PreviewSceneReply preview_scene(const PreviewSceneRequest& asked, uint64_t memory_bytes, SceneCache& scenes) {
    JobRequest request = picture_request({asked.width, asked.height}, asked.passes, asked.most_seconds);
    request.camera = camera_of(asked);
    const auto [picture, exposure_stops] = draw(asked.scene, request, memory_bytes, scenes);
    const std::vector<uint8_t> png = encode_png(picture.size, picture.rgb, kQuickCompression);
    // Nobody keeps it: what a power cut leaves of it does not matter, and waiting for the disk would be felt.
    std::ofstream out(asked.out, std::ios::binary);
    out.write(reinterpret_cast<const char*>(png.data()), static_cast<std::streamsize>(png.size()));
    out.close();
    if (!out) throw Error(ErrorCode::NoSpace, "the picture cannot be written");
    return {double{exposure_stops}};
}

}  // namespace photond
