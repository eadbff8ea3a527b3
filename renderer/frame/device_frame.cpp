#include "renderer/frame/device_frame.h"

#include "renderer/backends/gpu/device_scene.h"
#include "renderer/scene/scene.h"

namespace photond {

namespace {

/// The host's image, where it has room.
PassImage make_host_image(const RenderContext& context) {
    const uint64_t bytes = PassImage::bytes_for(context.view.film_size, context.view.layers);
    context.budget.require("pass_image", bytes);
    PassImage image(context.view.film_size, context.view.layers);
    context.budget.record("pass_image", bytes);
    return image;
}

}  // namespace

DeviceFrame::DeviceFrame(const RenderContext& context, AddSteps add_steps)
    : device_(context.device_scene->device()),
      scene_(context.scene),
      add_steps_(std::move(add_steps)),
      host_image_(make_host_image(context)),
      image_(device_, context.view.film_size, context.view.layers),
      queue_(std::in_place, device_) {}

uint64_t DeviceFrame::estimate_bytes(const Workload& workload) {
    return PassImage::bytes_for(workload.film_size, workload.layers);
}

uint64_t DeviceFrame::estimate_device_bytes(const Workload& workload) {
    return DeviceImage::device_bytes(workload.film_size, workload.layers) +
           DeviceImage::host_bytes(workload.film_size, workload.layers);
}

void DeviceFrame::expect_pass(uint32_t pass) {
    if (begun_ == pass) return;
    Steps steps;
    steps.push_back({0, [this](gpu::CommandList& commands) { image_.record_clear(commands); }});
    add_steps_(pass, steps);
    queue_->start(PieceQueue::pieces_of(device_, std::move(steps)));
    begun_ = pass;
}

bool DeviceFrame::run(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    pass_complete_ = false;
    expect_pass(pass);
    begun_.reset();
    return queue_->finish(stats, cancel) && !cancel.cancelled();
}

bool DeviceFrame::run_with_room(uint32_t pass, Stats& stats, const CancelToken& cancel,
                                const std::function<bool()>& grows) {
    do {
        if (!run(pass, stats, cancel)) return false;
    } while (grows());
    read(stats);
    return true;
}

bool DeviceFrame::run_more(std::vector<PieceQueue::Record> pieces, Stats& stats, const CancelToken& cancel) {
    return queue_->run(std::move(pieces), stats, cancel) && !cancel.cancelled();
}

void DeviceFrame::read(Stats& stats) {
    image_.read(host_image_, stats.counts, scene_.origin);
    pass_complete_ = true;
}

PassImage* DeviceFrame::end_pass() { return pass_complete_ ? &host_image_ : nullptr; }

void note_skipped_shading(const Needs& needs, Stats& stats) {
    if (needs.only_lambert())
        stats.skipped.push_back({"layered shading", "every surface is a plain Lambert reflector", 0});
    if (!needs.solid_glass) stats.skipped.push_back({"absorption", "no solid refracts", 0});
}

}  // namespace photond
