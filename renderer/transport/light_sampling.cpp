#include "renderer/transport/light_sampling.h"

#include <cassert>

#include "renderer/transport/emission.h"
#include "renderer/transport/emitter.h"
#include "renderer/transport/environment_sampling.h"
#include "renderer/transport/light_sampling_shared.h"
#include "renderer/transport/light_tree.h"
#include "renderer/transport/light_triangle.h"
#include "renderer/transport/punctual.h"
#include "renderer/transport/ray_start.h"
#include "renderer/transport/sampling.h"
#include "renderer/transport/solid_angle_sampling.h"

namespace photond {

namespace {

Emitter make_triangle(const Scene& scene, const TriangleLight& light) {
    const LightTriangle triangle = make_light_triangle(scene, light);
    Emitter e{};
    e.corner = triangle.corner;
    e.edge1 = triangle.edge1;
    e.edge2 = triangle.edge2;
    e.normal = triangle.normal;
    e.area_m2 = light.area_m2;
    e.radiance = light.radiance;
    e.instance = light.instance;
    e.triangle = light.triangle;
    e.shape = Emitter::Shape::Triangle;
    e.two_sided = light.two_sided;
    e.varies = triangle.varies;
    return e;
}

/// The parallelogram that two constant triangles of one instance make, if they do. One shape instead of two draws
/// points that are better spread, without a choice.
bool merge_to_parallelogram(const Emitter& a, const Emitter& b, Emitter& merged) {
    if (a.varies || b.varies || a.instance != b.instance || glm::dot(a.normal, b.normal) < 0.999999f) return false;
    const vec3 pa[3] = {a.corner, a.corner + a.edge1, a.corner + a.edge2};
    const vec3 pb[3] = {b.corner, b.corner + b.edge1, b.corner + b.edge2};
    const vec3 largest = glm::max(glm::max(glm::abs(pa[0]), glm::abs(pa[1])), glm::abs(pa[2]));
    // Corners that a transform has rounded are some units in the last place apart.
    const float tolerance = 4e-6f * std::max({largest.x, largest.y, largest.z});
    const float shortest = std::sqrt(a.area_m2);
    if (tolerance > 1e-3f * shortest) return false;
    const auto same = [&](const vec3& p, const vec3& q) { return glm::length(p - q) <= tolerance; };
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            const vec3 &apex = pa[i], &s = pa[(i + 1) % 3], &t = pa[(i + 2) % 3];
            const bool shares_edge = same(s, pb[(j + 2) % 3]) && same(t, pb[(j + 1) % 3]);
            if (!shares_edge || !same(apex + (s - apex) + (t - apex), pb[j])) continue;
            merged = a;
            merged.corner = apex;
            merged.edge1 = s - apex;
            merged.edge2 = t - apex;
            merged.area_m2 = a.area_m2 + b.area_m2;
            merged.shape = Emitter::Shape::Parallelogram;
            return true;
        }
    return false;
}

LightBounds bounds_of(const Emitter& e) {
    LightBounds b;
    b.bounds.extend(e.corner), b.bounds.extend(e.corner + e.edge1), b.bounds.extend(e.corner + e.edge2);
    if (e.shape == Emitter::Shape::Parallelogram) b.bounds.extend(e.corner + e.edge1 + e.edge2);
    b.axis = e.normal;
    b.emission_angle = kPi / 2;
    b.intensity = mean(e.radiance) * e.area_m2;
    b.two_sided = e.two_sided;
    return b;
}

LightBounds bounds_of(const PunctualLight& light) {
    LightBounds b;
    b.bounds.extend(light.position);
    b.axis = light.direction;
    b.intensity = mean(light.intensity);
    b.cone_angle = kPi;
    b.emission_angle = kPi / 2;
    if (light.kind == PunctualLight::Kind::Spot) {
        b.cone_angle = std::acos(std::clamp(light.cos_inner, -1.0f, 1.0f));
        constexpr float kSlack = 1e-3f;  // so that rounding cuts nothing off at the rim
        b.emission_angle = std::max(0.0f, std::acos(std::clamp(light.cos_outer, -1.0f, 1.0f)) - b.cone_angle) + kSlack;
    }
    return b;
}

/// Intensity of a point or spot towards `wo` (unit, from the light) over the squared distance: perpendicular irradiance
/// [W m^-2]. Cone and window as KHR_lights_punctual recommends.
Rgb punctual_irradiance(const PunctualLight& light, const vec3& wo, float distance) {
    float factor = 1 / sqr(distance);
    factor *= range_window(distance, light.range_m);
    if (light.kind == PunctualLight::Kind::Spot) factor *= SpotCone(light).falloff(glm::dot(light.direction, wo));
    return light.intensity * factor;
}

/// Solid angles of the one or two triangles of an emitter seen from p; {0, 0} where it is drawn by area.
struct SeenFrom {
    vec3 a, b, c, d;  // unit directions to corner, corner + edge1, corner + edge2, and the parallelogram's fourth
    float omega1 = 0;
    float omega2 = 0;
    float omega() const { return omega1 + omega2; }
};

SeenFrom see_near(const Emitter& e, const vec3& p) {
    SeenFrom seen;
    const bool two = e.shape == Emitter::Shape::Parallelogram;
    const vec3 corner = e.corner - p;
    seen.a = glm::normalize(corner);
    seen.b = glm::normalize(corner + e.edge1);
    seen.c = glm::normalize(corner + e.edge2);
    seen.omega1 = triangle_solid_angle(seen.a, seen.b, seen.c);
    if (two) {
        seen.d = glm::normalize(corner + e.edge1 + e.edge2);
        seen.omega2 = triangle_solid_angle(seen.d, seen.c, seen.b);
    }
    const float omega = seen.omega();
    constexpr float kLeast = 1e-3f;  // of each half, for sample_spherical_triangle()
    const bool fits = omega >= LIGHT_SPHERICAL_FROM && seen.omega1 > kLeast && seen.omega1 < LIGHT_SPHERICAL_TO &&
                      (!two || (seen.omega2 > kLeast && seen.omega2 < LIGHT_SPHERICAL_TO));
    if (!fits) seen.omega1 = seen.omega2 = 0;
    return seen;
}

inline SeenFrom see(const Emitter& e, const vec3& p) {
    const float centre = e.shape == Emitter::Shape::Parallelogram ? 0.5f : 1.0f / 3;
    const vec3 to_centre = e.corner - p + centre * (e.edge1 + e.edge2);
    // The solid angle is at most about area / distance^2 for a small emitter; twice the threshold covers the rest.
    if (2 * e.area_m2 < LIGHT_SPHERICAL_FROM * glm::dot(to_centre, to_centre)) return {};
    return see_near(e, p);
}

/// Weights of corner + s edge1 + t edge2 where the line from p along w meets the emitter's plane.
vec2 meet_plane(const Emitter& e, const vec3& p, const vec3& w) {
    const vec3 across = glm::cross(w, e.edge2);
    const float inverse = 1 / glm::dot(across, e.edge1);
    const vec3 s = p - e.corner;
    return glm::clamp(vec2(glm::dot(s, across), glm::dot(w, glm::cross(s, e.edge1))) * inverse, vec2(0), vec2(1));
}

}  // namespace

