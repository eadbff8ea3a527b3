#pragma once
// What the daemon asks of its helpers (photond-worker --device none): one request at a time, each answered by a
// ReplyMessage. The Reply that a request names is the result in there. Files are named as in worker_messages.h.

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "protocol/message_json.h"
#include "protocol/message_parts.h"

namespace photond {

/// What every request has beside its own members.
struct RequestNumber {
    std::optional<uint64_t> request;

    void visit(MessageVisitor& visitor) { visitor.or_null("request", request); }
};

/// Answers the request of that number: exactly one of result and failure is not null.
struct ReplyMessage {
    static constexpr const char* kType = "reply";
    std::optional<uint64_t> request;
    nlohmann::json result;
    std::optional<Failure> failure;  // the Error that ended it

    void visit(MessageVisitor& visitor) {
        visitor.or_null("request", request);
        visitor.or_null("result", result);
        visitor.or_null("failure", failure);
    }
};

/// It is done, and there is nothing to say about it.
struct DoneReply {
    void visit(MessageVisitor&) {}
};

// --- Scenes

/// Either `builtin`, or the other three.
struct JudgeSceneRequest {
    static constexpr const char* kType = "judge_scene";
    using Reply = nlohmann::json;  // the scene, without its id: protocol.md, "Scene"
    std::string builtin;
    std::filesystem::path root, file;  // as SceneSource has them
    std::string name;

    void visit(MessageVisitor& visitor) {
        visitor.if_any("builtin", builtin);
        visitor.if_any("root", root);
        visitor.if_any("file", file);
        visitor.if_any("name", name);
    }
};

struct UnpackReply {
    std::filesystem::path file;  // the .gltf or .glb inside root

    void visit(MessageVisitor& visitor) { visitor.member("file", file); }
};

struct UnpackRequest {
    static constexpr const char* kType = "unpack";
    using Reply = UnpackReply;
    std::filesystem::path zip;
    std::filesystem::path root;  // an existing empty folder

    void visit(MessageVisitor& visitor) {
        visitor.member("zip", zip);
        visitor.member("root", root);
    }
};

/// Files put together in a ZIP, as they are.
struct PackRequest {
    static constexpr const char* kType = "pack";
    using Reply = DoneReply;
    struct Item {
        std::filesystem::path file;
        std::string name;  // in the archive

        void visit(MessageVisitor& visitor) {
            visitor.member("file", file);
            visitor.member("name", name);
        }
    };
    std::vector<Item> items;
    std::filesystem::path out;

    void visit(MessageVisitor& visitor) {
        visitor.member("items", items);
        visitor.member("out", out);
    }
};

struct ThumbnailRequest {
    static constexpr const char* kType = "thumbnail";
    using Reply = DoneReply;
    SceneSource scene;
    std::optional<double> most_seconds;  // of rendering; the first pass is always finished
    std::filesystem::path out;           // PNG

    void visit(MessageVisitor& visitor) {
        visitor.member("scene", scene);
        visitor.if_any("most_seconds", most_seconds);
        visitor.member("out", out);
    }
};

struct PreviewSceneReply {
    double exposure_stops = 0;  // that the picture was given by itself

    void visit(MessageVisitor& visitor) { visitor.member("exposure_stops", exposure_stops); }
};

/// The scene stays ready for the next picture.
struct PreviewSceneRequest {
    static constexpr const char* kType = "preview_scene";
    using Reply = PreviewSceneReply;
    SceneSource scene;
    std::string camera;      // of the scene; empty: `look_at`, or else the scene's default view
    nlohmann::json look_at;  // as a job's, whole; or null
    uint32_t width = 0, height = 0;
    uint32_t passes = 0;
    std::optional<double> most_seconds;  // as a thumbnail's
    std::filesystem::path out;           // PNG, not synced

    void visit(MessageVisitor& visitor) {
        visitor.member("scene", scene);
        visitor.or_null("camera", camera);
        visitor.or_null("look_at", look_at);
        visitor.member("width", width);
        visitor.member("height", height);
        visitor.member("passes", passes);
        visitor.if_any("most_seconds", most_seconds);
        visitor.member("out", out);
    }
};

struct BakeReply {
    uint64_t bytes = 0;

