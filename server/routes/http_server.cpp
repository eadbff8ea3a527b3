#include "server/routes/http_server.h"

#include <sys/resource.h>

#include <algorithm>
#include <utility>

#include "server/routes/answer_pool.h"
#include "server/routes/event_streams.h"
#include "server/routes/hub.h"
#include "server/routes/judge.h"
#include "server/routes/routes.h"

namespace photond {
namespace {

constexpr size_t kQuickThreads = 8;  // the store serves one at a time; more threads only queue there
constexpr size_t kLongThreads = 4;
constexpr size_t kHelperThreads = 8;  // wait for a helper most of the time
constexpr size_t kMaxWaitingQuick = 4096;
constexpr size_t kMaxWaiting = 512;  // in each of the other lanes

std::vector<http::Route> all_routes(Service& service) {
    std::vector<http::Route> routes;
    http::add_scene_routes(routes, service);
    http::add_job_routes(routes, service);
    http::add_artefact_routes(routes, service);
    http::add_comparison_routes(routes, service);
    http::add_image_routes(routes, service);
    http::add_backup_routes(routes, service);
    http::add_system_routes(routes, service);
    http::add_dashboard_routes(routes);
    return routes;
}

bool is_loopback(const std::string& address) {
    return address == "localhost" || address == "::1" || address.starts_with("127.");
}

http::JudgeSettings judge_settings(Service& service) {
    const Options& options = service.options();
    http::JudgeSettings settings;
    settings.loopback = is_loopback(options.listen_address);
    settings.max_json_bytes = options.limits.max_json_bytes;
    settings.max_upload_bytes = options.limits.max_body_bytes;
    settings.max_requests_per_second = options.limits.max_requests_per_second;
    settings.check_disk = [&service](uint64_t bytes) { service.check_disk(bytes); };
    return settings;
}

http::HubSettings hub_settings(const Options& options) {
    http::HubSettings settings;
    settings.max_connections = options.limits.max_connections;
    settings.head_timeout_seconds = options.limits.head_timeout_seconds;
    settings.body_timeout_seconds = options.limits.body_timeout_seconds;
    settings.stall_timeout_seconds = 2 * options.limits.head_timeout_seconds;
    return settings;
}

// A connection is a descriptor, an upload or an artefact being sent another: the usual soft limit of 1024 is no limit
// of ours.
void raise_descriptor_limit(uint32_t max_connections) {
    rlimit limit{};
    if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
    const rlim_t wanted = rlim_t{2} * max_connections + 1024;
    if (limit.rlim_cur >= wanted) return;
    limit.rlim_cur = std::min(wanted, limit.rlim_max);
    setrlimit(RLIMIT_NOFILE, &limit);
}

}  // namespace

struct HttpServer::Impl {
    Impl(Service& borrowed, const TokenList* tokens, http::Listener listener)
        : service(borrowed),
          routes(all_routes(service)),
          judge(judge_settings(service), routes, tokens),
          streams(
              service.events(), [this](int delta) { service.metrics().event_clients(delta); },
              [this] { return service.status(); }),
          hub(hub_settings(service.options()), callbacks(), std::move(listener)),
          quick(kQuickThreads, kMaxWaitingQuick, [this](auto connection) { hub.answered(std::move(connection)); }),
          long_lane(kLongThreads, kMaxWaiting, [this](auto connection) { hub.answered(std::move(connection)); }),
          helper(kHelperThreads, kMaxWaiting, [this](auto connection) { hub.answered(std::move(connection)); }),
          bulk(kHelperThreads, kMaxWaiting, [this](auto connection) { hub.answered(std::move(connection)); }) {}

    http::AnswerPool& pool_of(http::Lane lane) {
        switch (lane) {
            case http::Lane::Long: return long_lane;
            case http::Lane::Helper: return helper;
            case http::Lane::Bulk: return bulk;
            case http::Lane::Instant:  // answered by the hub itself
            case http::Lane::Quick: break;
        }
        return quick;
    }

    http::HubCallbacks callbacks() {
        return {
            .judge = [this](http::Exchange& exchange) { judge(exchange); },
            .spool_path = [this] { return service.make_spool_path(); },
            .dispatch =
                [this](std::unique_ptr<http::Connection>& connection) {
                    return pool_of(connection->exchange->route->lane).submit(connection);
                },
            .stream = [this](std::unique_ptr<http::Connection> connection) { streams.adopt(std::move(connection)); },
            .finished =
                [this](const http::Exchange& exchange, double seconds) {
                    // The pattern, never the path: a metric's labels must be few.
                    service.metrics().http_request(exchange.route != nullptr ? exchange.route->pattern : "none",
                                                   exchange.reply.status, seconds);
                }};
    }

    Service& service;
    const std::vector<http::Route> routes;
    http::Judge judge;
    http::EventStreams streams;
    http::Hub hub;
    http::AnswerPool quick, long_lane, helper, bulk;
    bool running = false;
};

HttpServer::HttpServer(Service& service, const TokenList* tokens, http::Listener listener)
    : impl_(std::make_unique<Impl>(service, tokens, std::move(listener))) {}

HttpServer::~HttpServer() { stop(0); }

void HttpServer::start() {
    raise_descriptor_limit(impl_->service.options().limits.max_connections);
    impl_->streams.start();
    impl_->hub.start();
    impl_->running = true;
}

std::string HttpServer::url() const {
    const std::string& address = impl_->service.options().listen_address;
    const bool is_ipv6 = address.find(':') != std::string::npos;
    return "http://" + (is_ipv6 ? "[" + address + "]" : address) + ":" + std::to_string(impl_->hub.port());
}

void HttpServer::stop(double grace_seconds) {
    if (!impl_->running) return;
    impl_->running = false;
    impl_->hub.drain(grace_seconds);
    for (http::AnswerPool* pool : {&impl_->quick, &impl_->long_lane, &impl_->helper, &impl_->bulk}) pool->stop();
    impl_->hub.stop();
    impl_->streams.stop();
}

}  // namespace photond
