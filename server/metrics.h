#pragma once
// Prometheus metrics of the daemon: base units, never labelled by job, scene or token (reliability.md, "HTTP habits").

#include <cstdint>
#include <memory>
#include <string>

#include <nlohmann/json_fwd.hpp>

namespace photond {

/// Thread-safe.
class Metrics {
public:
    Metrics();
    ~Metrics();

    // The routes' side. `route` is the pattern ("/v1/jobs/{id}"), never the path.
    void http_request(const std::string& route, int status, double seconds);
    /// A request that nobody waited for any more when its turn came.
    void http_client_gone();
    void event_clients(int delta);
    int64_t event_clients() const;

    // The service's side.
    void job_ended(const std::string& state, const std::string& method, const std::string& device,
                   double render_seconds, const nlohmann::json& statistics);
    void job_started(double queue_seconds);
    void queue_depth(uint64_t jobs);
    void pictures_waiting(uint64_t pictures);
    void workers(uint64_t ready, uint64_t busy, uint64_t failed);
    void worker_restarted(const std::string& reason);
    void disk_free(uint64_t bytes);

    /// Text exposition format, version 0.0.4.
    std::string text() const;

private:
    struct Families;
    std::unique_ptr<Families> families_;
};

}  // namespace photond
