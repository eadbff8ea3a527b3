#include "renderer/transport/emission_sampling.h"

#include <cassert>
#include <map>

#include "renderer/transport/discrete_distribution.h"
#include "renderer/transport/emission.h"
#include "renderer/transport/emission_sampling_shared.h"
#include "renderer/transport/environment_sampling.h"
#include "renderer/transport/lambert_lanes.h"
#include "renderer/transport/light_sampling.h"
#include "renderer/transport/light_triangle.h"
#include "renderer/transport/ray_start.h"
#include "renderer/transport/sampling.h"

namespace photond {

namespace {

vec3 sample_sphere(const vec2& u) {
    const float z = 1 - 2 * u.x;
    const float r = 2 * std::sqrt(std::max(0.0f, u.x * (1 - u.x)));
    return {r * std::cos(2 * kPi * u.y), r * std::sin(2 * kPi * u.y), z};
}

/// By which light paths choose their lights: the powers, but for kShared of the paths, which all sources
/// (light_source_of_*) have in equal parts, for a light far dimmer than another may be all that there is where it
/// shines. No path carries more for it than 1 / (1 - kShared) of what it would by power alone, and where all sources
/// have one power nothing changes: within a source it is power alone that counts.
std::vector<double> choice_weights(const std::vector<double>& powers_w, const std::vector<uint32_t>& sources) {
    constexpr double kShared = 1.0 / 16;
    std::map<uint32_t, double> source_power_w;
    double total_w = 0;
    for (size_t i = 0; i < powers_w.size(); ++i)
        if (powers_w[i] > 0) source_power_w[sources[i]] += powers_w[i], total_w += powers_w[i];
    if (source_power_w.size() < 2) return powers_w;
    std::vector<double> weights(powers_w);
    const double share_w = kShared * total_w / static_cast<double>(source_power_w.size());
    for (size_t i = 0; i < powers_w.size(); ++i)
        if (powers_w[i] > 0) weights[i] *= 1 - kShared + share_w / source_power_w[sources[i]];
    return weights;
}

}  // namespace

struct EmissionSampler::Lights {
    explicit Lights(const Scene& lit_scene)
        : scene(lit_scene), centre(lit_scene.bounds.centre()), radius_m(lit_scene.bounds.radius()) {}

    const Scene& scene;
    vec3 centre;
    float radius_m;                        // of the bounding sphere
    std::vector<LightTriangle> triangles;  // beside scene.triangle_lights
    std::unique_ptr<EnvironmentSampler> environment;
    DiscreteDistribution choice;
    double total_power_w = 0;

    float disc_m2() const { return kPi * sqr(radius_m); }

    double triangle_power_w(const TriangleLight& light) const {
        return mean(light.radiance) * double{light.area_m2} * kPi * (light.two_sided ? 2 : 1);
    }
    double punctual_power_w(const PunctualLight& light) const {
        const double intensity = mean(light.intensity);
        switch (light.kind) {
            case PunctualLight::Kind::Point: return intensity * 4 * kPi;
            case PunctualLight::Kind::Spot: return intensity * SpotCone(light).solid_angle();
            case PunctualLight::Kind::Directional: return intensity * disc_m2();
        }
        return 0;
    }

    Ray ray_from_outside(const vec3& direction, const vec2& u) const {
        const vec2 place = radius_m * sample_unit_disk(u);
        const Frame frame(direction);
        const vec3 start(place.x, place.y, -EMISSION_START_IN_RADII * radius_m);
        return {centre + frame.to_world(start), direction, kInfinity};
    }

    void sample_triangle(uint32_t light, const vec2& u_position, vec2 u_direction, EmissionSample& out) const;
    void sample_punctual(const PunctualLight& light, const vec2& u_position, const vec2& u_direction,
                         EmissionSample& out) const;
    bool sample_environment(const vec2& u_position, const vec2& u_direction, EmissionSample& out) const;

    // EmissionSampler::aim() at a target, of each kind.
    bool aim_triangle(uint32_t light, const vec3& target, const vec2& u_position, vec2& u_direction) const;
    bool aim_punctual(const PunctualLight& light, const vec3& target, vec2& u_position, vec2& u_direction) const;
    bool aim_from_outside(const vec3& direction, const vec3& target, vec2& u) const;

