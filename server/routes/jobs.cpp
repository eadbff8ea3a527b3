#include "protocol/job.h"

#include <charconv>

#include "protocol/strict_json.h"
#include "server/routes/event_streams.h"
#include "server/routes/idempotency.h"
#include "server/routes/job_wait.h"
#include "server/routes/query.h"
#include "server/routes/routes.h"

namespace photond::http {
namespace {

Reply job_reply(int status, const nlohmann::json& job) {
    Reply reply = json_reply(status, job);
    reply.headers["Location"] = "/v1/jobs/" + job.at("id").get<std::string>();
    return reply;
}

/// 200 with a job that is over, else 202.
Reply awaited_reply(Service& service, const Call& call, const std::string& id, const JobWait& wait) {
    const nlohmann::json job = wait_for_job(service, call, id, wait);
    return job_reply(says_that_it_is_over(job) ? 200 : 202, job);
}

Reply submit_job(Service& service, Call& call) {
    Query query(call.query);
    const bool dry_run = query.flag("dry_run");
    const JobWait wait = JobWait::read_of_submission(query);
    query.finish();
    if (call.awaited) return awaited_reply(service, call, call.awaited->job, wait);
    const JobRequest request = parse_job_request(parse_strict_json(call.body), service.vocabulary());
    const std::optional<std::string> key = idempotency_key(call);
    if (dry_run) return json_reply(200, service.estimate_job(request));  // a key binds to what is queued: not to this
    const nlohmann::json job = service.submit_job(request, key, naming_json(request).dump());
    if (wait.seconds) return awaited_reply(service, call, job.at("id"), wait);
    return job_reply(202, job);
}

Reply get_job(Service& service, Call& call) {
    Query query(call.query);
    const JobWait wait = JobWait::read(query);
    query.finish();
    return json_reply(200, wait_for_job(service, call, call.path_parameters[0], wait));
}

Reply list_jobs(Service& service, Call& call) {
    Query query(call.query);
    JobFilter filter;
    filter.view = query.text("view", "full");
    filter.state = query.text("state");
    filter.label = query.text("label");
    filter.scene = query.text("scene");
    filter.method = query.text("method");
    filter.device = query.text("device");
    filter.role = query.text("role");
    filter.order = query.text("order", "newest");
    filter.limit = query.integer("limit", 100);
    filter.cursor = query.text("cursor");
    filter.offset = query.integer("offset", 0);
    query.finish();
    return json_text_reply(call, [&](const TextSink& write) { service.list_jobs(filter, write); });
}

Reply remove_job(Service& service, Call& call) {
    Query query(call.query);
    const bool purge = query.flag("purge");
    query.finish();
    const Service::Cancelled cancelled =
        purge ? service.purge_job(call.path_parameters[0]) : service.cancel_job(call.path_parameters[0]);
    return json_reply(cancelled.was_over ? 200 : 202, cancelled.object);
}

// Where a stream begins. A client that comes back says where it was; an id we never gave out is of another store, and
// such a client starts with what happens now.
std::optional<uint64_t> resume_after(const Call& call, const EventHub& events) {
    const std::string* header = call.head.header("last-event-id");
    if (header == nullptr || header->empty()) return std::nullopt;
    uint64_t id = 0;
    const auto [end, error] = std::from_chars(header->data(), header->data() + header->size(), id);
    if (error != std::errc() || end != header->data() + header->size())
        throw Error(ErrorCode::BadRequest, "Last-Event-ID must be a number this service gave out");
    return id <= events.last_id() ? std::optional(id) : std::nullopt;
}

// The first thing on a job's new stream is the job as it is, so that nothing can fall between a GET and the
// subscription.
std::string state_now(const nlohmann::json& job, uint64_t id) {
    nlohmann::json data;
    for (const char* key :
         {"id", "state", "progress", "passes_done", "seconds", "error_now", "started", "finished", "failure"})
        data[key] = job.contains(key) ? job.at(key) : nlohmann::json(nullptr);
    data["priority"] = job.at("request").at("priority");
    return "event: state\nid: " + std::to_string(id) +
           "\ndata: " + data.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n\n";
}

Reply job_events(Service& service, Call& call) {
    Query(call.query).finish();
    const std::string& id = call.path_parameters[0];
    const EventHub& events = service.events();
    const std::optional<uint64_t> resume = resume_after(call, events);
    const uint64_t now = events.last_id();  // before the job is read: an event may come twice, never be missed
    const nlohmann::json job = service.get_job(id);
    Reply reply;
    reply.events = EventSubscription{job.at("id").get<std::string>(), resume.value_or(now),
                                     "retry: 1000\n\n" + (resume ? "" : state_now(job, now))};
    return reply;
}

Reply all_events(Service& service, Call& call) {
    Query(call.query).finish();
    const EventHub& events = service.events();
    Reply reply;
    reply.events = EventSubscription{"", resume_after(call, events).value_or(events.last_id()),
                                     "retry: 1000\n\n: listening\n\n" + status_event_text(service.status())};
    return reply;
}

}  // namespace

void add_job_routes(std::vector<Route>& routes, Service& service) {
    routes.push_back(
        {.method = "POST", .pattern = "/v1/jobs", .body = BodyKind::Json, .handle = [&service](Call& call) {
             return submit_job(service, call);
         }});
    routes.push_back({.method = "GET", .pattern = "/v1/jobs", .lane = Lane::List, .handle = [&service](Call& call) {
                          return list_jobs(service, call);
                      }});
    routes.push_back({.method = "GET", .pattern = "/v1/jobs/{id}", .handle = [&service](Call& call) {
                          return get_job(service, call);
                      }});
    routes.push_back({.method = "DELETE", .pattern = "/v1/jobs/{id}", .handle = [&service](Call& call) {
                          return remove_job(service, call);
                      }});
    routes.push_back(
        {.method = "PATCH", .pattern = "/v1/jobs/{id}", .body = BodyKind::Json, .handle = [&service](Call& call) {
             Query(call.query).finish();
             return json_reply(200, service.change_job(call.path_parameters[0], parse_strict_json(call.body)));
         }});
    routes.push_back({.method = "POST", .pattern = "/v1/jobs/{id}/repeat", .handle = [&service](Call& call) {
                          Query(call.query).finish();
                          return job_reply(202, service.repeat_job(call.path_parameters[0]));
                      }});
    routes.push_back({.method = "POST", .pattern = "/v1/jobs/{id}/retry", .handle = [&service](Call& call) {
                          Query(call.query).finish();
                          return job_reply(202, service.retry_job(call.path_parameters[0]));
                      }});
    routes.push_back(
        {.method = "POST", .pattern = "/v1/jobs/{id}/extend", .body = BodyKind::Json, .handle = [&service](Call& call) {
             Query(call.query).finish();
             return job_reply(202, service.extend_job(call.path_parameters[0], parse_strict_json(call.body)));
         }});
    routes.push_back({.method = "POST",
                      .pattern = "/v1/jobs/merge",
                      .body = BodyKind::Json,
                      .lane = Lane::Bulk,
                      .handle = [&service](Call& call) {
                          Query(call.query).finish();
                          const std::optional<std::string> key = idempotency_key(call);
                          return job_reply(201, service.merge_jobs(parse_strict_json(call.body), key));
                      }});
    routes.push_back({.method = "GET", .pattern = "/v1/jobs/{id}/events", .handle = [&service](Call& call) {
                          return job_events(service, call);
                      }});
    routes.push_back({.method = "GET", .pattern = "/v1/events", .handle = [&service](Call& call) {
                          return all_events(service, call);
                      }});
}

}  // namespace photond::http
