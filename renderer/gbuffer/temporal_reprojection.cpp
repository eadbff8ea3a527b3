#include "renderer/gbuffer/temporal_reprojection.h"

#include <algorithm>
#include <cstring>

#include "renderer/core/copy_elements.h"
#include "renderer/core/parallel.h"
#include "renderer/core/sha256.h"
#include "renderer/gbuffer/light_change.h"
#include "renderer/gbuffer/reprojection.h"

namespace photond {

namespace {

constexpr std::string_view kStructureName = "history";

/// A pixel's sums over the passes of this frame of what it leaves to the next.
struct PixelSums {
    dvec3 indirect{0}, near_light{0}, near_step{0};
    double frames = 0, step_product = 0, age = 0;
};

/// Texts of the method within and of this one, as one.
struct TextsOfBoth {
    std::string within, own;

    std::string joined() const {
        const uint64_t length = within.size();
        std::string text(reinterpret_cast<const char*>(&length), sizeof length);
        return text.append(within).append(own);
    }
    static TextsOfBoth split(const std::string& text) {
        uint64_t length = 0;
        if (text.size() >= sizeof length) std::memcpy(&length, text.data(), sizeof length);
        if (text.size() < sizeof length || length > text.size() - sizeof length)
            throw Error(ErrorCode::Conflict, "it is not what a method of last frames' light left");
        return {text.substr(sizeof length, length), text.substr(sizeof length + length)};
    }
};

}  // namespace

struct TemporalReprojection::Frame {
    Frame(const RenderContext& context, FrameBefore frame_before)
        : scene(context.scene),
          view(context.view),
          before(std::move(frame_before)),
          hits(begin_centre_hits(context)),
          pixels(view.film_size.pixels()) {
        if (!before.left.empty()) history = History::decode(before.left, view.film_size);
        before.left.clear();
    }

    /// Where the frame before showed what this one shows, once its hits are there.
    const Reprojected& reprojected() {
        if (hits) {
            found = reproject(scene, view, hits->take(), history ? &*history : nullptr, before.pose.get());
            hits = nullptr, history = std::nullopt, before = {};
        }
        return found;
    }

    const Scene& scene;
    const View view;
    FrameBefore before;
    std::optional<History> history;
    std::unique_ptr<HitsToCome> hits;  // null: taken
    Reprojected found;
    std::vector<PixelSums> pixels;
    uint32_t passes = 0;
    bool pass_complete = false;
};

TemporalReprojection::TemporalReprojection(std::unique_ptr<Method> method, const TemporalParams& params)
    : method_(std::move(method)), history_cap_(params.history_cap) {}

TemporalReprojection::~TemporalReprojection() = default;

uint64_t TemporalReprojection::estimate_bytes(Size2 size) {
    // Beside what is kept: the frame before as text and as a history, and the windows' sums.
    constexpr uint64_t kWindowBytes = 80, kChangeBytes = 28;
    return Reprojected::bytes_for(size) + 2 * History::bytes_for(size) +
           size.pixels() * (sizeof(PixelSums) + kWindowBytes + kChangeBytes + sizeof(Ray) + sizeof(Hit));
}

void TemporalReprojection::follow(FrameBefore before) {
    TextsOfBoth left = TextsOfBoth::split(before.left);
    method_->follow({std::move(left.within), before.pose});
    followed_ = sha256_hex(before.left.data(), before.left.size());
    before_ = {std::move(left.own), std::move(before.pose)};
}

void TemporalReprojection::go_on_from(const std::string& state) {
    TextsOfBoth both = TextsOfBoth::split(state);
    if (!both.own.starts_with(followed_) ||
        (both.own.size() - followed_.size()) % sizeof(PixelSums) != sizeof(uint32_t))
        throw Error(ErrorCode::Conflict, "its passes do not follow the frame before");
    method_->go_on_from(both.within);
    state_before_ = std::move(both.own);
}

void TemporalReprojection::begin(const RenderContext& context, Stats& stats) {
    const Size2 size = context.view.film_size;
    context.budget.require(std::string(kStructureName), estimate_bytes(size));
    {
        const StageTimer timer(stats, "reprojection");
        frame_ = std::make_unique<Frame>(context, std::exchange(before_, {}));
    }
    method_->begin(context, stats);  // the rays are under way
    context.budget.record(std::string(kStructureName),
                          Reprojected::bytes_for(size) + frame_->pixels.size() * sizeof(PixelSums));
    if (state_before_.empty()) return;
    const size_t bytes = frame_->pixels.size() * sizeof(PixelSums);
    const char* const at = state_before_.data() + followed_.size();
    if (state_before_.size() != followed_.size() + sizeof frame_->passes + bytes)
        throw Error(ErrorCode::Conflict, "the film to go on with is of another size");
    std::memcpy(&frame_->passes, at, sizeof frame_->passes);
    copy_elements(at + sizeof frame_->passes, std::span(frame_->pixels));
    state_before_.clear();
}

void TemporalReprojection::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    frame_->pass_complete = false;
    method_->expect_pass(pass);  // a device begins the pass, and the host follows the points back meanwhile
    {
        const StageTimer timer(stats, "reprojection");
        frame_->reprojected();
    }
    method_->run_pass(pass, stats, cancel);
    frame_->pass_complete = !cancel.cancelled();
}

