#pragma once
// What a request says of waiting for a job, and what becomes of it.

#include <nlohmann/json.hpp>
#include <optional>

#include "server/routes/exchange.h"
#include "server/routes/query.h"
#include "server/service.h"

namespace photond::http {

/// Of a job's object, or of the data of an event of type `state`.
bool says_that_it_is_over(const nlohmann::json& job);

/// How long a request waits, and whether the job ends with its client.
struct JobWait {
    static constexpr double kMost_seconds = 600;

    std::optional<double> seconds;  // none: it does not wait
    bool cancel_on_disconnect = false;

    /// `wait`, of a request that looks. OutOfRange at /wait.
    static JobWait read(Query& query);
    /// And `cancel_on_disconnect`, of one that submits: whoever may only look must not end a job by going away.
    static JobWait read_of_submission(Query& query);
};

/// The job's object, once it is over or the time is; throws AwaitJob before. To be called with the id of the job that
/// the request began with, also when it begins anew: Call::awaited has that.
nlohmann::json wait_for_job(Service& service, const Call& call, const std::string& id, const JobWait& wait);

}  // namespace photond::http
