#pragma once
// What a frame of an animation leaves to the next one of its indirect light: for each pixel the light, and what surface
// it lies on.

#include <string>
#include <vector>

#include "renderer/core/rgb.h"
#include "renderer/scene/camera.h"

namespace photond {

struct History {
    Size2 size;
    Camera camera;
    std::vector<vec3> position;      // of what the pixel's middle shows [m]
    std::vector<vec3> normal;        // unit, of its triangle, facing the eye
    std::vector<uint32_t> instance;  // that it is of; kNoHit: of nothing that light can be taken over from
    std::vector<Rgb> indirect;       // mean of the frames [W m^-2 sr^-1]
    std::vector<float> frames;       // that it is the mean of
    /// About the pixel, a pass's light less the history's: its running mean, and that of its square. What says whether
    /// the light changes (light_change.h).
    std::vector<Rgb> change, squared_change;

    History() = default;
    explicit History(Size2 image_size);

    std::string encode() const;
    /// Throws ErrorCode::Conflict unless that is a history of an image of that size.
    static History decode(std::string_view text, Size2 image_size);
    static uint64_t bytes_for(Size2 image_size);
};

}  // namespace photond
