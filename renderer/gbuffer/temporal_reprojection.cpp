#include "renderer/gbuffer/temporal_reprojection.h"

#include <algorithm>
#include <cstring>

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

struct TemporalReprojection::Sums {
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
           size.pixels() * (sizeof(PixelSums) + kWindowBytes + kChangeBytes);
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
    method_->begin(context, stats);
    const StageTimer timer(stats, "reprojection");
    sums_ = std::make_unique<Sums>();
    std::optional<History> before;
    if (!before_.left.empty()) before = History::decode(before_.left, size);
    sums_->found = reproject(context, before ? &*before : nullptr, before_.pose.get());
    sums_->pixels.resize(size.pixels());
    before_ = {};
    context.budget.record(std::string(kStructureName),
                          Reprojected::bytes_for(size) + sums_->pixels.size() * sizeof(PixelSums));
    if (state_before_.empty()) return;
    const size_t bytes = sums_->pixels.size() * sizeof(PixelSums);
    const char* const at = state_before_.data() + followed_.size();
    if (state_before_.size() != followed_.size() + sizeof sums_->passes + bytes)
        throw Error(ErrorCode::Conflict, "the film to go on with is of another size");
    std::memcpy(&sums_->passes, at, sizeof sums_->passes);
    std::memcpy(sums_->pixels.data(), at + sizeof sums_->passes, bytes);
    state_before_.clear();
}

void TemporalReprojection::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    sums_->pass_complete = false;
    method_->run_pass(pass, stats, cancel);
    sums_->pass_complete = !cancel.cancelled();
}

PassImage* TemporalReprojection::end_pass() {
    PassImage* image = method_->end_pass();
    if (!image || !sums_->pass_complete) return nullptr;
    sums_->pass_complete = false;
    const Reprojected& found = sums_->found;
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
        PixelSums& sums = sums_->pixels[at];
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
    ++sums_->passes;
    return image;
}

std::string TemporalReprojection::state() const {
    TextsOfBoth state{method_->state(), sums_ ? followed_ : state_before_};
    if (sums_)
        state.own.append(reinterpret_cast<const char*>(&sums_->passes), sizeof sums_->passes)
            .append(reinterpret_cast<const char*>(sums_->pixels.data()), sums_->pixels.size() * sizeof(PixelSums));
    return state.joined();
}

std::string TemporalReprojection::left_to_next() const {
    History left = sums_->found.now;
    const double scale = 1 / static_cast<double>(std::max(sums_->passes, 1u));
    for (size_t at = 0; at < sums_->pixels.size(); ++at) {
        const PixelSums& sums = sums_->pixels[at];
        left.indirect[at] = Rgb(scale * sums.indirect), left.frames[at] = static_cast<float>(scale * sums.frames);
        left.near_light[at] = Rgb(scale * sums.near_light), left.near_step[at] = Rgb(scale * sums.near_step);
        left.step_product[at] = static_cast<float>(scale * sums.step_product);
        left.age[at] = static_cast<float>(scale * sums.age);
    }
    return TextsOfBoth{method_->left_to_next(), left.encode()}.joined();
}

}  // namespace photond