    void visit(MessageVisitor& visitor) { visitor.member("bytes", bytes); }
};

struct BakeRequest {
    static constexpr const char* kType = "bake";
    using Reply = BakeReply;
    SceneSource scene;
    uint64_t max_bytes = 0;     // of disk that the file may take
    std::filesystem::path out;  // renderer/scene/baked_scene.h

    void visit(MessageVisitor& visitor) {
        visitor.member("scene", scene);
        visitor.member("max_bytes", max_bytes);
        visitor.member("out", out);
    }
};

// --- Images

struct JudgeImageReply {
    struct Layer {
        std::string name;
        uint64_t channels = 0;

        void visit(MessageVisitor& visitor) {
            visitor.member("name", name);
            visitor.member("channels", channels);
        }
    };
    uint32_t width = 0, height = 0;
    uint32_t channels = 0;
    std::vector<Layer> layers;

    void visit(MessageVisitor& visitor) {
        visitor.member("width", width);
        visitor.member("height", height);
        visitor.member("channels", channels);
        visitor.member("layers", layers);
    }
};

struct JudgeImageRequest {
    static constexpr const char* kType = "judge_image";
    using Reply = JudgeImageReply;
    std::filesystem::path path;

    void visit(MessageVisitor& visitor) { visitor.member("path", path); }
};

struct MeasureReply {
    nlohmann::json metrics;          // {name: value}
    nlohmann::json intervals;        // {name: [least, greatest]} of what two references were measured by; or null
    nlohmann::json reference_error;  // {name: value}: what the reference's own noise explains; or null
    std::vector<std::string> notes;

    void visit(MessageVisitor& visitor) {
        visitor.member("metrics", metrics);
        visitor.or_null("intervals", intervals);
        visitor.or_null("reference_error", reference_error);
        visitor.member("notes", notes);
    }
};

struct MeasureRequest {
    static constexpr const char* kType = "measure";
    using Reply = MeasureReply;
    ImageSource image;
    ReferenceSource reference;
    std::optional<std::vector<std::string>> metrics;  // none: those of the beauty that cost little

    void visit(MessageVisitor& visitor) {
        visitor.member("image", image);
        visitor.member("reference", reference);
        visitor.or_null("metrics", metrics);
    }
};

struct MeasureSeedsReply {
    /// {layer: {"errors": {metric: {"squared_bias", "low", "high", "variance", "variance_low", "variance_high"}},
    /// "map"}} of those layers that all films have; "map" is the schema BiasMap but for row, label and layer
    /// (openapi_comparisons.cpp).
    nlohmann::json layers;

    void visit(MessageVisitor& visitor) { visitor.member("layers", layers); }
};

/// Films of one method that differ by their seed, against a reference of two films: bias and noise apart, and where the
/// bias is.
struct MeasureSeedsRequest {
    static constexpr const char* kType = "measure_seeds";
    using Reply = MeasureSeedsReply;
    std::vector<std::filesystem::path> films;
    ReferenceSource reference;
    std::vector<std::string> layers;

    void visit(MessageVisitor& visitor) {
        visitor.member("films", films);
        visitor.member("reference", reference);
        visitor.member("layers", layers);
    }
};

struct MeasureFrameReply {
    /// {"relative_mse", "flicker", "lag", "change"}: {"value", "standard_error"}, or null where there is none
    /// (renderer/error/motion_errors.h).
    nlohmann::json figures;

    void visit(MessageVisitor& visitor) { visitor.member("figures", figures); }
};

/// A frame of a sequence and, for all but its error, the one before, against two references of each.
struct MeasureFrameRequest {
    static constexpr const char* kType = "measure_frame";
    using Reply = MeasureFrameReply;
    struct Films {
        std::filesystem::path film, first, second;

