#pragma once
// The device's samples of lights, by the shaders themselves.

#include "renderer/backends/gpu/device_scene.h"
#include "renderer/transport/light_tables_shared.h"
#include "tests/support/gpu_twin.h"
#include "tests/support/light_samples.h"

namespace photond::test {

class DeviceLights {
public:
    explicit DeviceLights(const Scene& scene, EnvironmentDensity environment = EnvironmentDensity::Radiance)
        : scene_(gpu_device(), scene),
          specialization_(scene_.specialization(std::vector{
              gpu::specialize(LIGHT_SAMPLES_COMPENSATED_ID, environment == EnvironmentDensity::Compensated)})),
          samples_("tests/gpu/light_samples.comp", &scene_.set(), specialization_),
          pdfs_("tests/gpu/light_pdfs.comp", &scene_.set(), specialization_) {}

    std::vector<std::optional<LightSample>> sample(const std::vector<LightQuery>& queries) const {
        struct Answer {
            vec3 wi;
            float distance;
            vec3 target;
            Rgb radiance_over_pdf;
            float pdf_sa;
            uint32_t delta, source, lit;
            vec3 shadow_direction;
            float shadow_t_max;
        };
        static_assert(sizeof(Answer) == 72 && sizeof(LightQuery) == 36, "must match light_samples.comp");
        const auto answers = samples_.run<Answer>(queries.size(), {{"queries", queries}});
        std::vector<std::optional<LightSample>> samples;
        samples.reserve(answers.size());
        for (size_t i = 0; i < answers.size(); ++i) {
            const Answer& a = answers[i];
            if (a.lit == 0) {
                samples.emplace_back();
                continue;
            }
            const LightSample sample{a.wi, a.distance, a.target, a.radiance_over_pdf, a.pdf_sa, a.delta != 0, a.source};
            const Ray shadow = sample.shadow_ray(queries[i].p);
            EXPECT_EQ(shadow.direction, a.shadow_direction);
            EXPECT_EQ(shadow.t_max, a.shadow_t_max);
            samples.push_back(sample);
        }
        return samples;
    }
    std::vector<LightPdfs> pdfs(const std::vector<LightPdfQuery>& queries) const {
        static_assert(sizeof(LightPdfQuery) == 48 && sizeof(LightPdfs) == 20, "must match light_pdfs.comp");
        return pdfs_.run<LightPdfs>(queries.size(), {{"queries", queries}});
    }

private:
    gpu::DeviceScene scene_;
    std::vector<gpu::Specialization> specialization_;
    Twin samples_, pdfs_;
};

class DeviceEmission {
public:
    explicit DeviceEmission(const Scene& scene)
        : scene_(gpu_device(), scene),
          samples_("tests/gpu/emission_samples.comp", &scene_.set(), scene_.specialization()) {
        const Twin lights("tests/gpu/emission_lights.comp", &scene_.set(), scene_.specialization());
        const uint32_t most = static_cast<uint32_t>(scene.triangle_lights.size() + scene.punctual_lights.size()) + 1;
        lights_ = lights.run<Light>(most, {});
        if (lights_.at(0).lights < most) lights_.resize(lights_.at(0).lights);
    }

    std::vector<std::optional<EmissionSample>> sample(const std::vector<EmissionQuery>& queries) const {
        struct Answer {
            vec3 origin, direction;
            Rgb power_w;
            float range_m;
            uint32_t light, source, lit;
        };
        static_assert(sizeof(Answer) == 52 && sizeof(EmissionQuery) == 28, "must match emission_samples.comp");
        std::vector<std::optional<EmissionSample>> samples;
        samples.reserve(queries.size());
        for (const Answer& a : samples_.run<Answer>(queries.size(), {{"queries", queries}}))
            samples.push_back(a.lit == 0
                                  ? std::nullopt
                                  : std::optional(EmissionSample{
                                        {a.origin, a.direction, kInfinity}, a.power_w, a.light, a.source, a.range_m}));
        return samples;
    }
    uint32_t lights() const { return static_cast<uint32_t>(lights_.size()); }
    float probability(uint32_t light) const { return lights_.at(light).probability; }
    bool guided_by_position(uint32_t light) const { return lights_.at(light).guided_by_position != 0; }

private:
    struct Light {
        float probability;
        uint32_t guided_by_position;
        uint32_t lights;
    };
    gpu::DeviceScene scene_;
    Twin samples_;
    std::vector<Light> lights_;
};

}  // namespace photond::test