struct LightSampler::Lights {
    explicit Lights(const Scene& lit_scene) : scene(lit_scene) {}

    const Scene& scene;
    std::vector<Emitter> emitters;
    LightTree tree;
    std::vector<uint32_t> directional;          // indices of punctual lights
    std::vector<uint32_t> emitter_of_punctual;  // kNoEmitter for the directional ones
    std::unique_ptr<EnvironmentSampler> environment;
    bool tree_only = false;  // no light at infinity

    std::vector<uint32_t> first_of_instance;  // see emitter_of_triangle() in the header
    std::vector<uint32_t> emitter_of_triangle;

    uint32_t emitter_of(uint32_t instance, uint32_t triangle) const {
        if (first_of_instance.empty() || first_of_instance[instance] == kNoEmitter) return kNoEmitter;
        return emitter_of_triangle[first_of_instance[instance] + triangle];
    }

    /// What a group of lights could bring to p, if nothing were in between: irradiance, mean over channels.
    float directional_estimate(uint32_t light, const vec3& n) const {
        const PunctualLight& sun = scene.punctual_lights[light];
        const float cosine = n == vec3(0) ? 1.0f : std::max(0.0f, -glm::dot(n, sun.direction));
        return mean(sun.intensity) * cosine;
    }
    float environment_estimate() const { return environment ? kPi * environment->mean_radiance() : 0.0f; }
    /// With which sample() chooses an emitter.
    float emitter_probability(const vec3& p, const vec3& n, uint32_t emitter) const {
        const float probability = tree.probability(p, n, emitter);
        if (tree_only || !(probability > 0)) return probability;
        const Groups g = groups(p, n);
        return probability * g.probability(g.tree);
    }

