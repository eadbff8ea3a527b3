#pragma once
// A pass of a method on a device, from a black image to the film.

#include <functional>
#include <optional>
#include <vector>

#include "renderer/frame/device_image.h"
#include "renderer/frame/piece_queue.h"
#include "renderer/frame/render_context.h"

namespace photond {

/// The image of a pass, on the device and on the host, and the queue of the work that makes it. A method's run_pass()
/// is run() and read(); its expect_pass(), settle() and end_pass() are those here. One image is enough, for run_pass()
/// reads a pass back before the next is begun.
///
/// Its going waits for what is under way: what records has it last, or says end() before what the steps use goes.
class DeviceFrame {
public:
    using Steps = std::vector<PieceQueue::Step>;
    /// Appends the steps of a pass, or those it begins with. The image is black before the first; the last of a pass
    /// records its readback.
    using AddSteps = std::function<void(uint32_t pass, Steps& steps)>;

    /// Takes `pass_image` of the host's budget. Borrows the scene.
    DeviceFrame(const RenderContext& context, AddSteps add_steps);
    /// What it takes of the host's memory, and of the device's.
    static uint64_t estimate_bytes(const Workload& workload);
    static uint64_t estimate_device_bytes(const Workload& workload);

    DeviceImage& image() { return image_; }
    /// The image of the pass that was read last. The host may change it before end_pass().
    PassImage& host_image() { return host_image_; }

    /// Begins the pass, unless it is begun already.
    void expect_pass(uint32_t pass);
    /// Runs its steps, or what is left of them. The device's times are added to the stages of their scopes. False:
    /// cancelled. To run the same pass again is to make it anew.
    bool run(uint32_t pass, Stats& stats, const CancelToken& cancel);
    /// run(), once more for as long as `grows`, asked after each whole pass, says that it lacked room and has more now;
    /// and read().
    bool run_with_room(uint32_t pass, Stats& stats, const CancelToken& cancel, const std::function<bool()>& grows);
    /// Goes on with the pass, a submit a piece, where what is to be done depends on what was found before.
    bool run_more(std::vector<PieceQueue::Record> pieces, Stats& stats, const CancelToken& cancel);
    /// The pass is done: its image goes to the host's, what it counted to the counts.
    void read(Stats& stats);

    void settle() { device_.wait_idle(); }
    /// As Method::end_pass(): of a pass that was read, for what was cancelled is none.
    PassImage* end_pass();
    /// Waits for what is under way, on a lost device too. Nothing is run after.
    void end() { queue_.reset(); }

private:
    gpu::Device& device_;
    const Scene& scene_;
    const AddSteps add_steps_;
    PassImage host_image_;
    DeviceImage image_;
    bool pass_complete_ = false;       // host_image_ holds a whole pass
    std::optional<uint32_t> begun_;    // the pass whose first steps are in the queue
    std::optional<PieceQueue> queue_;  // last: its going waits for work that uses the others
};

/// Says of shading what the shaders of paths have not in them, because no surface of the scene asks for it.
void note_skipped_shading(const Needs& needs, Stats& stats);

}  // namespace photond
