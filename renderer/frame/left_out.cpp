#include "renderer/frame/left_out.h"

#include <algorithm>

namespace photond {

PathsLeftOut::PathsLeftOut(uint32_t most_bounces, const Needs& needs)
    : most_bounces_(std::min(most_bounces, kAllBounces)) {
    const bool scatters = needs.diffuse || needs.glossy || needs.delta || needs.transmission;
    has_[static_cast<size_t>(PathKind::FurtherBounces)] = most_bounces_ < kAllBounces && scatters;
}

PathsLeftOut& PathsLeftOut::add(PathKind kind) {
    if (kPathKinds[static_cast<size_t>(kind)].least_bounces <= most_bounces_) has_[static_cast<size_t>(kind)] = true;
    return *this;
}

std::vector<PathKind> PathsLeftOut::kinds() const {
    std::vector<PathKind> found;
    for (const PathKindInfo& info : kPathKinds)
        if (has(info.kind)) found.push_back(info.kind);
    return found;
}

std::string PathsLeftOut::text(PathKind kind) const {
    if (kind != PathKind::FurtherBounces) return std::string(kPathKinds[static_cast<size_t>(kind)].text);
    if (most_bounces_ == 0) return "all light that bounces";
    return "light of more than " + std::to_string(most_bounces_) + (most_bounces_ == 1 ? " bounce" : " bounces");
}

std::string PathsLeftOut::text() const {
    std::string all;
    for (const PathKind kind : kinds()) all += (all.empty() ? "" : "; ") + text(kind);
    return all;
}

PathsLeftOut PathsLeftOut::without(const PathsLeftOut& other) const {
    PathsLeftOut difference;
    difference.most_bounces_ = most_bounces_;
    for (const PathKindInfo& info : kPathKinds)
        difference.has_[static_cast<size_t>(info.kind)] =
            has(info.kind) && (info.kind == PathKind::FurtherBounces
                                   ? most_bounces_ < other.most_bounces_
                                   : !other.holds(info.kind) && info.least_bounces <= other.most_bounces_);
    return difference;
}

PathsLeftOut left_out_by_eye_paths(uint32_t most_bounces, const Needs& needs) {
    PathsLeftOut left_out = left_out_by_photons(most_bounces, kNarrowAlpha, needs);
    if (has_delta_light_by_delta(needs))
        left_out.add(PathKind::DeltaLightCaustics).add(PathKind::DeltaLightAfterCaustics);
    return left_out;
}

PathsLeftOut left_out_by_two_paths(uint32_t most_bounces, const Needs& needs) {
    PathsLeftOut left_out(most_bounces, needs);
    if (has_delta_light_by_delta(needs)) left_out.add(PathKind::DeltaLightCausticsInMirrors);
    return left_out;
}

PathsLeftOut left_out_by_photons(uint32_t most_bounces, float glossy_threshold, const Needs& needs) {
    PathsLeftOut left_out(most_bounces, needs);
    if (has_delta_light_by_delta(needs) && needs.least_glossy_alpha < glossy_threshold)
        left_out.add(PathKind::DeltaLightInGloss);
    return left_out;
}

PathsLeftOut left_out_by_connections(uint32_t most_bounces, float glossy_threshold, float connect_threshold,
                                     const Needs& needs) {
    PathsLeftOut left_out = left_out_by_photons(most_bounces, glossy_threshold, needs);
    if (has_delta_light_by_delta(needs)) left_out.add(PathKind::DeltaLightCaustics);
    if (needs.delta || needs.transmission || needs.least_glossy_alpha < connect_threshold)
        left_out.add(PathKind::Caustics);
    return left_out;
}

}  // namespace photond
