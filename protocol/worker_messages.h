#pragma once
// What the daemon and its worker processes say to each other (message_channel.h), each message with "type". Files named
// in messages are absolute paths inside the data directory; the writer writes beside, fsyncs and renames. An Error that
// ends a helper's request is its "failure".
//
// clang-format off
// worker -> daemon
//   hello      {"pid", "device": {device object of protocol.md}}          once, when ready to take work
//   heartbeat  {"resident_bytes"}                                         every second, from a thread of its own
//   started    {"job", "attempt"}
//   progress   {"job", "attempt", "passes_done", "progress", "seconds", "error_now": {"metric", "value"}|null}
//                                                                         at most 4 a second
//   curve      {"job", "attempt", "points": [point of protocol.md..], "error_now": as above}
//              new points, in their order; a job that goes on from a film sends those it had first
//   film_saved {"job", "attempt", "path", "passes_done"}
//              after "snapshot" (its path), every "save_seconds" (the order's "film") and before stopping (likewise)
//   finished   {"job", "attempt", "state": "succeeded"|"cancelled"|"failed", "passes_done", "seconds",
//               "film": path|null, "statistics": {..}|null,
//               "rendered": {"passes", "seconds", "rays": {kind: n}, "photons"} by this attempt alone; null where it failed,
//               "curve": [point..]|null, "error_now": as above,
//               "artefacts": [name..], "failure": {"code", "detail", "errors": [{"pointer","detail"}]}|null, "log": [line..],
//               "stopping": true when the job ended because of "stop"}
//               The film is there when a pass was finished and the job did not fail; it is at the "film" path of the order.
//               Each artefact (MethodInfo::artefacts) lies beside it at artefact_path(film, name); none with "stopping".
//   device_lost {"job", "attempt", "reason"}   the GPU stopped answering; the process then ends with kDeviceLostStatus
//   devices    {"items": [{device object of protocol.md}..]}              all of this machine, by --device list
//   reply      {"request": n, "result": {..}|null, "failure": as above|null}   answers a helper's request
// daemon -> worker
//   render     {"job", "attempt", "request": job request,
//               "scene": {"id", "builtin": name|null, "root": dir, "file": path},
//               "environment": {"path"}|null, "film": path to write, "limits": {"memory_bytes", "threads"},
//               "resume": path of a film of the same job to go on from|null; one that is damaged or of something else is
//               named in the log, and the job begins anew,
//               "reference": {"film": path} or {"image": path}|null, measured against; "streams": "job"|"reference",
//               "save_seconds": the least time between two savings of the film|null}
//   snapshot   {"job", "path"}         save the film so far after the pass at hand; answered by film_saved, or, when the
//                                      job ends first, by its "finished" alone
//   cancel     {"job"}                 ends the job; its film so far is saved
//   stop       {}                      save the film of the running job, report it cancelled with "stopping": true, exit 0
// daemon -> helper (photond-worker --device none), one at a time, each answered by reply with the same "request"
//   judge_scene    {"request", "root": dir, "file": path, "name"}   -> scene summary (protocol.md, "Scene", without id)
//                  or {"request", "builtin": name}
//   unpack         {"request", "zip": path, "root": dir}            -> {"file": path of the .gltf/.glb inside root}
//   thumbnail      {"request", "scene": as in render, "out": path}  -> {}
//   preview_scene  {"request", "scene": as in render, "camera": name|null, "look_at": as a job's, whole|null, "width",
//                  "height", "passes", "out": path, not synced} -> {} (PNG; the scene stays ready for the next)
//   bake           {"request", "scene": as in render, "max_bytes", "out": path} -> {"bytes"} (renderer/scene/baked_scene.h)
//   judge_image    {"request", "path"}  -> {"width", "height", "channels", "layers": [{"name", "channels"}..]}
//   Below, SOURCE is {"film": path} or {"image": path}.
//   measure        {"request", "image": SOURCE, "reference": SOURCE, "metrics": [name..]}
//                  -> {"metrics": {name: value}, "reference_error": {name: value}|null, "notes": [text..]}
//   encode_difference {"request", "image": SOURCE, "reference": SOURCE, "out"}           -> {} (EXR: x - r, by layer)
//   encode_flip    {"request", "image": SOURCE, "reference": SOURCE, "layer", "range": "ldr"|"hdr", "out"} -> {"mean"}
//   encode_flip_map {"request", "image": SOURCE, "reference": SOURCE, "layer", "range", "precision", "out"}
//                  -> as encode_pixels, of one channel, and "mean"
//   encode_error_map {"request", "image": SOURCE, "reference": SOURCE, "layer", "out"}   -> {}
//                  PNG of each pixel's relative error, log scale from 1e-3 (dark) to 10 (bright): comparable everywhere
//   merge_films    {"request", "films": [path..], "job_request": as in render, "scene_id", "out"}
//                  -> {"passes_done", "seconds", "statistics": {..}, "pixel_hash"}
//   encode_exr     {"request", "film", "statistics": {..}|null, "precision": "float"|"half", "out"} -> {"overflowed": n}
//   encode_preview {"request", "film", "layer": beauty, one of radiance, or overlap, "exposure": stops,
//                  "curve": "srgb"|"filmic", "max_size": of the longer side|null, "out"}
//                  -> {} (PNG; overlap as a heat map)
//   encode_pixels  {"request", "film" or "image": path, "layer", "precision", "out"}
//                  -> {"width", "height", "channels", "overflowed"}
//   stop           {}                                               -> exit 0, no reply
// clang-format on

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "protocol/error.h"

namespace photond {

/// {"code", "detail", "errors"} as in "finished" and "reply".
nlohmann::json failure_json(ErrorCode code, const std::string& detail, const std::vector<Fault>& faults = {});
nlohmann::json failure_json(const Error& error);

/// Where the worker leaves an artefact of the method, beside the film of the same attempt.
inline std::filesystem::path artefact_path(const std::filesystem::path& film, std::string_view name) {
    return film.string().append(".").append(name);
}

}  // namespace photond
