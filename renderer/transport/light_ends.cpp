#include "renderer/transport/light_ends.h"

#include "renderer/transport/emitter.h"
#include "renderer/transport/environment_sampling.h"
#include "renderer/transport/punctual.h"

namespace photond {

LightEnds::LightEnds(const Scene& scene, const LightSampler& lights, const EmissionSampler& emission)
    : scene_(scene),
      lights_(lights),
      emission_(emission),
      triangles_(static_cast<uint32_t>(scene.triangle_lights.size())),
      emission_per_m2_(lights.emitters().size()) {
    // Two triangles that are one emitter have one radiance, and so one density.
    for (uint32_t i = 0; i < triangles_; ++i) {
        const TriangleLight& light = scene.triangle_lights[i];
        const uint32_t emitter = lights.emitter_of(light.instance, light.triangle);
        if (emitter != kNoEmitter) emission_per_m2_[emitter] += emission.probability(i);
    }
    for (size_t e = 0; e < emission_per_m2_.size(); ++e) {
        const Emitter& emitter = lights.emitters()[e];
        if (emitter.area_m2 > 0) emission_per_m2_[e] /= emitter.area_m2 * (emitter.two_sided ? 2.0f : 1.0f);
    }
}

float LightEnds::emitted_by_cosine(uint32_t emitter, float cosine) const {
    return emission_per_m2_[emitter] * cosine * kInvPi;
}

float LightEnds::emission_punctual(uint32_t punctual, const vec3& direction) const {
    const PunctualLight& light = scene_.punctual_lights[punctual];
    const float probability = emission_.probability(triangles_ + punctual);
    switch (light.kind) {
        case PunctualLight::Kind::Point: return probability / (4 * kPi);
        case PunctualLight::Kind::Spot: {
            const SpotCone cone(light);
            return probability * cone.falloff(glm::dot(light.direction, direction)) /
                   static_cast<float>(cone.solid_angle());
        }
        case PunctualLight::Kind::Directional: return probability / emission_.disc_m2();
    }
    return 0;
}

float LightEnds::emission_environment(const vec3& wi) const {
    return emission_.probability(emission_.lights() - 1) * emission_.environment()->pdf(wi) / emission_.disc_m2();
}

LightEnd LightEnds::on_triangle(const vec3& p, const vec3& n, uint32_t instance, uint32_t triangle, const vec3& wi,
                                float distance) const {
    LightEnd end;
    const uint32_t emitter = lights_.emitter_of(instance, triangle);
    if (emitter == kNoEmitter) return end;
    end.cosine = std::fabs(glm::dot(lights_.emitters()[emitter].normal, wi));
    end.direct = lights_.pdf_triangle(p, n, instance, triangle, wi, distance) * end.cosine / sqr(distance);
    end.emission = emitted_by_cosine(emitter, end.cosine);
    return end;
}

LightEnd LightEnds::of_environment(const vec3& p, const vec3& n, const vec3& wi) const {
    LightEnd end;
    end.infinite = true;
    if (emission_.environment() == nullptr) return end;
    end.direct = lights_.pdf_environment(p, n, wi);
    end.emission = emission_environment(wi);
    return end;
}

LightEnd LightEnds::of_sample(const LightSample& sample, float& pdf_direct_sa) const {
    LightEnd end;
    end.delta = sample.delta;
    end.infinite = !(sample.distance < kInfinity);
    end.direct = pdf_direct_sa = sample.pdf_sa;
    if (sample.delta) {
        const uint32_t punctual = sample.source - light_source_of_punctual(scene_, 0);
        end.emission = emission_punctual(punctual, -sample.wi);
        if (!end.infinite) pdf_direct_sa *= sqr(sample.distance);
    } else if (end.infinite) {
        end.emission = emission_environment(sample.wi);
    } else {
        end.cosine = std::fabs(glm::dot(lights_.emitters()[sample.emitter].normal, sample.wi));
        end.direct *= end.cosine / sqr(sample.distance);
        end.emission = emitted_by_cosine(sample.emitter, end.cosine);
    }
    return end;
}

LightEnd LightEnds::of_emission(const EmissionSample& sample) const {
    LightEnd end;
    if (sample.light < triangles_) {
        const TriangleLight& light = scene_.triangle_lights[sample.light];
        const uint32_t emitter = lights_.emitter_of(light.instance, light.triangle);
        end.cosine = std::fabs(glm::dot(lights_.emitters()[emitter].normal, sample.ray.direction));
        end.emission = emitted_by_cosine(emitter, end.cosine);
    } else if (sample.light < triangles_ + scene_.punctual_lights.size()) {
        const uint32_t punctual = sample.light - triangles_;
        end.delta = true;
        end.infinite = scene_.punctual_lights[punctual].kind == PunctualLight::Kind::Directional;
        end.emission = emission_punctual(punctual, sample.ray.direction);
    } else {
        end.infinite = true;
        end.emission = emission_environment(-sample.ray.direction);
    }
    return end;
}

float LightEnds::direct_at_first_hit(const EmissionSample& sample, const vec3& p, const vec3& n, float distance) const {
    const vec3 wi = -sample.ray.direction;
    if (sample.light < triangles_) {
        const TriangleLight& light = scene_.triangle_lights[sample.light];
        return on_triangle(p, n, light.instance, light.triangle, wi, distance).direct;
    }
    if (sample.light < triangles_ + scene_.punctual_lights.size())
        return lights_.probability_punctual(p, n, sample.light - triangles_);
    return lights_.pdf_environment(p, n, wi);
}

}  // namespace photond
