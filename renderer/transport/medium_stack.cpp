#include "renderer/transport/medium_stack.h"

namespace photond {

Absorption::Absorption(const Scene& scene) {
    per_m_.reserve(scene.materials.size());
    for (const Material& m : scene.materials) {
        // A channel of 0 is taken as 1e-30, so that the exponent stays finite.
        const bool absorbs = m.solid && m.attenuation_distance < kInfinity;
        per_m_.push_back(absorbs ? -glm::log(glm::max(m.attenuation_color, Rgb(1e-30f))) / m.attenuation_distance
                                 : Rgb(0));
    }
}

Rgb Absorption::transmittance(const Rgb& absorption_per_m, float distance) {
    Rgb left;
    for (int c = 0; c < 3; ++c) left[c] = absorption_per_m[c] > 0 ? std::exp(-absorption_per_m[c] * distance) : 1.0f;
    return left;
}

}  // namespace photond