    /// Sum of the groups' estimates at p and the number of groups that can reach it.
    struct Groups {
        float tree = 0;
        float sum = 0;
        float reaching = 0;

        // Half by estimate, half evenly: the estimate knows nothing of what lies in between, and a lamp in a room must
        // not starve because the sun, which never enters, is a thousand times brighter.
        float probability(float estimate) const {
            return estimate > 0 ? 0.5f * estimate / sum + 0.5f / reaching : 0.0f;
        }
        void add(float estimate) { sum += estimate, reaching += estimate > 0 ? 1.0f : 0.0f; }
    };
    Groups groups(const vec3& p, const vec3& n) const {
        Groups g;
        g.tree = tree.irradiance_estimate(p, n);
        g.add(g.tree);
        for (const uint32_t light : directional) g.add(directional_estimate(light, n));
        g.add(environment_estimate());
        return g;
    }

    bool sample_emitter(const Emitter& e, const vec3& p, const vec2& u, float probability, LightSample& out) const;
    bool sample_from_tree(const vec3& p, const vec3& n, float u_select, const vec2& u, float group_probability,
                          LightSample& out) const;
    bool sample_groups(const vec3& p, const vec3& n, float u_select, const vec2& u, LightSample& out) const;
};

/// Fills everything for a light that was chosen with that probability.
bool LightSampler::Lights::sample_emitter(const Emitter& e, const vec3& p, const vec2& u, float probability,
                                          LightSample& out) const {
    if (e.shape == Emitter::Shape::Point || e.shape == Emitter::Shape::Spot) {
        const vec3 to_light = e.corner - p;
        const float distance = glm::length(to_light);
        if (!(distance > 0)) return false;
        out.wi = to_light / distance;
        out.distance = distance;
        out.target = e.corner;
        out.radiance_over_pdf = punctual_irradiance(scene.punctual_lights[e.instance], -out.wi, distance) / probability;
        out.pdf_sa = probability;
        out.delta = true;
        out.source = light_source_of_punctual(scene, e.instance);
        return max_component(out.radiance_over_pdf) > 0;
    }
    out.source = light_source_of_instance(e.instance);
    const float height = glm::dot(e.normal, p - e.corner);  // of p above the emitter's plane
    if (e.two_sided ? height == 0 : !(height > 0)) return false;

    const SeenFrom seen = see(e, p);
    const bool spherical = seen.omega1 > 0;
    vec2 st;
    if (spherical) {
        const float share = seen.omega1 / seen.omega();
        const bool first = u.x < share;
        const vec2 v = {std::min(first ? u.x / share : (u.x - share) / (1 - share), 0x1.fffffep-1f), u.y};
        const vec3 w = first ? sample_spherical_triangle(seen.a, seen.b, seen.c, v)
                             : sample_spherical_triangle(seen.d, seen.c, seen.b, v);
        st = meet_plane(e, p, w);
    } else {
        st = e.shape == Emitter::Shape::Triangle ? sample_triangle(u) : u;
    }
    const vec3 point = e.corner + st.x * e.edge1 + st.y * e.edge2;
    const vec3 to_light = point - p;
    const float distance_sq = glm::dot(to_light, to_light);
    if (!(distance_sq > 0)) return false;
    out.distance = std::sqrt(distance_sq);
    const float inverse = 1 / out.distance;  // divisions are what this function's time goes into
    out.wi = inverse * to_light;
    // Found from p, whose own coordinates round the ray too.
    const float clearance_m =
        std::max(patch_clearance(e.corner, e.edge1, e.edge2), kClearance * max_component(glm::abs(p)));
    out.target = clear_of_surface(point, height > 0 ? e.normal : -e.normal, clearance_m);
    out.delta = false;
    const float cosine = std::fabs(height) * inverse;  // exact at grazing angles, where a product of units is not
    const float solid_angle = spherical ? seen.omega() : e.area_m2 * cosine * inverse * inverse;
    out.pdf_sa = probability / solid_angle;
    Rgb radiance = e.radiance;
    if (e.varies) {
        const SurfacePoint at{e.instance, e.triangle, st.x, st.y};
        radiance = emitted_radiance(scene, at, height > 0) * surface_coverage(scene, at);
        if (!(max_component(radiance) > 0)) return false;
    }
    out.radiance_over_pdf = (solid_angle / probability) * radiance;
    return out.pdf_sa < kInfinity;
}

