#include "clients/cli/job_follower.h"

#include <chrono>

#include "clients/cli/event_stream.h"

namespace photond::cli {

namespace {

using nlohmann::json;

constexpr std::chrono::seconds kStreamConnectLimit{10};
constexpr std::chrono::seconds kSilenceLimit{45};  // a few of the stream's heartbeats
constexpr std::chrono::milliseconds kPollJobEvery{500};
constexpr int kStreamTries = 3;  // without one event between them; then polling

class Follower {
public:
    Follower(DaemonClient& daemon, const std::string& id, const JobListener& listener)
        : daemon_(daemon), path_(resource_path("jobs", id)), listener_(listener) {}

    json run() {
        refresh();
        int fruitless = 0;
        while (!is_over(job_)) {
            const uint64_t before = events_;
            const bool streams = fruitless < kStreamTries && stream();
            if (daemon_.interrupt().cause() != Interrupt::Cause::None) throw interrupted(daemon_.interrupt().cause());
            fruitless = streams && events_ > before ? 0 : fruitless + 1;
            if (!is_over(job_) && !daemon_.interrupt().sleep(kPollJobEvery))
                throw interrupted(daemon_.interrupt().cause());
            refresh();  // the whole object, with its statistics when it is over; the last word over any event
        }
        return job_;
    }

private:
    void refresh() {
        json now = daemon_.get(path_);
        if (now == job_) return;
        const bool new_state = job_.is_null() || now.value("state", "") != job_.value("state", "");
        job_ = std::move(now);
        listener_(job_, new_state ? "state" : "progress");
    }

    /// One connection to the event stream, until the job is over or the connection is. False: there is no stream.
    bool stream() {
        HttpClient http(daemon_.options().url, kStreamConnectLimit, kSilenceLimit);
        const Interrupt::Stopper stopper(daemon_.interrupt(), [&http] { http.stop(); });
        HttpRequest request;
        request.path = path_ + "/events";
        request.headers = daemon_.common_headers();
        request.headers.emplace_back("Accept", "text/event-stream");
        if (!parser_.last_event_id().empty()) request.headers.emplace_back("Last-Event-ID", parser_.last_event_id());
        parser_.reconnect();

        ReplySink sink;
        sink.head = [this](const HttpReply& reply) {
            if (reply.status != 200) return true;
            // The stream stands; what happened between the last look and now is not in it.
            refresh();
            return !is_over(job_);
        };
        sink.data = [this](std::string_view bytes) {
            for (const ServerEvent& event : parser_.feed(bytes)) take(event);
            return !is_over(job_);
        };
        try {
            return http.exchange(request, &sink).status == 200;
        } catch (const TransportError&) {
            return true;  // the caller looks at the job and decides
        }
    }

    void take(const ServerEvent& event) {
        const json changes = json::parse(event.data, nullptr, false);
        if (!changes.is_object()) return;
        ++events_;
        job_.update(changes);
        listener_(job_, event.type);
    }

    DaemonClient& daemon_;
    std::string path_;
    const JobListener& listener_;
    EventParser parser_;
    json job_;
    uint64_t events_ = 0;
};

}  // namespace

bool is_over(const json& job) {
    const std::string state = job.value("state", "");
    return state == "succeeded" || state == "failed" || state == "cancelled";
}

json follow_job(DaemonClient& daemon, const std::string& id, const JobListener& listener) {
    return Follower(daemon, id, listener).run();
}

}  // namespace photond::cli
