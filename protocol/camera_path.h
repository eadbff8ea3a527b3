#pragma once
// Where the camera of a sequence's frames is: on a circle, or along positions at times.

#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "protocol/job.h"

namespace photond {

struct CameraKey {
    double time = 0;  // [s]
    LookAt view;
};

/// One of both.
struct CameraPath {
    std::optional<double> turns;  // of the eye about the vertical axis through the target, over the whole sequence
    std::vector<CameraKey> keys;  // by time; one at least
};

/// Faults are added; nothing where there are any.
std::optional<CameraPath> read_camera_path(const nlohmann::json& source, const std::string& pointer,
                                           BodyFaults& faults);
nlohmann::json to_json(const CameraPath& path);

/// The view of a frame. `start`: the view that turns begin at; `share`: of the sequence that is over, 0 to 1. Along
/// keys eye, target and the angle's logarithm follow Catmull and Rom's cubics through them, without speed at both ends;
/// before the first and after the last they are theirs. Turns go counter-clockwise seen from above. What comes of good
/// keys need not be a good view (fault_of_view()): an eye may pass through its target.
LookAt view_along(const CameraPath& path, const LookAt& start, double time_s, double share);

}  // namespace photond
