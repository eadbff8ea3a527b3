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
    // What tells a change of the light from noise (light_change.h): about the pixel, the last frame's own light, and
    // that less the light of the frame before it [W m^-2 sr^-1].
    std::vector<Rgb> near_light, near_step;
    std::vector<float> step_product;  // running mean of a step times the next, summed over the channels
    std::vector<float> age;           // frames for which the surface has been seen

    History() = default;
    explicit History(Size2 image_size);

    std::string encode() const;
    /// Throws ErrorCode::Conflict unless that is a history of an image of that size.
    static History decode(std::string_view text, Size2 image_size);
    static uint64_t bytes_for(Size2 image_size);
};

}  // namespace photond
