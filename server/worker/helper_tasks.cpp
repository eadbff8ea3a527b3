#include "server/worker/helper_tasks.h"

#include <spdlog/spdlog.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <map>
#include <variant>

#include "protocol/helper_messages.h"
#include "renderer/film/exr_file.h"
#include "renderer/film/film_file.h"
#include "renderer/scene/baked_scene.h"
#include "renderer/scene/gltf_loader.h"
#include "server/worker/helper_errors.h"
#include "server/worker/helper_frames.h"
#include "server/worker/helper_merge.h"
#include "server/worker/helper_pictures.h"
#include "server/worker/helper_previews.h"
#include "server/worker/helper_seeds.h"
#include "server/worker/job_runner.h"
#include "server/worker/pack.h"
#include "server/worker/process_memory.h"
#include "server/worker/raw_pixels.h"
#include "server/worker/scene_summary.h"
#include "server/worker/statistics.h"
#include "server/worker/unpack.h"

namespace photond {

using nlohmann::json;

namespace {

constexpr uint64_t kWarmSceneDivisor = 4;  // share of the memory limit that a scene kept for the next picture may take

json judge_scene(const JudgeSceneRequest& asked) {
    Stats stats;
    const Scene scene = load_scene({"", asked.builtin, asked.root, asked.file}, {}, stats);
    json summary = scene_summary(scene, asked.name.empty() ? asked.builtin : asked.name, !asked.builtin.empty());
    std::map<std::string, double> aspects;
    if (asked.builtin.empty()) aspects = gltf_camera_aspects(asked.file, asked.root);
    for (json& camera : summary["cameras"]) {
        const auto found = aspects.find(camera["name"].get<std::string>());
        camera["aspect"] = found == aspects.end() ? json() : json(found->second);
    }
    return summary;
}

BakeReply bake(const BakeRequest& asked, uint64_t memory_bytes) {
    Stats stats;
    const Scene scene = load_scene(asked.scene, {}, stats);
    const uint64_t bytes = baked_scene_bytes(scene);
    const auto too_large = [&](ErrorCode code, uint64_t limit, const char* what) {
        if (bytes > limit)
            throw Error(code, "the baked scene takes " + std::to_string(bytes) + " bytes, more than the " +
                                  std::to_string(limit) + " " + what);
    };
    too_large(ErrorCode::OutOfMemory, memory_bytes, "bytes that the helper may hold");
    too_large(ErrorCode::NoSpace, asked.max_bytes, "bytes of disk that may be used");
    write_baked_scene(scene, asked.out);
    return {bytes};
}

JudgeImageReply judge_image_file(const JudgeImageRequest& asked) {
    const JudgedImage header = judge_image(asked.path);
    JudgeImageReply reply{header.size.width, header.size.height, header.channels, {}};
    for (const NamedLayer& layer : header.layers) reply.layers.push_back({layer.name, layer.channels.size()});
    return reply;
}

EncodedReply encode_exr(const EncodeExrRequest& asked, uint64_t memory_bytes) {
    const SavedFilm saved = FilmFile::load(asked.film, memory_bytes);
    std::vector<ImageAttribute> attributes = statistics_attributes(asked.statistics);
    if (!asked.job_request.is_null()) attributes.push_back({"photond:request", asked.job_request.dump()});
    if (!saved.identity.scene.empty()) attributes.push_back({"photond:scene", saved.identity.scene});
    EncodedReply reply;
    reply.overflowed = write_exr(saved.film, precision_named(asked.precision), attributes, asked.out);
    return reply;
}

/// The task of each request.
struct Tasks {
    uint64_t memory_bytes;
    SceneCache& scenes;

