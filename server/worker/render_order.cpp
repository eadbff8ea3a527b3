#include "server/worker/render_order.h"

#include <algorithm>

#include "protocol/error.h"
#include "server/job_vocabulary.h"

namespace photond {

namespace {

SceneVariant variant_of(const JobRequest& request, const RenderMessage& message) {
    SceneVariant variant;
    if (request.environment) {
        if (!message.environment)
            throw Error(ErrorCode::Internal, "/environment",
                        "the job has an environment, and its order names no file of it");
        variant.environment_id = request.environment->image;
        variant.environment_path = message.environment->path;
        variant.environment_scale = request.environment->scale;
        variant.environment_rotation = request.environment->rotation;
    }
    variant.solid_glass = request.glass == "solid";
    return variant;
}

}  // namespace

RenderOrder RenderOrder::of(const RenderMessage& message, uint64_t most_memory_bytes, unsigned most_threads) {
    RenderOrder order;
    order.job = message.job;
    order.attempt = message.attempt;
    order.request = parse_job_request(message.request, job_vocabulary());
    order.source = message.scene;
    order.variant = variant_of(order.request, message);
    order.moment = {order.request.animation, order.request.time};
    order.film = message.film;
    order.origin = message.origin;
    order.resume = message.resume;
    order.before = message.before;
    order.reference = message.reference;
    if (order.request.reference && !order.reference)
        throw Error(ErrorCode::Internal, "/reference", "the job has a reference, and its order names no file of it");
    order.streams = random_streams_named(message.streams);
    order.save_seconds = message.save_seconds;
    order.memory_bytes = std::min(most_memory_bytes, message.limits.memory_bytes);
    order.threads = message.limits.threads == 0 ? most_threads : std::min(most_threads, message.limits.threads);
    return order;
}

}  // namespace photond