        void visit(MessageVisitor& visitor) {
            visitor.member("film", film);
            visitor.member("first", first);
            visitor.member("second", second);
        }
    };
    Films frame;
    std::optional<Films> before;
    std::string layer = "beauty";

    void visit(MessageVisitor& visitor) {
        visitor.member("frame", frame);
        visitor.or_null("before", before);
        visitor.or_default("layer", layer);
    }
};

/// What the bytes of a file do not say that was encoded, as far as it applies to one of its kind.
struct EncodedReply {
    std::optional<uint32_t> width, height, channels;  // of raw pixels
    std::optional<uint64_t> overflowed;               // finite values that half precision has made infinite
    std::optional<double> mean;                       // of a FLIP map

    void visit(MessageVisitor& visitor) {
        visitor.if_any("width", width);
        visitor.if_any("height", height);
        visitor.if_any("channels", channels);
        visitor.if_any("overflowed", overflowed);
        visitor.if_any("mean", mean);
    }
};

/// EXR of image minus reference, by layer. Here and below two films stand for their mean.
struct EncodeDifferenceRequest {
    static constexpr const char* kType = "encode_difference";
    using Reply = EncodedReply;
    ImageSource image;
    ReferenceSource reference;
    std::filesystem::path out;

    void visit(MessageVisitor& visitor) {
        visitor.member("image", image);
        visitor.member("reference", reference);
        visitor.member("out", out);
    }
};

/// PNG of a layer's FLIP map; the reply has its mean.
struct EncodeFlipRequest {
    static constexpr const char* kType = "encode_flip";
    using Reply = EncodedReply;
    ImageSource image;
    ReferenceSource reference;
    std::string layer = "beauty";
    std::string range;  // "ldr" or "hdr"
    std::filesystem::path out;

    void visit(MessageVisitor& visitor) {
        visitor.member("image", image);
        visitor.member("reference", reference);
        visitor.or_default("layer", layer);
        visitor.member("range", range);
        visitor.member("out", out);
    }
};

/// The same as raw pixels of one channel; the reply is that of EncodePixelsRequest and has the mean besides.
struct EncodeFlipMapRequest {
    static constexpr const char* kType = "encode_flip_map";
    using Reply = EncodedReply;
    ImageSource image;
    ReferenceSource reference;
    std::string layer = "beauty";
    std::string range;      // "ldr" or "hdr"
    std::string precision;  // "float" or "half"
    std::filesystem::path out;

    void visit(MessageVisitor& visitor) {
        visitor.member("image", image);
        visitor.member("reference", reference);
        visitor.or_default("layer", layer);
        visitor.member("range", range);
        visitor.member("precision", precision);
        visitor.member("out", out);
    }
};

/// PNG of each pixel's relative error, log scale from 1e-3 (dark) to 10 (bright): comparable everywhere.
struct EncodeErrorMapRequest {
    static constexpr const char* kType = "encode_error_map";
    using Reply = EncodedReply;
    ImageSource image;
    ReferenceSource reference;
    std::string layer = "beauty";
    std::filesystem::path out;

    void visit(MessageVisitor& visitor) {
        visitor.member("image", image);
        visitor.member("reference", reference);
        visitor.or_default("layer", layer);
        visitor.member("out", out);
    }
};

/// PNG of the map of a MeasureSeedsReply.
struct EncodeBiasMapRequest {
    static constexpr const char* kType = "encode_bias_map";
    using Reply = EncodedReply;
    nlohmann::json map;
    std::filesystem::path out;

    void visit(MessageVisitor& visitor) {
        visitor.member("map", map);
        visitor.member("out", out);
    }
};

// --- Films

struct MergeFilmsReply {
    uint32_t passes_done = 0;
    double seconds = 0;
    nlohmann::json statistics;  // protocol.md, "Shapes"
    std::string pixel_hash;

    void visit(MessageVisitor& visitor) {
        visitor.member("passes_done", passes_done);
        visitor.member("seconds", seconds);
        visitor.member("statistics", statistics);
        visitor.member("pixel_hash", pixel_hash);
    }
};

struct MergeFilmsRequest {
    static constexpr const char* kType = "merge_films";
    using Reply = MergeFilmsReply;
    std::vector<std::filesystem::path> films;
    nlohmann::json job_request;  // as RenderMessage::request
    std::string scene_id;
    std::string origin;  // as RenderMessage::origin
    std::filesystem::path out;

