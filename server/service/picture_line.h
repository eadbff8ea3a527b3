#pragma once
// Pictures that are drawn while a job renders: which is next, and when it may begin.

#include <chrono>
#include <exception>
#include <functional>
#include <list>
#include <memory>
#include <string>

#include "server/service/service_types.h"

namespace photond {

/// A picture that somebody has asked for.
struct WantedPicture {
    std::string name;
    std::function<Artefact()> draw;  // throws where it cannot be drawn
    bool over = false;               // then it is one of the two:
    Artefact drawn;
    std::exception_ptr failure;
};

/// First come, first served, at most kLongest of them. Whoever waits asks again now and then: what nobody has asked for
/// in a while is not drawn, and one that is drawn waits as long to be fetched. While a job renders, pictures take
/// kPictureShare of the processors at most: after one that has taken t seconds of processor time the next waits
/// t / (kPictureShare * processors) from the first one's beginning. Not thread-safe.
class PictureLine {
public:
    using Clock = std::chrono::steady_clock;
    static constexpr size_t kLongest = 16;
    static constexpr double kPictureShare = 0.02;
    static constexpr std::chrono::seconds kForgotten{20};

    explicit PictureLine(unsigned processors) : processors_(processors) {}

    /// The picture of that name, which joins the line where it is not in it; null where that is full.
    std::shared_ptr<WantedPicture> want(const std::string& name, const std::function<Artefact()>& draw,
                                        Clock::time_point now);
    /// The next one that is not over; null where none may begin. `in_time`: at the pace that a job which renders puts
    /// up with; else at once.
    std::shared_ptr<WantedPicture> next(Clock::time_point now, bool in_time);
    /// One was drawn, which began then and took so much processor time.
    void note(Clock::time_point begun, double processor_seconds);
    void remove(const WantedPicture& picture);
    /// Those that are not over.
    size_t waiting() const;

private:
    void forget(Clock::time_point now);

    struct Place {
        std::shared_ptr<WantedPicture> picture;
        Clock::time_point asked;  // the last time
    };
    const unsigned processors_;
    std::list<Place> line_;
    Clock::time_point not_before_ = Clock::time_point::min();
};

}  // namespace photond
