#pragma once
// Those who sample lights behind one face, so that the same checks run on the host's samples and on the device's
// (device_light_samples.h).

#include <optional>
#include <vector>

#include "renderer/core/rng.h"
#include "renderer/transport/emission_sampling.h"
#include "renderer/transport/environment_sampling.h"
#include "renderer/transport/light_sampling.h"

namespace photond::test {

struct LightQuery {
    vec3 p, n;
    float u_select;
    vec2 u;
};

struct LightPdfQuery {
    vec3 p, n;
    vec3 wi;
    float distance = kInfinity;
    uint32_t instance = ~0u;  // ~0: no triangle is met
    uint32_t triangle = 0;
};
struct LightPdfs {
    float triangle;
    float environment;
    Rgb environment_radiance;
};

struct EmissionQuery {
    float u_light;
    vec2 u_position, u_direction;
    uint32_t light = ~0u;  // ~0: chosen by u_light, else this one with that probability
    float probability = 0;
};

/// Queries for one point, by the stream's next numbers.
inline std::vector<LightQuery> light_queries(const vec3& p, const vec3& n, size_t count, RandomStream& random) {
    std::vector<LightQuery> queries(count);
    for (LightQuery& q : queries) {
        const float u_select = random.next();
        q = {p, n, u_select, random.next_2d()};
    }
    return queries;
}
inline std::vector<EmissionQuery> emission_queries(size_t count, RandomStream& random) {
    std::vector<EmissionQuery> queries(count);
    for (EmissionQuery& q : queries) {
        q.u_light = random.next();
        q.u_position = random.next_2d();
        q.u_direction = random.next_2d();
    }
    return queries;
}

/// LightSampler's answers; nullopt where sample() is false.
class HostLights {
public:
    explicit HostLights(const Scene& scene, EnvironmentDensity environment = EnvironmentDensity::Radiance)
        : sampler_(scene, environment) {}
    std::vector<std::optional<LightSample>> sample(const std::vector<LightQuery>& queries) const {
        std::vector<std::optional<LightSample>> samples;
        samples.reserve(queries.size());
        for (const LightQuery& q : queries) {
            LightSample sample;
            samples.push_back(sampler_.sample(q.p, q.n, q.u_select, q.u, sample) ? std::optional(sample)
                                                                                 : std::nullopt);
        }
        return samples;
    }
    std::vector<LightPdfs> pdfs(const std::vector<LightPdfQuery>& queries) const {
        std::vector<LightPdfs> pdfs;
        pdfs.reserve(queries.size());
        for (const LightPdfQuery& q : queries)
            pdfs.push_back(
                {q.instance == ~0u ? 0.0f : sampler_.pdf_triangle(q.p, q.n, q.instance, q.triangle, q.wi, q.distance),
                 sampler_.pdf_environment(q.p, q.n, q.wi), sampler_.environment_radiance(q.wi)});
        return pdfs;
    }

private:
    LightSampler sampler_;
};

/// EmissionSampler's answers; nullopt where sample() or sample_light() is false.
class HostEmission {
public:
    explicit HostEmission(const Scene& scene) : sampler_(scene) {}
    std::vector<std::optional<EmissionSample>> sample(const std::vector<EmissionQuery>& queries) const {
        std::vector<std::optional<EmissionSample>> samples;
        samples.reserve(queries.size());
        for (const EmissionQuery& q : queries) {
            EmissionSample sample;
            const bool lit = q.light == ~0u
                                 ? sampler_.sample(q.u_light, q.u_position, q.u_direction, sample)
                                 : sampler_.sample_light(q.light, q.probability, q.u_position, q.u_direction, sample);
            samples.push_back(lit ? std::optional(sample) : std::nullopt);
        }
        return samples;
    }
    uint32_t lights() const { return sampler_.lights(); }
    float probability(uint32_t light) const { return sampler_.probability(light); }
    bool guided_by_position(uint32_t light) const { return sampler_.guided_by_position(light); }

private:
    EmissionSampler sampler_;
};

}  // namespace photond::test