bool LightSampler::Lights::sample_from_tree(const vec3& p, const vec3& n, float u_select, const vec2& u,
                                            float group_probability, LightSample& out) const {
    LightTree::Choice choice;
    if (!tree.sample(p, n, u_select, choice)) return false;
    out.emitter = choice.light;
    return sample_emitter(emitters[choice.light], p, u, choice.probability * group_probability, out);
}

bool LightSampler::Lights::sample_groups(const vec3& p, const vec3& n, float u_select, const vec2& u,
                                         LightSample& out) const {
    const Groups g = groups(p, n);
    if (!(g.sum > 0)) return false;
    // Walks the cumulative probabilities: tree, directional lights, environment.
    float below = 0;
    const auto chosen = [&](float probability, float& rest) {
        if (u_select >= below + probability) {
            below += probability;
            return false;
        }
        rest = std::clamp((u_select - below) / probability, 0.0f, 0x1.fffffep-1f);
        return true;
    };
    float rest = 0;
    const float tree_probability = g.probability(g.tree);
    if (chosen(tree_probability, rest)) return sample_from_tree(p, n, rest, u, tree_probability, out);
    for (const uint32_t light : directional) {
        const float probability = g.probability(directional_estimate(light, n));
        if (!chosen(probability, rest)) continue;
        const PunctualLight& sun = scene.punctual_lights[light];
        out.wi = -sun.direction;
        out.distance = kInfinity;
        out.radiance_over_pdf = sun.intensity / probability;
        out.pdf_sa = probability;
        out.delta = true;
        out.source = light_source_of_punctual(scene, light);
        return true;
    }
    if (!environment) return false;
    const float probability = g.probability(environment_estimate());
    if (!(probability > 0) || !environment->sample(u, out.wi, out.pdf_sa)) return false;
    out.pdf_sa *= probability;
    out.distance = kInfinity;
    out.radiance_over_pdf = environment->radiance(out.wi) / out.pdf_sa;
    out.delta = false;
    out.source = light_source_of_environment(scene);
    return max_component(out.radiance_over_pdf) > 0;
}

LightSampler::LightSampler(const Scene& scene) : LightSampler(scene, EnvironmentDensity::Radiance) {}

LightSampler::LightSampler(const Scene& scene, EnvironmentDensity environment) {
    auto lights = std::make_unique<Lights>(scene);
    std::vector<LightBounds> bounds;
    const std::vector<TriangleLight>& triangles = scene.triangle_lights;
    if (!triangles.empty()) lights->first_of_instance.assign(scene.instances.size(), kNoEmitter);
    for (size_t i = 0; i < triangles.size(); ++i) {
        const TriangleLight& light = triangles[i];
        uint32_t& first = lights->first_of_instance[light.instance];
        if (first == kNoEmitter) {
            first = static_cast<uint32_t>(lights->emitter_of_triangle.size());
            const Mesh& mesh = scene.meshes[scene.instances[light.instance].mesh];
            lights->emitter_of_triangle.resize(first + mesh.triangles.size(), kNoEmitter);
        }
        const uint32_t index = static_cast<uint32_t>(lights->emitters.size());
        lights->emitter_of_triangle[first + light.triangle] = index;
        Emitter emitter = make_triangle(scene, light), merged;
        if (i + 1 < triangles.size() && triangles[i + 1].instance == light.instance &&
            merge_to_parallelogram(emitter, make_triangle(scene, triangles[i + 1]), merged)) {
            emitter = merged;
            lights->emitter_of_triangle[first + triangles[i + 1].triangle] = index;
            ++i;
        }
        lights->emitters.push_back(emitter);
        bounds.push_back(bounds_of(emitter));
    }
    for (uint32_t i = 0; i < scene.punctual_lights.size(); ++i) {
        const PunctualLight& light = scene.punctual_lights[i];
        if (light.kind == PunctualLight::Kind::Directional) {
            lights->directional.push_back(i);
            lights->emitter_of_punctual.push_back(kNoEmitter);
            continue;
        }
        lights->emitter_of_punctual.push_back(static_cast<uint32_t>(lights->emitters.size()));
        Emitter emitter{};
        emitter.corner = light.position;
        emitter.instance = i;
        emitter.shape = light.kind == PunctualLight::Kind::Spot ? Emitter::Shape::Spot : Emitter::Shape::Point;
        lights->emitters.push_back(emitter);
        bounds.push_back(bounds_of(light));
    }
    lights->emitters.shrink_to_fit();
    lights->emitter_of_triangle.shrink_to_fit();
    lights->tree = LightTree(bounds);
    if (scene.environment) lights->environment = std::make_unique<EnvironmentSampler>(*scene.environment, environment);
    lights->tree_only = lights->directional.empty() && !lights->environment;
    lights_ = std::move(lights);
}

