#include <filesystem>
#include <fstream>
#include <sstream>

#include "protocol/job.h"
#include "protocol/strict_json.h"
#include "server/routes/accept.h"
#include "server/routes/file_reply.h"
#include "server/routes/idempotency.h"
#include "server/routes/job_wait.h"
#include "server/routes/query.h"
#include "server/routes/routes.h"
#include "server/routes/uploaded_scene.h"

namespace photond::http {
namespace {

constexpr const char *kPng = "image/png", *kExr = "image/x-exr", *kJson = "application/json";
constexpr double kWait_seconds = 60;  // unless the request says how long

std::string read_text(const std::filesystem::path& path) {
    std::ostringstream text;
    text << std::ifstream(path, std::ios::binary).rdbuf();
    return text.str();
}

/// The job's request: the body, or what the form's field `job` says of the scene that came with it.
nlohmann::json read_request(Service& service, Call& call) {
    const size_t most_bytes = service.options().limits.max_json_bytes;
    if (call.head.media_type() == kJson) {
        if (call.head.content_length > most_bytes)
            throw Error(ErrorCode::PayloadTooLarge, "the request has " + std::to_string(call.head.content_length) +
                                                        " bytes, the limit is " + std::to_string(most_bytes));
        return parse_strict_json(read_text(call.spool.path()));
    }
    UploadedScene uploaded(service, call, {{"job", most_bytes}});
    nlohmann::json request =
        parse_strict_json(uploaded.form().fields.count("job") ? uploaded.form().fields.at("job") : "{}");
    if (!request.is_object()) throw Error(ErrorCode::WrongType, "/job", "the form's field \"job\" is no JSON object");
    if (uploaded.form().files == 0) return request;
    if (request.contains("scene"))
        throw Error(ErrorCode::Conflict, "/scene", "the request names a scene, and the form brings one");
    request["scene"] = uploaded.add(service).object.at("id");
    return request;
}

std::string submit(Service& service, Call& call) {
    const std::optional<std::string> key = idempotency_key(call);
    const JobRequest request = parse_job_request(read_request(service, call), service.vocabulary());
    return service.submit_job(request, key, naming_json(request).dump()).at("id");
}

/// What was asked for of a job that is over.
Reply result_of(Service& service, const Call& call, const nlohmann::json& job, const std::string& type) {
    const std::string id = job.at("id"), state = job.at("state");
    if (type == kJson) return json_reply(200, job);
    if (state != "succeeded") {
        const nlohmann::json& failure = job.at("failure");
        if (state == "cancelled" || !failure.is_object()) throw Error(ErrorCode::Cancelled, id + " was cancelled");
        throw Error(error_code_named(failure.value("code", "")), id + " failed: " + failure.value("detail", ""));
    }
    return file_reply(call, type == kPng ? service.preview(id, {}) : service.image(id, "float"));
}

Reply render(Service& service, Call& call) {
    Query query(call.query);
    JobWait wait = JobWait::read_of_submission(query);
    query.finish();
    if (!wait.seconds) wait.seconds = kWait_seconds;
    const std::string type = accepted_type(call.head, {kPng, kExr, kJson});
    const std::string id = call.awaited ? call.awaited->job : submit(service, call);
    const nlohmann::json job = wait_for_job(service, call, id, wait);
    Reply reply = says_that_it_is_over(job) ? result_of(service, call, job, type) : json_reply(202, job);
    reply.headers["Location"] = "/v1/jobs/" + id;
    reply.headers["Vary"] = "Accept";
    return reply;
}

}  // namespace

void add_render_routes(std::vector<Route>& routes, Service& service) {
    routes.push_back({.method = "POST",
                      .pattern = "/v1/render",
                      .body = BodyKind::Upload,
                      .lane = Lane::Bulk,
                      .lane_of_json = Lane::Quick,
                      .media_types = {kJson, "multipart/form-data"},
                      .handle = [&service](Call& call) { return render(service, call); }});
}

}  // namespace photond::http
