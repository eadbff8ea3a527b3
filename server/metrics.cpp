#include "server/metrics.h"

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>

#include <nlohmann/json.hpp>

namespace photond {

namespace {

const prometheus::Histogram::BucketBoundaries kRequestSeconds = {0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1,
                                                                 0.25,  0.5,    1,     2.5,  5,     10};
const prometheus::Histogram::BucketBoundaries kJobSeconds = {0.01, 0.05, 0.1, 0.5,  1,    5,    10,
                                                             30,   60,   300, 1800, 7200, 43200};

double number(const nlohmann::json& value) { return value.is_number() ? value.get<double>() : 0.0; }

}  // namespace

struct Metrics::Families {
    template <class T>
    using Family = prometheus::Family<T>;

    prometheus::Registry registry;
    Family<prometheus::Counter>& jobs = prometheus::BuildCounter()
                                            .Name("photond_jobs_total")
                                            .Help("Jobs that are over, by how they ended")
                                            .Register(registry);
    prometheus::Histogram& queue_seconds = prometheus::BuildHistogram()
                                               .Name("photond_job_queue_seconds")
                                               .Help("Time a job waited before its first attempt")
                                               .Register(registry)
                                               .Add({}, kJobSeconds);
    Family<prometheus::Histogram>& render_seconds = prometheus::BuildHistogram()
                                                        .Name("photond_job_render_seconds")
                                                        .Help("Render time of jobs that are over")
                                                        .Register(registry);
    prometheus::Gauge& queue =
        prometheus::BuildGauge().Name("photond_queue_depth").Help("Jobs waiting").Register(registry).Add({});
    prometheus::Gauge& pictures = prometheus::BuildGauge()
                                      .Name("photond_pictures_waiting")
                                      .Help("Pictures to be drawn beside a job")
                                      .Register(registry)
                                      .Add({});
    Family<prometheus::Gauge>& workers = prometheus::BuildGauge()
                                             .Name("photond_workers")
                                             .Help("Worker processes, the helper included, by state")
                                             .Register(registry);
    Family<prometheus::Counter>& restarts = prometheus::BuildCounter()
                                                .Name("photond_worker_restarts_total")
                                                .Help("Worker processes replaced, by reason")
                                                .Register(registry);
    Family<prometheus::Counter>& requests = prometheus::BuildCounter()
                                                .Name("photond_http_requests_total")
                                                .Help("HTTP requests answered")
                                                .Register(registry);
    Family<prometheus::Histogram>& request_seconds = prometheus::BuildHistogram()
                                                         .Name("photond_http_request_duration_seconds")
                                                         .Help("From the request's head to the end of the answer")
                                                         .Register(registry);
    prometheus::Counter& requests_gone = prometheus::BuildCounter()
                                             .Name("photond_http_requests_abandoned_total")
                                             .Help("HTTP requests dropped because their clients had gone")
                                             .Register(registry)
                                             .Add({});
    prometheus::Gauge& event_clients =
        prometheus::BuildGauge().Name("photond_event_clients").Help("Event streams open").Register(registry).Add({});
    Family<prometheus::Counter>& rays =
        prometheus::BuildCounter().Name("photond_rays_total").Help("Rays traced by finished jobs").Register(registry);
    Family<prometheus::Counter>& photons = prometheus::BuildCounter()
                                               .Name("photond_photons_total")
                                               .Help("Photons emitted by finished jobs")
                                               .Register(registry);
    Family<prometheus::Counter>& nonfinite = prometheus::BuildCounter()
                                                 .Name("photond_nonfinite_samples_total")
                                                 .Help("Samples dropped because they were not finite")
                                                 .Register(registry);
    prometheus::Gauge& disk_free = prometheus::BuildGauge()
                                       .Name("photond_disk_free_bytes")
                                       .Help("Free space of the data directory's file system")
                                       .Register(registry)
                                       .Add({});

    Families() {
        prometheus::BuildGauge()
            .Name("photond_build_info")
            .Help("Always 1; the labels say what was built")
            .Register(registry)
            .Add({{"version", PHOTOND_VERSION}, {"compiler", __VERSION__}})
            .Set(1);
    }
};

Metrics::Metrics() : families_(std::make_unique<Families>()) {}
Metrics::~Metrics() = default;

void Metrics::http_request(const std::string& route, int status, double seconds) {
    families_->requests.Add({{"route", route}, {"code", std::to_string(status)}}).Increment();
    families_->request_seconds.Add({{"route", route}}, kRequestSeconds).Observe(seconds);
}

void Metrics::http_client_gone() { families_->requests_gone.Increment(); }

void Metrics::event_clients(int delta) { families_->event_clients.Increment(delta); }

int64_t Metrics::event_clients() const { return static_cast<int64_t>(families_->event_clients.Value()); }

void Metrics::job_ended(const std::string& state, const std::string& method, const std::string& device,
                        double render_seconds, const nlohmann::json& statistics) {
    families_->jobs.Add({{"state", state}, {"method", method}, {"device", device}}).Increment();
    families_->render_seconds.Add({{"method", method}, {"device", device}}, kJobSeconds).Observe(render_seconds);
    if (!statistics.is_object()) return;
    if (const auto counts = statistics.find("counts"); counts != statistics.end() && counts->is_object()) {
        if (const auto rays = counts->find("rays"); rays != counts->end() && rays->is_object())
            for (const auto& [kind, count] : rays->items())
                families_->rays.Add({{"kind", kind}}).Increment(number(count));
        if (const auto photons = counts->find("photons_emitted"); photons != counts->end())
            families_->photons.Add({{"method", method}}).Increment(number(*photons));
    }
    const double nonfinite = number(statistics.value("nan_count", nlohmann::json())) +
                             number(statistics.value("infinity_count", nlohmann::json()));
    families_->nonfinite.Add({{"method", method}}).Increment(nonfinite);
}

void Metrics::job_started(double queue_seconds) { families_->queue_seconds.Observe(queue_seconds); }
void Metrics::queue_depth(uint64_t jobs) { families_->queue.Set(static_cast<double>(jobs)); }
void Metrics::pictures_waiting(uint64_t pictures) { families_->pictures.Set(static_cast<double>(pictures)); }

void Metrics::workers(uint64_t ready, uint64_t busy, uint64_t failed) {
    families_->workers.Add({{"state", "ready"}}).Set(static_cast<double>(ready));
    families_->workers.Add({{"state", "busy"}}).Set(static_cast<double>(busy));
    families_->workers.Add({{"state", "failed"}}).Set(static_cast<double>(failed));
}

void Metrics::worker_restarted(const std::string& reason) { families_->restarts.Add({{"reason", reason}}).Increment(); }
void Metrics::disk_free(uint64_t bytes) { families_->disk_free.Set(static_cast<double>(bytes)); }

std::string Metrics::text() const { return prometheus::TextSerializer().Serialize(families_->registry.Collect()); }

}  // namespace photond
