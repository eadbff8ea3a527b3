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
    dvec3 indirect{0}, change{0}, squared_change{0};
    double frames = 0;
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
    followed_ = sha256_hex(before.left.data(), before.left.size());
    before_ = std::move(before);
}

void TemporalReprojection::go_on_from(const std::string& state) {
    if (!state.starts_with(followed_) || (state.size() - followed_.size()) % sizeof(PixelSums) != sizeof(uint32_t))
        throw Error(ErrorCode::Conflict, "its passes do not follow the frame before");
    state_before_ = state;
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
    parallel_for(indirect.size(), 4096, [&](size_t at) {
        const bool has_history = found.rejection[at] == Rejection::None;
        const float kept = has_history ? light.kept[at] : 0;
        const float frames = std::min(found.past.frames[at] * kept + 1, static_cast<float>(history_cap_));
        if (has_history) indirect[at] = glm::mix(found.past.indirect[at], indirect[at], 1 / frames);
        PixelSums& sums = sums_->pixels[at];
        sums.indirect += dvec3(indirect[at]), sums.frames += frames;
        sums.change += dvec3(kept * light.change[at]);
        sums.squared_change += dvec3(light.squared_change[at]);
        if (layers.has(Layer::HistoryLength)) image->of<Layer::HistoryLength>()[at] = frames;
        if (layers.has(Layer::Reused)) image->of<Layer::Reused>()[at] = 1 - 1 / frames;
        if (layers.has(Layer::Rejected))
            image->of<Layer::Rejected>()[at] = {found.rejection[at] == Rejection::Surface ? 1 : 0,
                                                has_history ? 1 - kept : 0,
                                                found.rejection[at] == Rejection::Outside ? 1 : 0};
    });
    ++sums_->passes;
    return image;
}

std::string TemporalReprojection::state() const {
    if (!sums_) return state_before_;
    std::string state = followed_;
    state.append(reinterpret_cast<const char*>(&sums_->passes), sizeof sums_->passes);
    return state.append(reinterpret_cast<const char*>(sums_->pixels.data()), sums_->pixels.size() * sizeof(PixelSums));
}

std::string TemporalReprojection::left_to_next() const {
    History left = sums_->found.now;
    const double scale = 1 / static_cast<double>(std::max(sums_->passes, 1u));
    for (size_t at = 0; at < sums_->pixels.size(); ++at) {
        const PixelSums& sums = sums_->pixels[at];
        left.indirect[at] = Rgb(scale * sums.indirect), left.frames[at] = static_cast<float>(scale * sums.frames);
        left.change[at] = Rgb(scale * sums.change), left.squared_change[at] = Rgb(scale * sums.squared_change);
    }
    return left.encode();
}

}  // namespace photond