    // For many samples: those at `places`, whose lights are chosen and stand in the samples, with power_w the inverse
    // of the choice's probability. Triangles without a texture, and directional lights.
    void sample_triangles(const EmissionNumbers& numbers, std::span<const uint32_t> places,
                          std::span<EmissionSample> samples) const;
    void sample_directional(const EmissionNumbers& numbers, std::span<const uint32_t> places,
                            std::span<EmissionSample> samples) const;
};

// The three set ray, range and power, the last without the probability of the light's choice.

void EmissionSampler::Lights::sample_triangle(uint32_t index, const vec2& u_position, vec2 u_direction,
                                              EmissionSample& out) const {
    const TriangleLight& light = scene.triangle_lights[index];
    const LightTriangle& triangle = triangles[index];
    bool front = true;
    if (light.two_sided) {
        front = u_direction.x < 0.5f;
        u_direction.x = 2 * u_direction.x - (front ? 0.0f : 1.0f);
    }
    const vec2 st = photond::sample_triangle(u_position);
    Rgb radiance = light.radiance;
    if (triangle.varies) {
        const SurfacePoint point{light.instance, light.triangle, st.x, st.y};
        radiance = emitted_radiance(scene, point, front) * surface_coverage(scene, point);
    }
    out.power_w = radiance * (light.area_m2 * kPi * (light.two_sided ? 2.0f : 1.0f));
    const vec3 normal = front ? triangle.normal : -triangle.normal;
    const vec3 point = triangle.corner + st.x * triangle.edge1 + st.y * triangle.edge2;
    const float clearance_m = patch_clearance(triangle.corner, triangle.edge1, triangle.edge2);
    out.ray = {clear_of_surface(point, normal, clearance_m),
               Frame(normal).to_world(sample_cosine_hemisphere(u_direction)), kInfinity};
    out.range_m = kInfinity;
    out.source = light_source_of_instance(light.instance);
}

void EmissionSampler::Lights::sample_punctual(const PunctualLight& light, const vec2& u_position,
                                              const vec2& u_direction, EmissionSample& out) const {
    out.range_m = light.range_m;
    switch (light.kind) {
        case PunctualLight::Kind::Point:
            out.ray = {light.position, sample_sphere(u_direction), kInfinity};
            out.power_w = light.intensity * (4 * kPi);
            break;
        case PunctualLight::Kind::Spot: {
            const SpotCone cone(light);
            out.ray = {light.position, Frame(light.direction).to_world(cone.sample(u_direction)), kInfinity};
            out.power_w = light.intensity * static_cast<float>(cone.solid_angle());
            break;
        }
        case PunctualLight::Kind::Directional:
            out.ray = ray_from_outside(light.direction, u_position);
            out.power_w = light.intensity * disc_m2();
            out.range_m = kInfinity;
            break;
    }
}

bool EmissionSampler::Lights::sample_environment(const vec2& u_position, const vec2& u_direction,
                                                 EmissionSample& out) const {
    vec3 wi;
    float pdf_sa;
    if (!environment->sample(u_direction, wi, pdf_sa)) return false;
    out.ray = ray_from_outside(-wi, u_position);
    out.power_w = environment->radiance(wi) * (disc_m2() / pdf_sa);
    out.range_m = kInfinity;
    return true;
}

namespace {

/// The numbers at some of the places of an array.
FloatLanes gather(std::span<const float> numbers, std::span<const uint32_t> places) {
    alignas(kLaneAlignment) LaneFloats values;
    for (size_t lane = 0; lane < kLanes; ++lane) values[lane] = numbers[places[std::min(lane, places.size() - 1)]];
    return FloatLanes(values, lambert_lanes::kAligned);
}

}  // namespace

void EmissionSampler::Lights::sample_triangles(const EmissionNumbers& numbers, std::span<const uint32_t> places,
                                               std::span<EmissionSample> samples) const {
    using namespace lambert_lanes;
    Vec3Array corner, edge1, edge2, normal, start, direction;
    alignas(kLaneAlignment) LaneFloats sides, clearance;
    for (size_t first = 0; first < places.size(); first += kLanes) {
        const std::span<const uint32_t> mine = places.subspan(first, std::min(kLanes, places.size() - first));
        for (size_t lane = 0; lane < kLanes; ++lane) {  // lanes past the end repeat the last sample and are not read
            const uint32_t light = samples[mine[std::min(lane, mine.size() - 1)]].light;
            const LightTriangle& triangle = triangles[light];
            corner.set(lane, triangle.corner), normal.set(lane, triangle.normal);
            edge1.set(lane, triangle.edge1), edge2.set(lane, triangle.edge2);
            sides[lane] = scene.triangle_lights[light].two_sided ? 2.0f : 1.0f;
            clearance[lane] = patch_clearance(triangle.corner, triangle.edge1, triangle.edge2);
        }
        // As photond::sample_triangle().
        const FloatLanes x = gather(numbers.position_x, mine), y = gather(numbers.position_y, mine);
        const FloatMask upper = y > x;
        const FloatLanes half = 0.5f * photond::select(upper, x, y);
        const FloatLanes s = photond::select(upper, half, x - half), t = photond::select(upper, y - half, half);

        const FloatLanes side = FloatLanes(sides, kAligned) * gather(numbers.direction_x, mine);
        const FloatMask back = side >= 1.0f;  // of two-sided ones only: numbers are below 1
        const Vec3Lanes n = photond::select(back, FloatLanes(-1), FloatLanes(1)) * normal.load();
        const Vec3Lanes point =
            corner.load() + s * edge1.load() + t * edge2.load() + FloatLanes(clearance, kAligned) * n;
        start.store(
            {step_off_coordinate(point.x, n.x), step_off_coordinate(point.y, n.y), step_off_coordinate(point.z, n.z)});
        direction.store(to_world(
            n, cosine_hemisphere(photond::select(back, side - 1.0f, side), gather(numbers.direction_y, mine))));
        for (size_t lane = 0; lane < mine.size(); ++lane) {
            EmissionSample& sample = samples[mine[lane]];
            const TriangleLight& light = scene.triangle_lights[sample.light];
            sample.ray = {start.get(lane), direction.get(lane), kInfinity};
            sample.power_w *= light.radiance * (light.area_m2 * kPi * sides[lane]);
            sample.range_m = kInfinity;
            sample.source = light_source_of_instance(light.instance);
        }
    }
}

void EmissionSampler::Lights::sample_directional(const EmissionNumbers& numbers, std::span<const uint32_t> places,
                                                 std::span<EmissionSample> samples) const {
    using namespace lambert_lanes;
    const auto punctual_of = [&](uint32_t place) {
        return samples[place].light - static_cast<uint32_t>(triangles.size());
    };
    Vec3Array direction, start;
    for (size_t first = 0; first < places.size(); first += kLanes) {
        const std::span<const uint32_t> mine = places.subspan(first, std::min(kLanes, places.size() - first));
        for (size_t lane = 0; lane < kLanes; ++lane)
            direction.set(lane, scene.punctual_lights[punctual_of(mine[std::min(lane, mine.size() - 1)])].direction);
        // As ray_from_outside().
        const auto [x, y] = unit_disk(gather(numbers.position_x, mine), gather(numbers.position_y, mine));
        start.store(broadcast(centre) +
                    radius_m * to_world(direction.load(), {x, y, FloatLanes(-EMISSION_START_IN_RADII)}));
        for (size_t lane = 0; lane < mine.size(); ++lane) {
            EmissionSample& sample = samples[mine[lane]];
            const uint32_t index = punctual_of(mine[lane]);
            const PunctualLight& light = scene.punctual_lights[index];
            sample.ray = {start.get(lane), light.direction, kInfinity};
            sample.power_w *= light.intensity * disc_m2();
            sample.range_m = kInfinity;
            sample.source = light_source_of_punctual(scene, index);
        }
    }
}

EmissionSampler::EmissionSampler(const Scene& scene) {
    auto lights = std::make_unique<Lights>(scene);
    std::vector<double> powers_w;
    std::vector<uint32_t> sources;
    lights->triangles.reserve(scene.triangle_lights.size());
    for (const TriangleLight& light : scene.triangle_lights) {
        lights->triangles.push_back(make_light_triangle(scene, light));
        powers_w.push_back(lights->triangle_power_w(light));
        sources.push_back(light_source_of_instance(light.instance));
    }
    for (uint32_t i = 0; i < scene.punctual_lights.size(); ++i) {
        powers_w.push_back(lights->punctual_power_w(scene.punctual_lights[i]));
        sources.push_back(light_source_of_punctual(scene, i));
    }
    if (scene.environment) {
        lights->environment = std::make_unique<EnvironmentSampler>(*scene.environment);
        powers_w.push_back(4 * kPi * double{lights->environment->mean_radiance()} * lights->disc_m2());
        sources.push_back(light_source_of_environment(scene));
    }
    // Without a surface there is nothing to light, nor a sphere for light from outside.
    if (!scene.bounds.empty()) {
        for (const double power_w : powers_w) lights->total_power_w += power_w;
        lights->choice = DiscreteDistribution(choice_weights(powers_w, sources));
    }
    lights_ = std::move(lights);
}

EmissionSampler::~EmissionSampler() = default;
EmissionSampler::EmissionSampler(EmissionSampler&&) noexcept = default;
EmissionSampler& EmissionSampler::operator=(EmissionSampler&&) noexcept = default;

std::optional<EmissionSampler> emission_of(const Scene& scene) {
    EmissionSampler sampler(scene);
    if (!(sampler.total_power_w() > 0)) return std::nullopt;
    return sampler;
}

bool EmissionSampler::sample(float u_light, const vec2& u_position, const vec2& u_direction,
                             EmissionSample& out) const {
    if (lights_->choice.empty()) return false;
    const uint32_t light = lights_->choice.sample(u_light);
    return sample_light(light, lights_->choice.probability(light), u_position, u_direction, out);
}

void EmissionSampler::sample(const EmissionNumbers& numbers, std::span<EmissionSample> samples) const {
    constexpr size_t kBlock = 256;  // samples whose places are sorted together, by how they are drawn
    uint32_t in_triangles[kBlock], directional[kBlock];
    const size_t triangles = lights_->triangles.size();
    for (size_t first = 0; first < samples.size(); first += kBlock) {
        size_t triangle_count = 0, directional_count = 0;
        for (size_t i = first; i < std::min(first + kBlock, samples.size()); ++i) {
            EmissionSample& out = samples[i];
            out.power_w = Rgb(0);
            if (lights_->choice.empty()) continue;
            out.light = lights_->choice.sample(numbers.light[i]);
            const float probability = lights_->choice.probability(out.light);
            const bool plain_triangle = out.light < triangles && !lights_->triangles[out.light].varies;
            if (plain_triangle || guided_by_position(out.light)) {
                out.power_w = Rgb(1 / probability);
                (plain_triangle ? in_triangles[triangle_count++] : directional[directional_count++]) =
                    static_cast<uint32_t>(i);
            } else if (!sample_light(out.light, probability, {numbers.position_x[i], numbers.position_y[i]},
                                     {numbers.direction_x[i], numbers.direction_y[i]}, out)) {
                out.power_w = Rgb(0);
            }
        }
        lights_->sample_triangles(numbers, {in_triangles, triangle_count}, samples);
        lights_->sample_directional(numbers, {directional, directional_count}, samples);
    }
}

bool EmissionSampler::sample_light(uint32_t light, float probability, const vec2& u_position, const vec2& u_direction,
                                   EmissionSample& out) const {
    if (!(this->probability(light) > 0)) return false;
    assert(probability > 0);
    const Scene& scene = lights_->scene;
    const size_t triangles = lights_->triangles.size(), punctual = scene.punctual_lights.size();
    if (light < triangles) {
        lights_->sample_triangle(light, u_position, u_direction, out);
    } else if (light < triangles + punctual) {
        const uint32_t index = light - static_cast<uint32_t>(triangles);
        lights_->sample_punctual(scene.punctual_lights[index], u_position, u_direction, out);
        out.source = light_source_of_punctual(scene, index);
    } else {
        if (!lights_->sample_environment(u_position, u_direction, out)) return false;
        out.source = light_source_of_environment(scene);
    }
    out.light = light;
    out.power_w /= probability;
    return max_component(out.power_w) > 0;
}

bool EmissionSampler::Lights::aim_triangle(uint32_t index, const vec3& target, const vec2& u_position,
                                           vec2& u_direction) const {
    const LightTriangle& triangle = triangles[index];
    const vec2 st = photond::sample_triangle(u_position);
    const vec3 way = target - (triangle.corner + st.x * triangle.edge1 + st.y * triangle.edge2);
    const float height = glm::dot(way, triangle.normal), distance = glm::length(way);
    const bool two_sided = scene.triangle_lights[index].two_sided, front = height > 0;
    if (!(std::fabs(height) > 0) || (!front && !two_sided)) return false;
    const vec3 local = Frame(front ? triangle.normal : -triangle.normal).to_local(way / distance);
    u_direction = unit_disk_inverse(vec2(local));
    if (two_sided) u_direction.x = 0.5f * (u_direction.x + (front ? 0.0f : 1.0f));
    return true;
}

bool EmissionSampler::Lights::aim_punctual(const PunctualLight& light, const vec3& target, vec2& u_position,
                                           vec2& u_direction) const {
    if (light.kind == PunctualLight::Kind::Directional) return aim_from_outside(light.direction, target, u_position);
    const vec3 way = target - light.position;
    const float distance = glm::length(way);
    if (!(distance > 0)) return false;
    const bool spot = light.kind == PunctualLight::Kind::Spot;
    const vec3 direction = spot ? Frame(light.direction).to_local(way / distance) : way / distance;
    const SpotCone cone(light);
    if (spot && !(direction.z > cone.cos_outer())) return false;
    const float turns = std::atan2(direction.y, direction.x) * (0.5f * kInvPi);
    u_direction = {spot ? cone.number(direction.z) : 0.5f - 0.5f * direction.z, turns < 0 ? turns + 1 : turns};
    return true;
}

bool EmissionSampler::Lights::aim_from_outside(const vec3& direction, const vec3& target, vec2& u) const {
    const vec2 place = vec2(Frame(direction).to_local(target - centre)) / radius_m;
    if (!(glm::length(place) <= 1)) return false;
    u = unit_disk_inverse(place);
    return true;
}

bool EmissionSampler::aim(uint32_t light, const vec3& point, vec2& u_position, vec2& u_direction) const {
    if (!(probability(light) > 0)) return false;
    const size_t triangles = lights_->triangles.size(), punctual = lights_->scene.punctual_lights.size();
    bool meets;
    if (light < triangles) {
        meets = lights_->aim_triangle(light, point, u_position, u_direction);
    } else if (light < triangles + punctual) {
        meets =
            lights_->aim_punctual(lights_->scene.punctual_lights[light - triangles], point, u_position, u_direction);
    } else {
        vec3 wi;
        float pdf_sa;
        meets =
            lights_->environment->sample(u_direction, wi, pdf_sa) && lights_->aim_from_outside(-wi, point, u_position);
    }
    constexpr float kBelowOne = 1 - 0x1p-24f;
    u_position = glm::clamp(u_position, 0.0f, kBelowOne);
    u_direction = glm::clamp(u_direction, 0.0f, kBelowOne);
    return meets;
}

uint32_t EmissionSampler::lights() const {
    const size_t outside = lights_->environment ? 1 : 0;
    return static_cast<uint32_t>(lights_->triangles.size() + lights_->scene.punctual_lights.size() + outside);
}

float EmissionSampler::probability(uint32_t light) const { return lights_->choice.probability(light); }

bool EmissionSampler::guided_by_position(uint32_t light) const {
    const std::vector<PunctualLight>& punctual = lights_->scene.punctual_lights;
    const size_t triangles = lights_->triangles.size();
    return light >= triangles && light < triangles + punctual.size() &&
           punctual[light - triangles].kind == PunctualLight::Kind::Directional;
}

std::span<const LightTriangle> EmissionSampler::triangles() const { return lights_->triangles; }

const DiscreteDistribution& EmissionSampler::choice() const { return lights_->choice; }

float EmissionSampler::disc_m2() const { return lights_->disc_m2(); }

const EnvironmentSampler* EmissionSampler::environment() const { return lights_->environment.get(); }

double EmissionSampler::total_power_w() const { return lights_->total_power_w; }

uint64_t EmissionSampler::bytes() const {
    return sizeof(Lights) + lights_->triangles.capacity() * sizeof(LightTriangle) + lights_->choice.bytes() +
           (lights_->environment ? lights_->environment->bytes() : 0);
}

uint64_t EmissionSampler::estimate_bytes(uint64_t lights, Size2 environment_size) {
    return sizeof(Lights) + lights * sizeof(LightTriangle) + DiscreteDistribution::bytes_for(lights) +
           EnvironmentSampler::bytes_for(environment_size);
}

}  // namespace photond