    void visit(MessageVisitor& visitor) {
        visitor.member("films", films);
        visitor.member("job_request", job_request);
        visitor.member("scene_id", scene_id);
        visitor.or_default("origin", origin);
        visitor.member("out", out);
    }
};

/// The reply says how many values overflowed.
struct EncodeExrRequest {
    static constexpr const char* kType = "encode_exr";
    using Reply = EncodedReply;
    std::filesystem::path film;
    nlohmann::json statistics;   // protocol.md, "Shapes": written down in the file; or null
    nlohmann::json job_request;  // the whole job that rendered it, likewise; or null
    std::string precision;       // "float" or "half"
    std::filesystem::path out;

    void visit(MessageVisitor& visitor) {
        visitor.member("film", film);
        visitor.or_null("statistics", statistics);
        visitor.or_null("job_request", job_request);
        visitor.member("precision", precision);
        visitor.member("out", out);
    }
};

/// PNG of a layer, as its LayerPreview says.
struct EncodePreviewRequest {
    static constexpr const char* kType = "encode_preview";
    using Reply = EncodedReply;
    std::filesystem::path film;
    std::string layer = "beauty";
    double exposure = 0;               // stops
    std::string curve;                 // "srgb" or "filmic"
    std::optional<uint32_t> max_size;  // of the longer side
    std::filesystem::path out;

    void visit(MessageVisitor& visitor) {
        visitor.member("film", film);
        visitor.or_default("layer", layer);
        visitor.or_default("exposure", exposure);
        visitor.member("curve", curve);
        visitor.or_null("max_size", max_size);
        visitor.member("out", out);
    }
};

/// PNG of several films beside each other, row after row from the top left, black between them. The first one's size is
/// that of all.
struct EncodeSheetRequest {
    static constexpr const char* kType = "encode_sheet";
    using Reply = EncodedReply;
    std::vector<std::filesystem::path> films;
    uint32_t columns = 1;
    uint32_t max_size = 256;  // of a picture's longer side
    double exposure = 0;      // stops
    std::string curve;        // "srgb" or "filmic"
    std::filesystem::path out;

    void visit(MessageVisitor& visitor) {
        visitor.member("films", films);
        visitor.member("columns", columns);
        visitor.member("max_size", max_size);
        visitor.or_default("exposure", exposure);
        visitor.member("curve", curve);
        visitor.member("out", out);
    }
};

/// Raw pixels of a layer of a film or an image: little-endian, interleaved, row 0 at the top. The reply has all but the
/// mean.
struct EncodePixelsRequest {
    static constexpr const char* kType = "encode_pixels";
    using Reply = EncodedReply;
    ImageSource source;  // its member lies among the others
    std::string layer = "beauty";
    std::string precision;  // "float" or "half"
    std::filesystem::path out;

    void visit(MessageVisitor& visitor) {
        source.visit(visitor);
        visitor.or_default("layer", layer);
        visitor.member("precision", precision);
        visitor.member("out", out);
    }
};

using HelperRequest =
    std::variant<JudgeSceneRequest, UnpackRequest, PackRequest, ThumbnailRequest, PreviewSceneRequest, BakeRequest,
                 JudgeImageRequest, MeasureRequest, EncodeDifferenceRequest, EncodeFlipRequest, EncodeFlipMapRequest,
                 EncodeErrorMapRequest, MeasureSeedsRequest, MeasureFrameRequest, EncodeBiasMapRequest,
                 MergeFilmsRequest, EncodeExrRequest, EncodePreviewRequest, EncodeSheetRequest, EncodePixelsRequest>;
/// Throws Error where it cannot be read; ErrorCode::UnknownName at /type for one that is none of these.
HelperRequest read_helper_request(const nlohmann::json& message);

}  // namespace photond
