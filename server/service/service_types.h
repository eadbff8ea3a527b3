#pragma once
// What callers hand to the service and get from it. Objects are JSON as on the wire (protocol.md, "Shapes").

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "protocol/job.h"

namespace photond {

/// Whether the daemon answers all that it is asked.
struct Readiness {
    std::string why_not = {};  // in words; empty when it does

    bool ready() const { return why_not.empty(); }
};

/// An uploaded scene the routes have spooled at a Service::make_spool_path().
struct SceneUpload {
    enum class Kind : uint8_t { Glb, Zip, Directory };  // Directory: a .gltf or .glb and its files, by relative path
    Kind kind = Kind::Glb;
    std::filesystem::path path;  // the file, or the folder for Directory; taken over (removed on failure too)
    std::string name;            // empty: named after its id
};

/// A quick picture of a scene, to choose a view by.
struct ScenePreview {
    std::string camera;             // one of the scene's; empty: look_at, or else the scene's default view
    std::optional<LookAt> look_at;  // from wherever
    uint32_t width = 320, height = 240;
    uint32_t passes = 4;
};

/// It, and by how many stops it was exposed.
struct DrawnPreview {
    std::string png;
    std::string exposure_stops;
};

/// The whole object, and whether it is new (201) or was there already (200).
struct Added {
    nlohmann::json object;
    bool created = false;
};

/// A page of a list: {"items": [...], "next_cursor": null}.
using Page = nlohmann::json;
/// What takes a long answer's text, piece after piece; it may throw, which ends the answer's making.
using TextSink = std::function<void(std::string piece)>;

struct JobFilter {
    std::string view = "full";  // or "summary": what is read and sent fast, however long the jobs' curves
    std::string state;          // empty: any; else some of the five states, commas between them, or OutOfRange
    std::string label;          // "key" or "key=value"
    std::string scene;          // id or name
    std::string method;
    std::string device;  // as in the job's attempts: "cpu", "gpu:0"
    std::string role;    // empty: any; else one of the four roles, or OutOfRange
    /// "newest"; "queue": waiting jobs as they will run; "ended": jobs that are over, the last first. Pages of the last
    /// two go by the offset alone.
    std::string order = "newest";
    uint32_t limit = 100;  // 1..1000, else OutOfRange
    std::string cursor;    // from next_cursor; empty: the newest
    uint32_t offset = 0;   // jobs to skip from there
};

/// A file to send. `pending` means 202, empty, Retry-After: 1 (nothing rendered yet); the other fields are then empty.
/// The file stays readable under `path` as long as `pin` lives.
struct Artefact {
    bool pending = false;
    std::filesystem::path path;
    std::string media_type;
    std::string etag;  // strong, without quotes
    uint64_t bytes = 0;
    std::shared_ptr<const void> pin;
    std::map<std::string, std::string> headers;  // what the bytes alone do not say, such as a raw image's width
};

/// The picture of a job's layer that people look at.
struct PreviewWanted {
    std::string layer = "beauty";
    double exposure_stops = 0;         // -32..32
    std::string curve = "srgb";        // or "filmic"
    std::optional<uint32_t> max_size;  // of the longer side, 16..4096: larger ones are scaled down
};

/// A sequence's frames as something to look at.
struct VideoWanted {
    std::string format = "auto";  // "mp4"; "png", a sheet of pictures; or whichever this machine can make
    std::optional<double> fps;    // pictures a second, 1..120; else the sequence's own, as near as that comes
    double exposure_stops = 0;    // as a PreviewWanted has it
    std::string curve = "srgb";
};

/// A sequence's page.
struct SequenceReportWanted {
    std::string first, second;        // ids of the references; empty: it is not measured
    std::string layer = "beauty";     // that is
    std::vector<std::string> beside;  // ids of other sequences of the same frames
};

/// A job, a comparison or a sequence, and whether it was over already (200 instead of 202).
struct Cancelled {
    nlohmann::json object;
    bool was_over = false;
};

}  // namespace photond
