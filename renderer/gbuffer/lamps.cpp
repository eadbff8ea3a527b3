#include "renderer/gbuffer/lamps.h"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "renderer/scene/scene.h"
#include "renderer/transport/emitter.h"
#include "renderer/transport/light_sampling.h"

namespace photond {

namespace {

struct Moments {
    double light = 0;
    dvec3 sum{0};
    glm::dmat3 products{0};
};

void add_triangle(const TriangleCorners& corners, double light, const dvec3& origin, Moments& moments) {
    const dvec3 a = dvec3(corners.p[0]) - origin, b = dvec3(corners.p[1]) - origin, c = dvec3(corners.p[2]) - origin;
    const dvec3 sum = a + b + c;
    moments.light += light;
    moments.sum += light / 3 * sum;
    // The mean over a triangle of x x^T.
    moments.products +=
        light / 12 *
        (glm::outerProduct(a, a) + glm::outerProduct(b, b) + glm::outerProduct(c, c) + glm::outerProduct(sum, sum));
}

gpu::LampShape shape_of(const Moments& moments, const dvec3& origin) {
    const dvec3 mean = moments.sum / moments.light;
    const glm::dmat3 covariance = moments.products / moments.light - glm::outerProduct(mean, mean);
    return {.centre = vec3(origin + mean),
            .variance_m2 = vec3(covariance[0][0], covariance[1][1], covariance[2][2]),
            .covariance_m2 = vec3(covariance[1][2], covariance[2][0], covariance[0][1])};
}

/// Of each of the scene's triangle lights the first one that it hangs together with.
class Together {
public:
    explicit Together(const Scene& scene) : first_(scene.triangle_lights.size()) {
        std::iota(first_.begin(), first_.end(), 0u);
        struct Corner {
            uint32_t instance;
            vec3 position;
            uint32_t light;
        };
        std::vector<Corner> corners;
        for (uint32_t i = 0; i < first_.size(); ++i) {
            const TriangleLight& light = scene.triangle_lights[i];
            for (const vec3& p : world_triangle(scene, light.instance, light.triangle).p)
                corners.push_back({light.instance, p, i});
        }
        const auto place = [](const Corner& c) {
            return std::tuple(c.instance, c.position.x, c.position.y, c.position.z);
        };
        std::sort(corners.begin(), corners.end(),
                  [&](const Corner& a, const Corner& b) { return place(a) < place(b); });
        for (size_t i = 1; i < corners.size(); ++i)
            if (place(corners[i]) == place(corners[i - 1])) join(corners[i].light, corners[i - 1].light);
    }
    uint32_t first_of(uint32_t light) {
        while (first_[light] != light) light = first_[light] = first_[first_[light]];
        return light;
    }

private:
    void join(uint32_t a, uint32_t b) {
        a = first_of(a), b = first_of(b);
        first_[std::max(a, b)] = std::min(a, b);
    }
    std::vector<uint32_t> first_;
};

/// Which triangle light that triangle is.
uint32_t triangle_light_of(const Scene& scene, const Emitter& emitter) {
    const auto place = [](const auto& light) { return std::pair(light.instance, light.triangle); };
    const auto found = std::lower_bound(scene.triangle_lights.begin(), scene.triangle_lights.end(), emitter,
                                        [&](const auto& a, const auto& b) { return place(a) < place(b); });
    return static_cast<uint32_t>(found - scene.triangle_lights.begin());
}

}  // namespace

Lamps find_lamps(const Scene& scene) {
    const dvec3 origin(scene.bounds.centre());  // a place near all of them, for the digits
    Together together(scene);
    std::vector<uint32_t> lamp_of(scene.triangle_lights.size());
    std::vector<Moments> moments;
    for (uint32_t i = 0; i < lamp_of.size(); ++i) {
        const uint32_t first = together.first_of(i);
        if (first == i) {
            lamp_of[i] = static_cast<uint32_t>(moments.size());
            moments.emplace_back();
        } else {
            lamp_of[i] = lamp_of[first];
        }
        const TriangleLight& light = scene.triangle_lights[i];
        add_triangle(world_triangle(scene, light.instance, light.triangle),
                     double{light.area_m2} * double{mean(light.radiance)}, origin, moments[lamp_of[i]]);
    }
    Lamps lamps;
    for (const Moments& of_lamp : moments) lamps.shapes.push_back(shape_of(of_lamp, origin));
    const auto first_punctual = static_cast<uint32_t>(moments.size());
    for (const PunctualLight& light : scene.punctual_lights) lamps.shapes.push_back({.centre = light.position});
    lamps.words.push_back(first_punctual);
    const LightSampler sampler(scene);
    for (const Emitter& emitter : sampler.emitters()) {
        const bool area = emitter.shape == Emitter::Shape::Triangle || emitter.shape == Emitter::Shape::Parallelogram;
        lamps.words.push_back(area ? lamp_of[triangle_light_of(scene, emitter)] : first_punctual + emitter.instance);
    }
    return lamps;
}

}  // namespace photond
