// What goes over the wire, message by message: the JSON that is written here stands for processes that were built by
// somebody else, and for those that a scene has taken over.

#include "protocol/worker_messages.h"

#include <gtest/gtest.h>

#include "protocol/helper_messages.h"

namespace photond::worker_messages_test {
namespace {

using nlohmann::json;

/// The message of this text, which must be all that is written of it again.
template <class Message>
Message exact(const char* text) {
    const json source = json::parse(text);
    Message message = message_as<Message>(source).value();
    EXPECT_EQ(message_json(message), source);
    return message;
}

/// Likewise the reply to a request.
template <class Request>
typename Request::Reply exact_reply(const char* text) {
    const json source = json::parse(text);
    auto reply = read_part<typename Request::Reply>(source, Request::kType);
    EXPECT_EQ(part_json(reply), source);
    return reply;
}

TEST(WorkerMessages, OfAWorker) {
    const auto hello = exact<HelloMessage>(
        R"({"type": "hello", "pid": 12, "device": {"id": "cpu"}, "file_access": {"by": "landlock", "version": 2}})");
    EXPECT_EQ(hello.device["id"], "cpu");
    EXPECT_EQ(hello.file_access.version, 2);
    EXPECT_EQ(
        exact<HeartbeatMessage>(R"({"type": "heartbeat", "resident_bytes": 18446744073709551615})").resident_bytes,
        UINT64_MAX);
    EXPECT_EQ(exact<StartedMessage>(R"({"type": "started", "job": "J1", "attempt": 2})").attempt, 2);
    const auto progress = exact<ProgressMessage>(
        R"({"type": "progress", "job": "J1", "attempt": 2, "passes_done": 4294967295, "progress": 0.5, "seconds": 1.5,
            "error_now": {"metric": "rmse", "value": 0.25, "interval": [0.125, 0.5]}})");
    EXPECT_EQ(progress.passes_done, UINT32_MAX);
    EXPECT_EQ(progress.error_now->value, 0.25);
    const auto curve = exact<CurveMessage>(
        R"({"type": "curve", "job": "J1", "attempt": 2, "points": [{"passes": 1}, {"passes": 2}], "error_now": null})");
    EXPECT_EQ(curve.points[1]["passes"], 2);
    EXPECT_FALSE(curve.error_now);
    EXPECT_EQ(exact<FilmSavedMessage>(
                  R"({"type": "film_saved", "job": "J1", "attempt": 2, "path": "/d/a.film", "passes_done": 3})")
                  .path,
              "/d/a.film");
    EXPECT_EQ(
        exact<DeviceLostMessage>(R"({"type": "device_lost", "job": "J1", "attempt": 2, "reason": "it hung"})").reason,
        "it hung");
    EXPECT_EQ(exact<DevicesMessage>(R"({"type": "devices", "items": [{"id": "cpu"}, {"id": "gpu:0"}]})").items.size(),
              2u);
}

TEST(WorkerMessages, OfTheEndOfAnAttempt) {
    const auto finished = exact<FinishedMessage>(
        R"({"type": "finished", "job": "J1", "attempt": 2, "state": "succeeded", "passes_done": 8, "seconds": 2.5,
            "film": "/d/a.film", "statistics": {"seed": 1},
            "cores": {"processor_seconds": 5.0, "run_delay_seconds": 0.5, "host_busy_outside_seconds": 0.25,
                      "host_steal_seconds": 0.0, "pressure_seconds": null, "lost_seconds": 0.25, "share": 0.9375,
                      "clock_lost_seconds": 0.125},
            "rendered": {"passes": 3, "seconds": 1.5, "photons": 7,
                         "rays": {"camera": 1, "bounce": 2, "shadow": 3, "photon": 4}},
            "curve": [{"passes": 8}], "error_now": {"metric": "rmse", "value": null, "interval": null}, "artefacts": ["photon_map.glb"],
            "failure": null, "log": ["a line"], "stopping": false})");
    EXPECT_EQ(finished.rendered->rays.photon, 4u);
    EXPECT_EQ(finished.cores->share, 0.9375);
    EXPECT_FALSE(finished.cores->pressure_seconds);
    EXPECT_EQ(finished.artefacts, std::vector<std::string>{"photon_map.glb"});
    EXPECT_FALSE(finished.error_now->value);
    const auto failed = exact<FinishedMessage>(
        R"({"type": "finished", "job": "J1", "attempt": 2, "state": "failed", "passes_done": 0, "seconds": 0.0,
            "film": null, "statistics": null, "cores": null, "rendered": null, "curve": null, "error_now": null, "artefacts": [],
            "failure": {"code": "out_of_range", "detail": "too wide",
                        "errors": [{"code": "wrong_type", "pointer": "/image/width", "detail": "too wide"}]},
            "log": [], "stopping": true})");
    const Error error = error_of(failed.failure);
    EXPECT_EQ(error.code, ErrorCode::OutOfRange);
    EXPECT_EQ(error.faults.at(0).pointer, "/image/width");
    EXPECT_EQ(error.faults.at(0).code, ErrorCode::WrongType);
    EXPECT_EQ(part_json(Failure::of(error)), part_json(failed.failure));
    EXPECT_EQ(error_of(std::nullopt).code, ErrorCode::Internal);
}

