#pragma once
// Materials and directions at random, for what must hold of all.

#include "renderer/core/rng.h"
#include "tests/support/bsdf_quadrature.h"

namespace photond::test {

/// Its cosine is uniform from `least_cos` to 1.
inline vec3 random_direction(RandomStream& random, float least_cos) {
    const float z = least_cos + (1 - least_cos) * random.next();
    return vec3(direction_at(static_cast<double>(z), static_cast<double>(random.next())));
}

/// Any mixture of lobes; roughness from delta to 1.
inline Bsdf::Parameters random_material(RandomStream& random) {
    const auto sometimes = [&](float value) { return random.next() < 0.5f ? value : 0.0f; };
    const auto colour = [&] { return Rgb(random.next(), random.next(), random.next()); };
    Bsdf::Parameters p;
    p.geometric_normal = random_direction(random, 0.8f);
    p.base_color = colour();
    p.metallic = sometimes(random.next());
    p.roughness = sometimes(random.next());
    p.ior = 1 + random.next();
    p.specular = random.next();
    p.specular_color = 1.5f * colour();
    p.transmission = sometimes(random.next());
    p.solid = random.next() < 0.5f;
    p.eta = 0.6f + random.next();
    return p;
}

}  // namespace photond::test