LightSampler::~LightSampler() = default;
LightSampler::LightSampler(LightSampler&&) noexcept = default;

bool LightSampler::sample(const vec3& p, const vec3& n, float u_select, const vec2& u, LightSample& out) const {
    return lights_->tree_only ? lights_->sample_from_tree(p, n, u_select, u, 1.0f, out)
                              : lights_->sample_groups(p, n, u_select, u, out);
}

float LightSampler::pdf_triangle(const vec3& p, const vec3& n, uint32_t instance, uint32_t triangle, const vec3& wi,
                                 float distance) const {
    const uint32_t index = lights_->emitter_of(instance, triangle);
    if (index == kNoEmitter) return 0.0f;
    const Emitter& e = lights_->emitters[index];
    const float probability = lights_->emitter_probability(p, n, index);
    const float cosine = std::fabs(glm::dot(e.normal, wi));
    if (!(probability > 0) || !(cosine > 0)) return 0.0f;
    const SeenFrom seen = see(e, p);
    if (seen.omega1 > 0) return probability / seen.omega();
    return probability * sqr(distance) / (e.area_m2 * cosine);
}

float LightSampler::pdf_environment(const vec3& p, const vec3& n, const vec3& wi) const {
    if (!lights_->environment) return 0.0f;
    const float probability = lights_->groups(p, n).probability(lights_->environment_estimate());
    return probability > 0 ? probability * lights_->environment->pdf(wi) : 0.0f;
}

float LightSampler::probability_punctual(const vec3& p, const vec3& n, uint32_t light) const {
    const uint32_t emitter = lights_->emitter_of_punctual[light];
    if (emitter != kNoEmitter) return lights_->emitter_probability(p, n, emitter);
    return lights_->groups(p, n).probability(lights_->directional_estimate(light, n));
}

uint32_t LightSampler::emitter_of(uint32_t instance, uint32_t triangle) const {
    return lights_->emitter_of(instance, triangle);
}

Rgb LightSampler::environment_radiance(const vec3& wi) const {
    return lights_->environment ? lights_->environment->radiance(wi) : Rgb(0);
}

std::span<const Emitter> LightSampler::emitters() const { return lights_->emitters; }

const LightTree& LightSampler::tree() const { return lights_->tree; }

std::span<const uint32_t> LightSampler::directional() const { return lights_->directional; }

const EnvironmentSampler* LightSampler::environment() const { return lights_->environment.get(); }

std::span<const uint32_t> LightSampler::first_of_instance() const { return lights_->first_of_instance; }

std::span<const uint32_t> LightSampler::emitter_of_triangle() const { return lights_->emitter_of_triangle; }

bool LightSampler::empty() const {
    return lights_->tree.empty() && lights_->directional.empty() && !lights_->environment;
}

uint64_t LightSampler::bytes() const {
    const Lights& l = *lights_;
    return sizeof(Lights) + l.emitters.capacity() * sizeof(Emitter) + l.tree.bytes() +
           (l.directional.capacity() + l.emitter_of_punctual.capacity()) * sizeof(uint32_t) +
           l.first_of_instance.capacity() * sizeof(uint32_t) + l.emitter_of_triangle.capacity() * sizeof(uint32_t) +
           (l.environment ? l.environment->bytes() : 0);
}

uint64_t LightSampler::estimate_bytes(uint64_t lights, Size2 environment_size) {
    constexpr uint64_t kBytesPerLight = 224;  // measured: 286,828 bytes for the furnace's 1,280, 108,076 for 482
    return sizeof(Lights) + lights * kBytesPerLight + EnvironmentSampler::bytes_for(environment_size);
}

}  // namespace photond