TEST(WorkerMessages, OfTheDaemon) {
    const auto order = exact<RenderMessage>(
        R"({"type": "render", "job": "J1", "attempt": 2, "request": {"scene": "box"},
            "scene": {"id": "S", "builtin": null, "root": "/d/S", "file": "/d/S/a.glb"},
            "environment": {"path": "/d/e.hdr"}, "film": "/d/a.film", "origin": "mine", "resume": "/d/b.film",
            "before": {"film": "/d/c.film", "time": 0.25},
            "reference": {"film": "/d/r.film"}, "streams": "reference", "save_seconds": 2.0,
            "limits": {"memory_bytes": 1024, "threads": 3}})");
    EXPECT_EQ(order.scene.root, "/d/S");
    EXPECT_EQ(order.reference->first.film, "/d/r.film");
    EXPECT_EQ(order.limits.threads, 3u);
    exact<RenderMessage>(
        R"({"type": "render", "job": "J1", "attempt": 2, "request": {},
            "scene": {"id": "box", "builtin": "box", "root": null, "file": null}, "environment": null, "film": "/d/a", "origin": "",
            "resume": null, "before": null, "reference": {"image": "/d/r.exr"}, "streams": "job", "save_seconds": null,
            "limits": {"memory_bytes": 1024, "threads": 0}})");
    const RenderMessage least = *message_as<RenderMessage>(json::parse(
        R"({"type": "render", "job": "J1", "attempt": 2, "scene": {"id": "box", "builtin": "box"}, "film": "/d/a"})"));
    EXPECT_EQ(least.streams, "job");
    EXPECT_EQ(least.limits.memory_bytes, UINT64_MAX);
    EXPECT_FALSE(least.reference || least.resume || least.environment || least.save_seconds);
    EXPECT_EQ(exact<SnapshotMessage>(R"({"type": "snapshot", "job": "J1", "path": "/d/a.s1"})").path, "/d/a.s1");
    EXPECT_EQ(exact<CancelMessage>(R"({"type": "cancel", "job": "J1"})").job, "J1");
    exact<StopMessage>(R"({"type": "stop"})");
}

TEST(HelperMessages, OfScenes) {
    EXPECT_EQ(exact<JudgeSceneRequest>(R"({"type": "judge_scene", "builtin": "box"})").builtin, "box");
    exact<JudgeSceneRequest>(R"({"type": "judge_scene", "root": "/d", "file": "/d/a.glb", "name": "mine"})");
    EXPECT_EQ(exact_reply<JudgeSceneRequest>(R"({"triangles": 1})")["triangles"], 1);
    exact<UnpackRequest>(R"({"type": "unpack", "zip": "/d/z", "root": "/d/r"})");
    EXPECT_EQ(exact_reply<UnpackRequest>(R"({"file": "/d/r/a.glb"})").file, "/d/r/a.glb");
    exact<ThumbnailRequest>(
        R"({"type": "thumbnail", "scene": {"id": "box", "builtin": "box", "root": null, "file": null}, "out": "/d/o"})");
    exact_reply<ThumbnailRequest>("{}");
    const auto preview = exact<PreviewSceneRequest>(
        R"({"type": "preview_scene", "scene": {"id": "box", "builtin": "box", "root": null, "file": null},
            "camera": null, "look_at": {"yfov": 0.7}, "width": 32, "height": 16, "passes": 4, "most_seconds": 1.5,
            "out": "/d/o"})");
    EXPECT_EQ(preview.camera, "");
    EXPECT_EQ(preview.most_seconds, 1.5);
    EXPECT_EQ(exact_reply<PreviewSceneRequest>(R"({"exposure_stops": -1.5})").exposure_stops, -1.5);
    exact<BakeRequest>(
        R"({"type": "bake", "scene": {"id": "box", "builtin": "box", "root": null, "file": null}, "max_bytes": 9,
            "out": "/d/o"})");
    EXPECT_EQ(exact_reply<BakeRequest>(R"({"bytes": 5})").bytes, 5u);
}