PassImage* TemporalReprojection::end_pass() {
    PassImage* image = method_->end_pass();
    if (!image || !frame_->pass_complete) return nullptr;
    frame_->pass_complete = false;
    const Reprojected& found = frame_->reprojected();
    std::vector<Rgb>& indirect = image->of<Layer::Indirect>();
    const LightChange light = find_light_change(found, indirect);
    const LayerSet layers = image->layers;
    const float least_share = 1 / static_cast<float>(history_cap_);
    parallel_for(indirect.size(), 4096, [&](size_t at) {
        const bool has_history = found.rejection[at] == Rejection::None;
        // A pixel that is no number stays what it is, for the film to drop and to count; the history goes on without.
        const bool tells = is_finite(indirect[at]);
        const float own = has_history ? std::max(light.own_share[at], least_share) : 1, frames = 1 / own;
        if (has_history && tells) indirect[at] = glm::mix(found.past.indirect[at], indirect[at], own);
        PixelSums& sums = frame_->pixels[at];
        sums.indirect += dvec3(tells ? indirect[at] : found.past.indirect[at]);
        sums.frames += tells ? frames : found.past.frames[at];
        sums.near_light += dvec3(light.near_light[at]), sums.near_step += dvec3(light.near_step[at]);
        sums.step_product += light.step_product[at], sums.age += light.age[at];
        if (layers.has(Layer::HistoryLength)) image->of<Layer::HistoryLength>()[at] = frames;
        if (layers.has(Layer::Reused)) image->of<Layer::Reused>()[at] = 1 - own;
        if (!layers.has(Layer::Rejected)) return;
        // As far as it is more than its share among so many frames.
        const float most = std::min(found.past.frames[at], static_cast<float>(history_cap_ - 1));
        const float kept = has_history && most > 0 ? (frames - 1) / most : 1;
        image->of<Layer::Rejected>()[at] = {found.rejection[at] == Rejection::Surface ? 1 : 0, 1 - std::min(kept, 1.0f),
                                            found.rejection[at] == Rejection::Outside ? 1 : 0};
    });
    ++frame_->passes;
    return image;
}

std::string TemporalReprojection::state() const {
    TextsOfBoth state{method_->state(), frame_ ? followed_ : state_before_};
    if (frame_)
        state.own.append(reinterpret_cast<const char*>(&frame_->passes), sizeof frame_->passes)
            .append(reinterpret_cast<const char*>(frame_->pixels.data()), frame_->pixels.size() * sizeof(PixelSums));
    return state.joined();
}

std::string TemporalReprojection::left_to_next() const {
    History left = frame_->reprojected().now;
    const double scale = 1 / static_cast<double>(std::max(frame_->passes, 1u));
    for (size_t at = 0; at < frame_->pixels.size(); ++at) {
        const PixelSums& sums = frame_->pixels[at];
        left.indirect[at] = Rgb(scale * sums.indirect), left.frames[at] = static_cast<float>(scale * sums.frames);
        left.near_light[at] = Rgb(scale * sums.near_light), left.near_step[at] = Rgb(scale * sums.near_step);
        left.step_product[at] = static_cast<float>(scale * sums.step_product);
        left.age[at] = static_cast<float>(scale * sums.age);
    }
    return TextsOfBoth{method_->left_to_next(), left.encode()}.joined();
}

}  // namespace photond
