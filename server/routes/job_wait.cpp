#include "server/routes/job_wait.h"

#include "server/steady_seconds.h"

namespace photond::http {

bool says_that_it_is_over(const nlohmann::json& job) {
    const std::string state = job.value("state", "");
    return !state.empty() && state != "queued" && state != "running";
}

JobWait JobWait::read(Query& query) {
    JobWait wait;
    wait.seconds = query.number("wait");
    if (wait.seconds && !(*wait.seconds >= 0 && *wait.seconds <= kMost_seconds))
        throw Error(ErrorCode::OutOfRange, "/wait",
                    "wait lies outside [0, " + std::to_string(static_cast<int>(kMost_seconds)) + "] seconds");
    return wait;
}

JobWait JobWait::read_of_submission(Query& query) {
    JobWait wait = read(query);
    wait.cancel_on_disconnect = query.flag("cancel_on_disconnect");
    return wait;
}

nlohmann::json wait_for_job(Service& service, const Call& call, const std::string& id, const JobWait& wait) {
    const uint64_t before = service.events().last_id();  // an event may be seen twice, never missed
    nlohmann::json job = service.get_job(id);
    const auto now = Clock::now();
    const auto until = call.awaited ? call.awaited->until : now + steady_seconds(wait.seconds.value_or(0));
    if (says_that_it_is_over(job) || until <= now) return job;
    const std::string job_id = job.at("id");
    AwaitJob awaits{.job = job_id, .after_event = before, .until = until, .client_left = {}};
    if (wait.cancel_on_disconnect) awaits.client_left = [&service, job_id] { service.cancel_job(job_id); };
    throw awaits;
}

}  // namespace photond::http