TEST(HelperMessages, OfImagesAndFilms) {
    exact<JudgeImageRequest>(R"({"type": "judge_image", "path": "/d/i.exr"})");
    const auto image = exact_reply<JudgeImageRequest>(
        R"({"width": 2, "height": 3, "channels": 4, "layers": [{"name": "beauty", "channels": 3}]})");
    EXPECT_EQ(image.layers.at(0).channels, 3u);
    EXPECT_EQ(part_json(image.layers), json::parse(R"([{"name": "beauty", "channels": 3}])"));
    const auto measure = exact<MeasureRequest>(
        R"({"type": "measure", "image": {"film": "/f"}, "reference": {"image": "/i"},
            "metrics": ["rmse"]})");
    EXPECT_EQ(measure.reference.first.path(), "/i");
    const auto crossed = exact<MeasureRequest>(
        R"({"type": "measure", "image": {"film": "/f"}, "reference": {"film": "/r", "second": {"film": "/s"}},
            "metrics": null})");
    EXPECT_EQ(crossed.reference.second.value().path(), "/s");
    exact_reply<MeasureRequest>(
        R"({"metrics": {"rmse": 1.5}, "intervals": null, "reference_error": null, "notes": ["a note"]})");
    exact_reply<MeasureRequest>(
        R"({"metrics": {"mse": 2.0}, "intervals": {"mse": [1.0, 3.0]}, "reference_error": null, "notes": []})");
    const char* pair = R"("image": {"film": "/f"}, "reference": {"film": "/r"}, "out": "/o")";
    const auto with_pair = [&](const char* rest) { return "{" + std::string(pair) + rest + "}"; };
    exact<EncodeDifferenceRequest>(with_pair(R"(, "type": "encode_difference")").c_str());
    exact<EncodeFlipRequest>(with_pair(R"(, "type": "encode_flip", "layer": "direct", "range": "ldr")").c_str());
    exact<EncodeFlipMapRequest>(
        with_pair(R"(, "type": "encode_flip_map", "layer": "direct", "range": "hdr", "precision": "half")").c_str());
    exact<EncodeErrorMapRequest>(with_pair(R"(, "type": "encode_error_map", "layer": "direct")").c_str());
    exact<EncodeExrRequest>(
        R"({"type": "encode_exr", "film": "/f", "statistics": null, "job_request": null, "precision": "half", "out": "/o"})");
    exact<EncodePreviewRequest>(
        R"({"type": "encode_preview", "film": "/f", "layer": "beauty", "exposure": 0.5, "curve": "srgb",
            "max_size": null, "out": "/o"})");
    for (const char* source : {"film", "image"})
        exact<EncodePixelsRequest>(
            (R"({"type": "encode_pixels", "layer": "depth", "precision": "float", "out": "/o", ")" +
             std::string(source) + R"(": "/f"})")
                .c_str());
    exact_reply<EncodePixelsRequest>(R"({"width": 2, "height": 3, "channels": 4, "overflowed": 0})");
    EXPECT_EQ(exact_reply<EncodeFlipRequest>(R"({"mean": 0.5})").mean, 0.5);
    exact_reply<EncodeErrorMapRequest>("{}");
    exact<MergeFilmsRequest>(
        R"({"type": "merge_films", "films": ["/a", "/b"], "job_request": {"seed": 5}, "scene_id": "S", "origin": "",
            "out": "/o"})");
    EXPECT_EQ(exact_reply<MergeFilmsRequest>(
                  R"({"passes_done": 2, "seconds": 0.5, "statistics": {"seed": 5}, "pixel_hash": "ab"})")
                  .pixel_hash,
              "ab");
}