    json run(const JudgeSceneRequest& asked) const { return judge_scene(asked); }
    UnpackReply run(const UnpackRequest& asked) const { return {unpack_scene(asked.zip, asked.root)}; }
    DoneReply run(const PackRequest& asked) const { return pack_files(asked), DoneReply(); }
    DoneReply run(const ThumbnailRequest& asked) const { return thumbnail(asked, memory_bytes, scenes), DoneReply(); }
    PreviewSceneReply run(const PreviewSceneRequest& asked) const { return preview_scene(asked, memory_bytes, scenes); }
    BakeReply run(const BakeRequest& asked) const { return bake(asked, memory_bytes); }
    JudgeImageReply run(const JudgeImageRequest& asked) const { return judge_image_file(asked); }
    MeasureReply run(const MeasureRequest& asked) const { return measure_images(asked, memory_bytes); }
    EncodedReply run(const EncodeDifferenceRequest& asked) const {
        return encode_difference(asked, memory_bytes), EncodedReply();
    }
    EncodedReply run(const EncodeFlipRequest& asked) const { return encode_flip(asked, memory_bytes); }
    EncodedReply run(const EncodeFlipMapRequest& asked) const { return encode_flip_map(asked, memory_bytes); }
    EncodedReply run(const EncodeErrorMapRequest& asked) const {
        return encode_error_map(asked, memory_bytes), EncodedReply();
    }
    MeasureFrameReply run(const MeasureFrameRequest& asked) const { return measure_frame(asked, memory_bytes); }
    MeasureSeedsReply run(const MeasureSeedsRequest& asked) const { return measure_seeds(asked, memory_bytes); }
    EncodedReply run(const EncodeBiasMapRequest& asked) const { return encode_bias_map(asked), EncodedReply(); }
    MergeFilmsReply run(const MergeFilmsRequest& asked) const { return merge_films(asked, memory_bytes); }
    EncodedReply run(const EncodeExrRequest& asked) const { return encode_exr(asked, memory_bytes); }
    EncodedReply run(const EncodePreviewRequest& asked) const {
        return encode_preview(asked, memory_bytes), EncodedReply();
    }
    EncodedReply run(const EncodeSheetRequest& asked) const {
        return encode_sheet(asked, memory_bytes), EncodedReply();
    }
    EncodedReply run(const EncodePixelsRequest& asked) const { return encode_pixels(asked, memory_bytes); }
};

json run_task(const HelperRequest& request, const Tasks& tasks) {
    const auto run = [&]<class Request>(const Request& asked) {
        typename Request::Reply reply = tasks.run(asked);
        return part_json(std::move(reply));
    };
    return std::visit(run, request);
}

/// What a request comes to.
struct Outcome {
    json result;
    std::optional<Failure> failure;
    bool out_of_memory = false;

    void fail(const Error& error) {
        failure = Failure::of(error);
        out_of_memory = error.code == ErrorCode::OutOfMemory;
    }
};

Outcome try_task(const HelperRequest& request, const HelperLimits& limits, SceneCache& scenes) {
    Outcome outcome;
    try {
        const tbb::global_control bound(tbb::global_control::max_allowed_parallelism, limits.threads);
        tbb::task_arena arena(static_cast<int>(limits.threads));
        arena.execute([&] { outcome.result = run_task(request, {limits.memory_bytes, scenes}); });
    } catch (const Error& error) {
        outcome.fail(error);
    } catch (const std::bad_alloc&) {
        outcome.fail(Error(ErrorCode::OutOfMemory, "ran out of memory under the helper's limit of " +
                                                       std::to_string(limits.memory_bytes) + " bytes"));
    } catch (const std::exception& defect) {
        const auto name = [](const auto& asked) { return std::string(asked.kType); };
        spdlog::error("helper task {}: {}", std::visit(name, request), defect.what());
        outcome.fail(Error(ErrorCode::Internal, "internal error in the helper, written to its log"));
    }
    return outcome;
}

template <class... Requests>
bool is_one_of(const HelperRequest& request) {
    return (std::holds_alternative<Requests>(request) || ...);
}
/// Those that load a scene of their own, as large as may be, or whose traces a second try would find.
bool needs_all_memory(const HelperRequest& request) {
    return is_one_of<JudgeSceneRequest, BakeRequest, UnpackRequest>(request);
}
/// Those whose budget the warm scene is part of.
bool draws_scene(const HelperRequest& request) { return is_one_of<ThumbnailRequest, PreviewSceneRequest>(request); }

Outcome run_request(const HelperRequest& request, const HelperLimits& limits, SceneCache& scenes) {
    if (needs_all_memory(request)) scenes.clear();
    HelperLimits left = limits;
    if (!draws_scene(request)) left.memory_bytes -= std::min(left.memory_bytes, scenes.bytes());
    Outcome outcome = try_task(request, left, scenes);
    if (outcome.out_of_memory && scenes.bytes() > 0) {
        scenes.clear();
        release_free_memory();
        outcome = try_task(request, limits, scenes);
    }
    if (scenes.bytes() > limits.memory_bytes / kWarmSceneDivisor) scenes.clear();
    // Memory kept from one small task to the next saves the kernel clearing it again.
    if (resident_bytes() > kHelperKeptBytes + scenes.bytes()) release_free_memory();
    return outcome;
}

}  // namespace

json run_helper_task(const json& message, const HelperLimits& limits, SceneCache& scenes) noexcept {
    ReplyMessage reply;
    Outcome outcome;
    try {
        reply.request = read_part<RequestNumber>(message, type_of_message(message)).request;
        outcome = run_request(read_helper_request(message), limits, scenes);
    } catch (const Error& error) {  // of the message itself
        outcome.fail(error);
    }
    reply.result = std::move(outcome.result);
    reply.failure = std::move(outcome.failure);
    return message_json(std::move(reply));
}

}  // namespace photond
