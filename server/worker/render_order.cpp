#include "server/worker/render_order.h"

#include "protocol/error.h"
#include "server/job_vocabulary.h"

namespace photond {

using nlohmann::json;

namespace {

/// A member that may be absent or null.
template <class Value>
std::optional<Value> optional_member(const json& object, const char* name) {
    const auto member = object.find(name);
    if (member == object.end() || member->is_null()) return std::nullopt;
    return member->get<Value>();
}

SceneVariant variant_of(const JobRequest& request, const json& order) {
    SceneVariant variant;
    if (request.environment) {
        variant.environment_id = request.environment->image;
        variant.environment_path = order.at("environment").at("path").get<std::string>();
        variant.environment_scale = request.environment->scale;
        variant.environment_rotation = request.environment->rotation;
    }
    variant.solid_glass = request.glass == "solid";
    variant.time_s = request.time;
    return variant;
}

}  // namespace

RenderOrder RenderOrder::from_json(const json& order, uint64_t most_memory_bytes, unsigned most_threads) {
    RenderOrder read;
    read.job = order.at("job");
    read.attempt = order.value("attempt", json(nullptr));
    read.request = parse_job_request(order.at("request"), job_vocabulary());
    read.source = SceneSource::from_json(order.at("scene"));
    read.variant = variant_of(read.request, order);
    read.film = order.at("film").get<std::string>();
    if (const auto path = optional_member<std::string>(order, "resume")) read.resume = *path;
    if (const auto reference = optional_member<json>(order, "reference")) read.reference = *reference;
    if (read.request.reference && read.reference.is_null())
        throw Error(ErrorCode::Internal, "/reference", "the job has a reference, and its order names no file of it");
    read.streams = random_streams_named(optional_member<std::string>(order, "streams").value_or("job"));
    read.save_seconds = optional_member<double>(order, "save_seconds");
    const json limits = order.value("limits", json::object());
    read.memory_bytes = std::min(most_memory_bytes, limits.value("memory_bytes", most_memory_bytes));
    const unsigned asked_threads = limits.value("threads", most_threads);
    read.threads = asked_threads == 0 ? most_threads : std::min(most_threads, asked_threads);
    return read;
}

}  // namespace photond
