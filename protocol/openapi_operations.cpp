#include "protocol/openapi_operations.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <iterator>

#include "protocol/error.h"
#include "protocol/openapi_schemas.h"
#include "protocol/problem.h"
#include "protocol/scene_families.h"

namespace photond {
namespace {

using nlohmann::json;
using namespace openapi;

json content(const std::string& media_type, json schema) { return {{media_type, {{"schema", std::move(schema)}}}}; }
json binary() { return json::object(); }

struct Operation {
    const char* method;
    std::string path;
    std::string id;
    std::string summary;
    std::vector<std::pair<int, json>> answers;  // status, content (empty: no body)
    json body = nullptr;                        // content taken
    std::vector<std::pair<const char*, json>> query = {};
    std::vector<std::pair<const char*, const char*>> headers = {};
    std::vector<std::string> required = {};  // of the query
};

/// What an operation is about: the collection that its path begins with.
std::string tag_of(const std::string& path) {
    constexpr std::string_view kVersion = "/v1/";
    if (!path.starts_with(kVersion)) {
        const bool is_probe = path == "/healthz" || path == "/readyz" || path == "/metrics";
        return is_probe ? "daemon" : "dashboard";
    }
    const std::string collection = path.substr(kVersion.size(), path.find('/', kVersion.size()) - kVersion.size());
    const bool is_daemons = collection == "status" || collection == "events" || collection == "openapi.json";
    return is_daemons ? "daemon" : collection;
}

json operation_json(const Operation& operation) {
    json parameters = json::array();
    const std::string& path = operation.path;
    for (size_t at = path.find('{'); at != std::string::npos; at = path.find('{', at + 1))
        parameters.push_back({{"name", path.substr(at + 1, path.find('}', at) - at - 1)},
                              {"in", "path"},
                              {"required", true},
                              {"schema", typed("string")}});
    for (const auto& [name, schema] : operation.query)
        parameters.push_back({{"name", name}, {"in", "query"}, {"schema", schema}});
    for (json& parameter : parameters)
        if (std::find(operation.required.begin(), operation.required.end(), parameter["name"].get<std::string>()) !=
            operation.required.end())
            parameter["required"] = true;
    for (const auto& [name, text] : operation.headers)
        parameters.push_back({{"name", name}, {"in", "header"}, {"schema", typed("string")}, {"description", text}});
    json responses{{"default",
                    {{"description", "a failure, see the schema Problem"},
                     {"content", content(kProblemMediaType, schema_ref("Problem"))}}}};
    for (const auto& [status, body] : operation.answers) {
        json& answer = responses[std::to_string(status)];
        answer["description"] = status == 202 && body.is_null() ? "nothing rendered yet; ask again" : "as asked";
        if (!body.is_null()) answer["content"] = body;
    }
    json result{{"operationId", operation.id},
                {"summary", operation.summary},
                {"tags", json::array({tag_of(path)})},
                {"parameters", parameters},
                {"responses", responses}};
    if (!operation.body.is_null()) result["requestBody"] = {{"required", true}, {"content", operation.body}};
    return result;
}

/// "photon_map.glb" as getPhotonMap.
std::string operation_id(const std::string& artefact) {
    std::string id = "get";
    bool begins_word = true;
    for (const char c : artefact_link(artefact)) {
        if (c != '_') id += begins_word && c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
        begins_word = c == '_';
    }
    return id;
}

constexpr const char* kJson = "application/json";

json object(const char* name) { return content(kJson, schema_ref(name)); }
json file(const char* media_type) { return content(media_type, binary()); }
json word() { return typed("string"); }
json flag(const char* text) { return with_text(typed("boolean"), text); }
json precision() { return one_of_words({"float", "half"}); }
json page_size() { return in_range(typed("integer"), 1, 1000); }
std::vector<std::pair<const char*, json>> page() { return {{"limit", page_size()}, {"cursor", word()}}; }

json one_of_beauty_and(std::vector<std::string> layers) {
    layers.insert(layers.begin(), "beauty");
    return one_of_words(layers);
}
json measured_layer(const ApiVocabulary& vocabulary) { return one_of_beauty_and(vocabulary.radiance_layers); }

// What requests say that may wait for a job (server/routes/job_wait.h).
std::pair<const char*, json> wait_parameter(const char* text) {
    return {"wait", with_text(in_range(typed("number", "seconds"), 0, 600), text)};
}
std::pair<const char*, json> cancel_parameter() {
    return {"cancel_on_disconnect", flag("the job ends with a client that leaves while its request waits")};
}

/// What a request says that would rather be repeated than held (server/asks_again.h).
constexpr std::pair<const char*, const char*> kPrefer{
    "Prefer", "respond-async: 202 with Retry-After at once where the answer waits for a pass or a picture"};

std::vector<Operation> scene_operations() {
    const json point{{"type", "string"}, {"pattern", "^[^,]+,[^,]+,[^,]+$"}, {"description", "x,y,z in metres"}};
    const json scene_body{
        {"model/gltf-binary", binary()}, {"application/zip", binary()}, {"multipart/form-data", binary()}};
    return {
        {"post",
         "/v1/scenes",
         "addScene",
         "Upload a scene",
         {{201, object("Scene")}, {200, object("Scene")}},
         scene_body,
         {{"name", word()}},
         {{"X-Scene-Name", "the scene's name, where the query gives none"}}},
        {"get",
         "/v1/scenes",
         "listScenes",
         "Scenes, newest first; or the built-in scenes of a family",
         {{200, object("ScenePage")}},
         nullptr,
         {{"family", with_text(one_of_words({kSceneFamilies.begin(), kSceneFamilies.end()}),
                               "built-in scenes that are listed only so")},
          {"limit", page_size()},
          {"cursor", word()}}},
        {"get", "/v1/scenes/{scene}", "getScene", "One scene, by id or name", {{200, object("Scene")}}},
        {"delete", "/v1/scenes/{scene}", "deleteScene", "Remove a scene", {{200, object("Scene")}}},
        {"get",
         "/v1/scenes/{scene}/thumbnail.png",
         "getThumbnail",
         "A small picture to recognise it by: few paths, filtered, so no result; while a job renders perhaps 503, to "
         "be "
         "asked for again after Retry-After",
         {{200, file("image/png")}, {202, nullptr}},
         nullptr,
         {},
         {kPrefer}},
        {"get",
         "/v1/scenes/{scene}/preview.png",
         "getScenePreview",
         "A quick picture by one of its cameras, or from eye to target; the scene stays ready for the next one. Few "
         "paths of three bounces, filtered within surfaces and auto-exposed (X-Exposure-Stops says by how much, by the "
         "curve filmic): to choose a view by, and no result. "
         "While a job renders perhaps 503",
         {{200, file("image/png")}, {202, nullptr}},
         nullptr,
         {{"camera", with_text(word(), "by name; without it and without an eye the default view")},
          {"eye", point},
          {"target", point},
          {"up", point},
          {"yfov", typed("number", "radians")},
          {"width", in_range(typed("integer"), 16, 512)},
          {"height", in_range(typed("integer"), 16, 512)},
          {"passes", in_range(typed("integer"), 1, 16)}},
         {kPrefer}},
        {"get",
         "/v1/scenes/{scene}/baked",
         "getBakedScene",
         "Geometry, materials, lights, cameras and decoded textures in one file, as photond-gpu-bench reads them",
         {{200, file("application/octet-stream")}}},
    };
}

std::vector<Operation> catalogue_operations() {
    return {
        {"get", "/v1/methods", "listMethods", "Methods, by name", {{200, object("MethodPage")}}, nullptr, page()},
        {"get", "/v1/methods/{name}", "getMethod", "One method", {{200, object("Method")}}},
        {"get",
         "/v1/layers",
         "listLayers",
         "Layers that an image may have",
         {{200, object("LayerPage")}},
         nullptr,
         page()},
        {"get", "/v1/metrics", "listMetrics", "Error measures", {{200, object("MetricPage")}}, nullptr, page()},
        {"get", "/v1/devices", "listDevices", "Devices", {{200, object("DevicePage")}}},
    };
}

std::vector<Operation> job_operations() {
    json states = typed("string", "one or more, commas between them");
    constexpr const char* kState = "(queued|running|succeeded|failed|cancelled)";
    states["pattern"] = std::string("^") + kState + "(," + kState + ")*$";
    const json role = one_of_words({"render", "reference", "merged", "frame"});
    return {
        {"post",
         "/v1/jobs",
         "submitJob",
         "Queue a render job",
         {{202, object("Job")}, {200, content(kJson, {{"anyOf", {schema_ref("Job"), schema_ref("Estimate")}}})}},
         object("JobRequest"),
         {{"dry_run", flag("only estimate: 200, nothing is queued")},
          wait_parameter("for so long at the most, for the job to be over: 200 then, else 202"),
          cancel_parameter()},
         {{"Idempotency-Key", "the same key and body give the same job"}}},
        {"get",
         "/v1/jobs",
         "listJobs",
         "Jobs, newest first; as summaries, with how many there are, quick for any page of any filter",
         {{200, content(kJson, {{"anyOf", {schema_ref("JobPage"), schema_ref("JobSummaryPage")}}})}},
         nullptr,
         {{"view", with_text(one_of_words({"full", "summary"}), "full where not given")},
          {"order", with_text(one_of_words({"newest", "queue", "ended"}),
                              "newest where not given; queue: waiting jobs as they will run; ended: those that are "
                              "over, the last first; pages of these two go by offset")},
          {"state", states},
          {"label", with_text(word(), "KEY or KEY=VALUE")},
          {"scene", word()},
          {"method", word()},
          {"device", with_text(word(), "cpu, gpu:0, ..")},
          {"role", role},
          {"limit", page_size()},
          {"cursor", word()},
          {"offset", count("jobs to skip after the cursor")}}},
        {"get",
         "/v1/jobs/{id}",
         "getJob",
         "One job",
         {{200, object("Job")}},
         nullptr,
         {wait_parameter("for so long at the most, for the job to be over")}},
        {"post",
         "/v1/render",
         "render",
         "A render job and its image in one request: waits for the job, and answers with what Accept asks for; 202 and "
         "the job where it takes longer. A form may bring the scene along: its files, and the job as its field `job`",
         {{200, json{{"image/png", binary()}, {"image/x-exr", binary()}, {kJson, {{"schema", schema_ref("Job")}}}}},
          {202, object("Job")}},
         json{{kJson, {{"schema", schema_ref("JobRequest")}}}, {"multipart/form-data", binary()}},
         {wait_parameter("for so long at the most; 60 where not given"), cancel_parameter()},
         {{"Idempotency-Key", "the same key and body give the same job"},
          {"Accept", "image/png (where not given), image/x-exr or application/json"}}},
        {"delete",
         "/v1/jobs/{id}",
         "cancelJob",
         "Cancel, or remove with its files",
         {{200, object("Job")}, {202, object("Job")}},
         nullptr,
         {{"purge", flag("remove it with its files")}}},
        {"patch",
         "/v1/jobs/{id}",
         "changeJob",
         "Change the priority of a job that is not over: one that waits moves in the queue",
         {{200, object("Job")}},
         object("JobChange")},
        {"post",
         "/v1/jobs/{id}/repeat",
         "repeatJob",
         "The request of a job that is over as a new job; one of a comparison in its place",
         {{202, object("Job")}}},
        {"post", "/v1/jobs/{id}/retry", "retryJob", "Queue a failed or cancelled job again", {{202, object("Job")}}},
        {"post",
         "/v1/jobs/{id}/extend",
         "extendJob",
         "More passes on the film of a succeeded or cancelled job",
         {{202, object("Job")}},
         object("Extension")},
        {"post",
         "/v1/jobs/merge",
         "mergeJobs",
         "One job of all the passes of several",
         {{201, object("Job")}},
         object("MergeRequest"),
         {},
         {{"Idempotency-Key", "the same key and body give the same job"}}},
        {"get",
         "/v1/jobs/{id}/events",
         "jobEvents",
         "Server-sent events of one job",
         {{200, file("text/event-stream")}},
         nullptr,
         {},
         {{"Last-Event-ID", "resume after this event"}}},
        {"get",
         "/v1/events",
         "allEvents",
         "Server-sent events of all jobs; and `status`, the daemon's (schema Status), at first and then once a second",
         {{200, file("text/event-stream")}},
         nullptr,
         {},
         {{"Last-Event-ID", "resume after this event"}}},
    };
}

std::vector<Operation> job_output_operations(const ApiVocabulary& vocabulary) {
    std::vector<std::string> pixel_layers = vocabulary.always_layers;
    pixel_layers.insert(pixel_layers.end(), vocabulary.layers.begin(), vocabulary.layers.end());
    std::vector<Operation> all{
        {"get",
         "/v1/jobs/{id}/image.exr",
         "getImage",
         "The film, so far or final",
         {{200, file("image/x-exr")}, {202, nullptr}},
         nullptr,
         {{"precision", precision()}}},
        {"get",
         "/v1/jobs/{id}/preview.png",
         "getPreview",
         "The image, or one layer, on a display, by its kind of preview (listLayers): light and dots by exposure and "
         "curve; heat_map as blue 0, green 200, red 400, white 600; directions as (n + 1) / 2; scale from "
         "dark at 0 to bright at the 99th percentile; signed as blue below 0, white at 0 and red above",
         {{200, file("image/png")}, {202, nullptr}},
         nullptr,
         {{"layer", one_of_beauty_and(vocabulary.preview_layers)},
          {"exposure", in_range(typed("number", "stops"), -32, 32)},
          {"curve", one_of_words({"srgb", "filmic"})},
          {"max_size", with_text(in_range(typed("integer"), 16, 4096),
                                 "scaled down, never up, so that the longer side is at most this: means in linear "
                                 "light, before the tone curve")}}},
        {"get",
         "/v1/jobs/{id}/pixels",
         "getPixels",
         "Raw little-endian pixels, row 0 at the top",
         {{200, file("application/octet-stream")}, {202, nullptr}},
         nullptr,
         {{"layer", one_of_beauty_and(pixel_layers)}, {"precision", precision()}}},
        {"get",
         "/v1/jobs/{id}/statistics.json",
         "getStatistics",
         "The statistics of a job that is over",
         {{200, object("Statistics")}, {202, nullptr}}},
        {"get",
         "/v1/jobs/{id}/curve.csv",
         "getCurve",
         "Error over time, so far or to the end",
         {{200, file("text/csv")}, {202, nullptr}}},
        {"get",
         "/v1/jobs/{id}/difference.exr",
         "getDifference",
         "The image less its reference, by layer",
         {{200, file("image/x-exr")}, {202, nullptr}}},
        {"get",
         "/v1/jobs/{id}/flip.png",
         "getFlip",
         "The FLIP map against its reference; while a job renders perhaps 503",
         {{200, file("image/png")}, {202, nullptr}},
         nullptr,
         {{"layer", measured_layer(vocabulary)}, {"range", one_of_words({"hdr", "ldr"})}}},
        {"get",
         "/v1/jobs/{id}/error.png",
         "getErrorMap",
         "Each pixel's relative error, on one scale for all jobs; while a job renders perhaps 503",
         {{200, file("image/png")}, {202, nullptr}},
         nullptr,
         {{"layer", measured_layer(vocabulary)}}},
        {"get",
         "/v1/jobs/{id}/film",
         "getFilm",
         "The film itself: exact sums, to be merged or gone on with",
         {{200, file("application/octet-stream")}, {202, nullptr}}},
        {"get", "/v1/jobs/{id}/log.txt", "getLog", "What happened to the job", {{200, file("text/plain")}}},
    };
    for (const ApiVocabulary::Artefact& artefact : vocabulary.artefacts)
        all.push_back({"get",
                       "/v1/jobs/{id}/" + artefact.name,
                       operation_id(artefact.name),
                       "The " + artefact.text + " that the method kept",
                       {{200, content(artefact.media_type, binary())}, {202, nullptr}}});
    for (Operation& operation : all) {
        if (!operation.path.starts_with("/v1/jobs/")) continue;
        operation.query.push_back(
            wait_parameter("for so long at the most, for the job to be over: 503 where it is not; without, what "
                           "there is so far"));
        operation.headers.push_back(kPrefer);
    }
    return all;
}

std::vector<Operation> comparison_operations(const ApiVocabulary& vocabulary) {
    return {
        {"post",
         "/v1/comparisons",
         "submitComparison",
         "Queue a comparison and all its jobs",
         {{202, object("Comparison")}, {200, object("ComparisonEstimate")}},
         object("ComparisonRequest"),
         {{"dry_run", flag("only estimate, after all checks: 200, nothing is queued")}},
         {{"Idempotency-Key", "the same key and body give the same comparison"}}},
        {"get",
         "/v1/comparisons",
         "listComparisons",
         "Comparisons without their jobs and tables, newest first",
         {{200, object("ComparisonPage")}},
         nullptr,
         page()},
        {"get", "/v1/comparisons/{id}", "getComparison", "One comparison", {{200, object("Comparison")}}},
        {"patch",
         "/v1/comparisons/{id}",
         "changeComparison",
         "Give it another title or other notes; null takes them away, and what is not named stays",
         {{200, object("Comparison")}},
         object("ComparisonRemarks")},
        {"delete",
         "/v1/comparisons/{id}",
         "cancelComparison",
         "Cancel its jobs, or remove it with them and their files",
         {{200, object("Comparison")}, {202, object("Comparison")}},
         nullptr,
         {{"purge", flag("remove it with its files")}}},
        {"get",
         "/v1/comparisons/{id}/rows/{index}/bias.json",
         "getBiasMap",
         "Where row `index` of the table is biased, by blocks of pixels; 404 with the reason where that cannot be told",
         {{200, object("BiasMap")}},
         nullptr,
         {{"layer", measured_layer(vocabulary)}}},
        {"get",
         "/v1/comparisons/{id}/rows/{index}/bias.png",
         "getBiasPicture",
         "The same as a picture: red brighter, blue darker, full at 10 %; blocks that are found have a frame",
         {{200, file("image/png")}},
         nullptr,
         {{"layer", measured_layer(vocabulary)}}},
        {"get",
         "/v1/comparisons/{id}/report.json",
         "getComparisonReport",
         "The comparison with every curve",
         {{200, object("ComparisonReport")}}},
        {"get",
         "/v1/comparisons/{id}/report.csv",
         "getComparisonCurves",
         "A line for each point of each curve",
         {{200, file("text/csv")}}},
        {"get",
         "/v1/comparisons/{id}/report.html",
         "getComparisonPage",
         "A page that needs nothing beside itself: plots, tables, images, and how to repeat it",
         {{200, file("text/html")}}},
    };
}

std::vector<Operation> sequence_operations() {
    return {
        {"post",
         "/v1/sequences",
         "submitSequence",
         "Queue a sequence and all its frames",
         {{202, object("Sequence")}, {200, object("SequenceEstimate")}},
         object("SequenceRequest"),
         {{"dry_run", flag("only estimate, after all checks: 200, nothing is queued")}},
         {{"Idempotency-Key", "the same key and body give the same sequence"}}},
        {"get",
         "/v1/sequences",
         "listSequences",
         "Sequences without their frames, newest first",
         {{200, object("SequencePage")}},
         nullptr,
         page()},
        {"get",
         "/v1/sequences/{id}",
         "getSequence",
         "One sequence",
         {{200, content(kJson, {{"anyOf", {schema_ref("Sequence"), schema_ref("SequenceSummary")}}})}},
         nullptr,
         {{"frames", flag("false: its summary, without them; default: true")}}},
        {"get",
         "/v1/sequences/{id}/frames.zip",
         "getSequenceFrames",
         "The images of the frames that have succeeded so far: 0000.exr, 0001.exr ...",
         {{200, file("application/zip")}, {202, nullptr}},
         nullptr,
         {{"images", one_of_words({"exr", "png"})}}},
        {"get",
         "/v1/sequences/{id}/video",
         "getSequenceVideo",
         "The frames that have succeeded so far, to look at: a video, or where the daemon has no ffmpeg a sheet of at "
         "most 100 of them",
         {{200, json{{"video/mp4", binary()}, {"image/png", binary()}}}, {202, nullptr}},
         nullptr,
         {{"format", with_text(one_of_words({"auto", "mp4", "png"}), "auto: mp4 where it can be made")},
          {"fps", typed("number", "frames a second, 1 to 120; default: the sequence's own, within these")},
          {"exposure", typed("number", "stops, -32 to 32")},
          {"curve", one_of_words({"srgb", "filmic"})}}},
        {"get",
         "/v1/sequences/{id}/report.html",
         "getSequencePage",
         "A page that needs nothing beside itself: frames, errors by frame, and how to repeat it",
         {{200, file("text/html")}},
         nullptr,
         {{"first", typed("string", "id of the one reference; without both it is not measured")},
          {"second", typed("string", "id of the other one")},
          {"layer", typed("string", "default: beauty")},
          {"beside", typed("string", "ids of at most 15 sequences of the same frames, commas between them")}}},
        {"get",
         "/v1/sequences/{id}/errors",
         "getSequenceErrors",
         "By frame: its error, its flicker and its lag against two other sequences of the same frames",
         {{200, object("SequenceErrors")}},
         nullptr,
         {{"first", typed("string", "id of the one reference")},
          {"second", typed("string", "id of the other one, whose frames have other seeds")},
          {"layer", typed("string", "default: beauty")}}},
        {"delete",
         "/v1/sequences/{id}",
         "cancelSequence",
         "Cancel its frames, or remove it with them and their files",
         {{200, object("Sequence")}, {202, object("Sequence")}},
         nullptr,
         {{"purge", flag("remove it with its files")}}},
    };
}

std::vector<Operation> image_operations(const ApiVocabulary& vocabulary) {
    const json source = job_or_image();
    const json image_body{{"image/x-exr", binary()}, {"image/vnd.radiance", binary()}};
    return {
        {"post",
         "/v1/images",
         "addImage",
         "Upload an EXR or HDR image",
         {{201, object("Image")}, {200, object("Image")}},
         image_body},
        {"post",
         "/v1/metrics",
         "measure",
         "The error of an image against another",
         {{200, object("Measurement")}},
         object("MeasurementRequest")},
        {"get", "/v1/images/{id}", "getUploadedImage", "One image", {{200, object("Image")}}},
        {"get",
         "/v1/images/{id}/pixels",
         "getImagePixels",
         "Raw little-endian pixels of a layer, row 0 at the top",
         {{200, file("application/octet-stream")}},
         nullptr,
         {{"layer", with_text(word(), "of the image's layers; beauty where none is named")},
          {"precision", precision()}}},
        {"get",
         "/v1/flip",
         "getFlipMap",
         "The FLIP map of an image against another: raw pixels of one channel, 0 to 1; X-Flip-Mean has its mean. While "
         "a job renders perhaps 503",
         {{200, file("application/octet-stream")}, {202, nullptr}},
         nullptr,
         {{"image", source},
          {"reference", source},
          {"layer", measured_layer(vocabulary)},
          {"range", one_of_words({"hdr", "ldr"})},
          {"precision", precision()}},
         {},
         {"image", "reference"}},
        {"get", "/v1/images/{id}/file", "getImageFile", "The image as uploaded", {{200, file("image/x-exr")}}},
    };
}

std::vector<Operation> daemon_operations(const ApiVocabulary& vocabulary) {
    std::vector<Operation> all{
        {"get", "/v1/status", "getStatus", "The daemon, its queue and workers", {{200, object("Status")}}},
        {"post",
         "/v1/backups",
         "makeBackup",
         "Everything as it is at one moment, to be fetched file by file and put back into an empty data folder; kept "
         "until it is removed, the next one is made or the daemon ends. photonctl backup does all of it",
         {{201, object("Backup")}}},
        {"get", "/v1/backups/{id}", "getBackup", "A backup's files", {{200, object("Backup")}}},
        {"get",
         "/v1/backups/{id}/file",
         "getBackupFile",
         "One of its files; needs a token that may write, as all of it does",
         {{200, file("application/octet-stream")}},
         nullptr,
         {{"path", typed("string")}},
         {},
         {"path"}},
        {"delete", "/v1/backups/{id}", "removeBackup", "It has been fetched", {{200, object("Backup")}}},
        {"get", "/v1/openapi.json", "getOpenApi", "This document", {{200, content(kJson, typed("object"))}}},
        {"get", "/healthz", "isAlive", "Is it alive", {{200, object("Health")}}},
        {"get", "/readyz", "isReady", "Has every worker answered, and do the helpers", {{200, object("Health")}}},
        {"get", "/metrics", "getMetrics", "Prometheus metrics", {{200, file("text/plain")}}},
        {"get", "/favicon.svg", "getDashboardIcon", "Of the dashboard", {{200, file("image/svg+xml")}}},
        {"get",
         "/assets/{file}",
         "getDashboardFile",
         "A file of the dashboard, under a name that says its contents",
         {{200, {{"text/javascript", {{"schema", binary()}}}, {"text/css", {{"schema", binary()}}}}}}},
    };
    for (const std::string& pattern : vocabulary.pages) {
        std::string id = "showDashboard";  // "/jobs/{id}": showDashboardJobsId
        for (size_t i = 0; i < pattern.size(); ++i)
            if (std::isalpha(static_cast<unsigned char>(pattern[i])))
                id += std::isalpha(static_cast<unsigned char>(pattern[i - 1]))
                          ? pattern[i]
                          : static_cast<char>(std::toupper(pattern[i]));
        all.push_back({"get", pattern, id, "The dashboard, a page to look at", {{200, file("text/html")}}});
    }
    return all;
}

std::vector<Operation> operations(const ApiVocabulary& vocabulary) {
    std::vector<Operation> all;
    for (std::vector<Operation>& some :
         std::array{scene_operations(), catalogue_operations(), job_operations(), job_output_operations(vocabulary),
                    comparison_operations(vocabulary), sequence_operations(), image_operations(vocabulary),
                    daemon_operations(vocabulary)})
        all.insert(all.end(), std::move_iterator(some.begin()), std::move_iterator(some.end()));
    return all;
}

}  // namespace

std::string artefact_link(const std::string& name) { return name.substr(0, name.find('.')); }

json openapi_paths(const ApiVocabulary& vocabulary) {
    json paths = json::object();
    for (const Operation& operation : operations(vocabulary))
        paths[operation.path][operation.method] = operation_json(operation);
    return paths;
}

}  // namespace photond