TEST(HelperMessages, AreNumberedAndAnsweredByNumber) {
    json request = message_json(JudgeImageRequest{"/i"});
    add_members(request, RequestNumber{7});
    EXPECT_EQ(request, json::parse(R"({"type": "judge_image", "path": "/i", "request": 7})"));
    EXPECT_EQ(read_part<RequestNumber>(request, "").request, 7u);
    EXPECT_EQ(std::get<JudgeImageRequest>(read_helper_request(request)).path, "/i");
    exact<ReplyMessage>(R"({"type": "reply", "request": 7, "result": {}, "failure": null})");
    exact<ReplyMessage>(
        R"({"type": "reply", "request": null, "result": null,
            "failure": {"code": "bad_image", "detail": "no image", "errors": []}})");
}

/// CODE POINTER: the message's text.
template <class Read>
std::string fault_of(const Read& read) {
    try {
        read();
    } catch (const Error& error) {
        return std::string(error_kind(error.code).name) + " " + error.faults.at(0).pointer + ": " + error.what();
    }
    return "none";
}

TEST(MalformedMessages, NameTheMessageAndTheMember) {
    const json good =
        message_json(ProgressMessage{.job = "J1", .attempt = 1, .error_now = ErrorNow{"rmse", 1.0, std::nullopt}});
    const auto fault = [&](const char* pointer, const json& value) {
        json message = good;
        message[json::json_pointer(pointer)] = value;
        return fault_of([&] { read_worker_message(message); });
    };
    EXPECT_EQ(fault("/seconds", 5), "none");  // a whole number is a number
    EXPECT_EQ(fault("/seconds", "x"),
              "wrong_type /seconds: \"progress\": /seconds must be a number, not of type string");
    EXPECT_EQ(fault("/seconds", nullptr), "missing_field /seconds: \"progress\": /seconds is missing");
    EXPECT_EQ(fault("/passes_done", -1),
              "out_of_range /passes_done: \"progress\": /passes_done = -1 is outside [0, 4294967295]");
    EXPECT_TRUE(fault("/passes_done", uint64_t{1} << 32).starts_with("out_of_range /passes_done: "));
    EXPECT_TRUE(fault("/passes_done", 1.5).starts_with("wrong_type /passes_done: "));
    EXPECT_TRUE(fault("/attempt", UINT64_MAX).starts_with("out_of_range /attempt: "));
    EXPECT_TRUE(fault("/job", 7).starts_with("wrong_type /job: "));
    EXPECT_TRUE(fault("/error_now", json::array()).starts_with("wrong_type /error_now: "));
    EXPECT_TRUE(fault("/error_now/metric", true).starts_with("wrong_type /error_now/metric: "));
    EXPECT_EQ(fault("/more", 1), "none");
}

TEST(MalformedMessages, AreReadToTheEndOfTheirLists) {
    json finished = message_json(FinishedMessage{.job = "J1", .attempt = 1});
    finished["log"] = {"a", "b", 3};
    EXPECT_TRUE(fault_of([&] { read_worker_message(finished); }).starts_with("wrong_type /log/2: "));
    finished["log"] = "a";
    EXPECT_TRUE(fault_of([&] { read_worker_message(finished); }).starts_with("wrong_type /log: "));
    finished["log"] = json::array();
    finished["failure"] = {
        {"code", "internal"}, {"detail", ""}, {"errors", {{{"code", "internal"}, {"pointer", "/a"}}}}};
    EXPECT_TRUE(
        fault_of([&] { read_worker_message(finished); }).starts_with("missing_field /failure/errors/0/detail: "));
}

TEST(MalformedMessages, OfNoTypeAreNone) {
    for (const char* text :
         {"{}", R"({"type": 5})", R"({"type": null})", R"({"type": "dance"})", R"({"type": "reply"})"}) {
        const json message = json::parse(text);
        EXPECT_FALSE(read_worker_message(message)) << text;
        EXPECT_FALSE(read_daemon_message(message)) << text;
        EXPECT_TRUE(fault_of([&] { read_helper_request(message); }).starts_with("unknown_name /type: ")) << text;
    }
}

}  // namespace
}  // namespace photond::worker_messages_test
