#include "server/service/picture_line.h"

#include <algorithm>

namespace photond {

void PictureLine::forget(Clock::time_point now) {
    std::erase_if(line_, [&](const Place& place) { return now - place.asked > kForgotten; });
}

std::shared_ptr<WantedPicture> PictureLine::want(const std::string& name, const std::function<Artefact()>& draw,
                                                 Clock::time_point now) {
    forget(now);
    const auto found =
        std::find_if(line_.begin(), line_.end(), [&](const Place& place) { return place.picture->name == name; });
    if (found != line_.end()) {
        found->asked = now;
        return found->picture;
    }
    if (line_.size() >= kLongest) return nullptr;
    auto picture = std::make_shared<WantedPicture>();
    picture->name = name;
    picture->draw = draw;
    line_.push_back({picture, now});
    return picture;
}

std::shared_ptr<WantedPicture> PictureLine::next(Clock::time_point now, bool in_time) {
    forget(now);
    if (in_time && now < not_before_) return nullptr;
    const auto found =
        std::find_if(line_.begin(), line_.end(), [](const Place& place) { return !place.picture->over; });
    return found == line_.end() ? nullptr : found->picture;
}

void PictureLine::note(Clock::time_point begun, double processor_seconds) {
    const std::chrono::duration<double> pause(processor_seconds / (kPictureShare * processors_));
    not_before_ = begun + std::chrono::duration_cast<Clock::duration>(pause);
}

void PictureLine::remove(const WantedPicture& picture) {
    std::erase_if(line_, [&](const Place& place) { return place.picture.get() == &picture; });
}

size_t PictureLine::waiting() const {
    return static_cast<size_t>(
        std::count_if(line_.begin(), line_.end(), [](const Place& place) { return !place.picture->over; }));
}

}  // namespace photond
