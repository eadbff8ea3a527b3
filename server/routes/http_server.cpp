#include "server/routes/http_server.h"

#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <utility>

#include "server/routes/answer_pool.h"
#include "server/routes/awaited_jobs.h"
#include "server/routes/event_streams.h"
#include "server/routes/hub.h"
#include "server/routes/judge.h"
#include "server/routes/routes.h"

namespace photond {
namespace {

// The store serves one at a time: more threads would only queue there.
constexpr http::LaneSettings kQuick{
    .threads = 8, .max_waiting = 4096, .most_wait_seconds = 10, .most_work_seconds = 30};
// Few, so that long lists neither hold up what is quick nor lie half made in memory by the dozen.
constexpr http::LaneSettings kList{.threads = 2, .max_waiting = 4096, .most_wait_seconds = 10, .most_work_seconds = 30};
constexpr http::LaneSettings kLong{.threads = 4, .max_waiting = 512, .most_wait_seconds = 60, .most_work_seconds = 120};
// These wait for a helper most of the time, whose own requests have a limit.
constexpr http::LaneSettings kHelper{
    .threads = 8, .max_waiting = 512, .most_wait_seconds = 60, .most_work_seconds = 120, .waits_for_helper = true};

std::vector<http::Route> all_routes(Service& service) {
    std::vector<http::Route> routes;
    http::add_scene_routes(routes, service);
    http::add_job_routes(routes, service);
    http::add_artefact_routes(routes, service);
    http::add_render_routes(routes, service);
    http::add_comparison_routes(routes, service);
    http::add_sequence_routes(routes, service);
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

// A connection is a descriptor, an upload or an artefact being sent another: the usual soft limit of 1024 is no limit
// of ours. Returns what the system grants.
uint64_t raise_descriptor_limit(uint32_t max_connections) {
    rlimit limit{};
    if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return 0;
    const rlim_t wanted = rlim_t{2} * max_connections + 1024;
    if (limit.rlim_cur < wanted) {
        limit.rlim_cur = std::min(wanted, limit.rlim_max);
        setrlimit(RLIMIT_NOFILE, &limit);
        getrlimit(RLIMIT_NOFILE, &limit);
    }
    return limit.rlim_cur;
}

size_t open_descriptors() {
    std::error_code error;
    const std::filesystem::directory_iterator all("/proc/self/fd", error);
    return static_cast<size_t>(std::distance(begin(all), end(all)));
}

http::HubSettings hub_settings(const Options& options) {
    http::HubSettings settings;
    settings.max_connections = options.limits.max_connections;
    settings.head_timeout_seconds = options.limits.head_timeout_seconds;
    settings.body_timeout_seconds = options.limits.body_timeout_seconds;
    settings.stall_timeout_seconds = 2 * options.limits.head_timeout_seconds;

    // What is left beside the files of the store, the processes and a few that come and go.
    constexpr uint64_t kSpareDescriptors = 20;
    const uint64_t granted = raise_descriptor_limit(settings.max_connections);
    const uint64_t taken = open_descriptors() + kSpareDescriptors;
    const uint64_t free = granted > taken ? granted - taken : 0;
    settings.max_surplus = static_cast<uint32_t>(std::clamp<uint64_t>(free / 8, 1, settings.max_surplus));
    const uint64_t places = std::max<uint64_t>(1, (free - std::min<uint64_t>(free, settings.max_surplus)) / 2);
    if (places < settings.max_connections) {
        settings.max_connections = static_cast<uint32_t>(places);
        spdlog::warn("the system grants {} file descriptors: {} connections at once, not {}", granted, places,
                     options.limits.max_connections);
    }
    return settings;
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
          awaited(service.events(), {.again = [this](auto& connection) { return helper.submit(connection); },
                                     .answered = [this](auto connection) { hub.answered(std::move(connection)); },
                                     .gone = [this] { service.metrics().http_client_gone(); }}),
          hub(hub_settings(service.options()), callbacks(), std::move(listener)),
          quick(kQuick, lane_callbacks()),
          list(kList, lane_callbacks()),
          long_lane(kLong, lane_callbacks()),
          helper(kHelper, lane_callbacks()),
          bulk(kHelper, lane_callbacks()) {}

    http::HubCallbacks callbacks() {
        return {
            .judge = [this](http::Exchange& exchange) { judge(exchange); },
            .spool_path = [this] { return service.make_spool_path(); },
            .dispatch =
                [this](std::unique_ptr<http::Connection>& connection) {
                    http::Exchange& exchange = *connection->exchange;
                    exchange.memory.emplace(memory, client_of(exchange.call));
                    return lane_of(exchange).submit(connection);
                },
            .stream = [this](std::unique_ptr<http::Connection> connection) { streams.adopt(std::move(connection)); },
            .finished =
                [this](const http::Exchange& exchange, double seconds) {
                    // The pattern, never the path: a metric's labels must be few.
                    service.metrics().http_request(exchange.route != nullptr ? exchange.route->pattern : "none",
                                                   exchange.reply.status, seconds);
                },
            .memory = memory};
    }
    http::LaneCallbacks lane_callbacks() {
        return {.done = [this](auto connection) { hub.answered(std::move(connection)); },
                .gone = [this] { service.metrics().http_client_gone(); },
                .needs_helper = [this](auto& connection) { return helper.submit(connection); },
                .awaits_job = [this](auto connection) { awaited.hold(std::move(connection)); }};
    }
    http::AnswerPool& lane_of(const http::Exchange& exchange) {
        const http::Route& route = *exchange.route;
        const bool json = route.lane_of_json && exchange.call.head.media_type() == "application/json";
        switch (json ? *route.lane_of_json : route.lane) {
            case http::Lane::List: return list;
            case http::Lane::Long: return long_lane;
            case http::Lane::Helper: return helper;
            case http::Lane::Bulk: return bulk;
            case http::Lane::Instant:  // answered by the hub itself
            case http::Lane::Quick: break;
        }
        return quick;
    }

    Service& service;
    const std::vector<http::Route> routes;
    http::Judge judge;
    http::AnswerMemory memory{service.options().limits.answer_memory_bytes};
    http::EventStreams streams;
    http::AwaitedJobs awaited;
    http::Hub hub;
    http::AnswerPool quick, list, long_lane, helper, bulk;
    bool running = false;
};

HttpServer::HttpServer(Service& service, const TokenList* tokens, http::Listener listener)
    : impl_(std::make_unique<Impl>(service, tokens, std::move(listener))) {}

HttpServer::~HttpServer() { stop(0); }

void HttpServer::start() {
    impl_->streams.start();
    impl_->awaited.start();
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
    impl_->awaited.let_go();
    impl_->hub.drain(grace_seconds);
    for (http::AnswerPool* pool : {&impl_->quick, &impl_->list, &impl_->long_lane, &impl_->helper, &impl_->bulk})
        pool->stop();
    impl_->hub.stop();
    impl_->awaited.stop();
    impl_->streams.stop();
}

}  // namespace photond
