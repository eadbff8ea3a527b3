#include "renderer/scene/hard_case_parts.h"

namespace photond::hard_case {

void add_orthographic_camera(Scene& scene, const dvec3& eye, const dvec3& target, const dvec3& up,
                             float half_height_m) {
    Camera camera = look_at_camera(eye, target, up, 0.7f);
    camera.name = "camera";
    camera.orthographic = true;
    camera.ymag = half_height_m;
    scene.cameras.push_back(std::move(camera));
}

void add_camera_down(Scene& scene, float x, float y, float z, float half_height_m) {
    add_orthographic_camera(scene, {x, y, z}, {x, y - 1.0, z}, {0, 0, -1}, half_height_m);
}

void add_directional_light(Scene& scene, const vec3& direction, const Rgb& irradiance) {
    PunctualLight light;
    light.name = "sun";
    light.kind = PunctualLight::Kind::Directional;
    light.direction = glm::normalize(direction);
    light.intensity = irradiance;
    scene.punctual_lights.push_back(std::move(light));
}

void add_point_light(Scene& scene, const vec3& position, const Rgb& intensity) {
    PunctualLight light;
    light.name = "point";
    light.position = position;
    light.intensity = intensity;
    scene.punctual_lights.push_back(std::move(light));
}

Mesh level_rectangle(float x0, float x1, float z0, float z1, float y, bool front_up, uint32_t material) {
    MeshBuilder builder;
    if (front_up)
        builder.quad({x0, y, z1}, {x1, y, z1}, {x1, y, z0}, {x0, y, z0});
    else
        builder.quad({x0, y, z0}, {x1, y, z0}, {x1, y, z1}, {x0, y, z1});
    return builder.build(material);
}

Mesh inward_box(const vec3& min, const vec3& max, uint32_t material) {
    Mesh box = MeshBuilder().box(min, max).build(material);
    for (uvec3& t : box.triangles) std::swap(t.y, t.z);
    return box;
}

KnownCheck equals(std::string_view layer, const dvec3& value, std::optional<uint32_t> bounces, double tolerance) {
    KnownCheck check{.relation = KnownCheck::Relation::Equals, .layer = layer};
    check.value = value;
    check.bounces = bounces;
    check.tolerance = tolerance;
    return check;
}

KnownCheck at_most(std::string_view layer, const dvec3& value, std::optional<uint32_t> bounces) {
    KnownCheck check = equals(layer, value, bounces);
    check.relation = KnownCheck::Relation::AtMost;
    return check;
}

KnownCheck zero(std::string_view layer, std::optional<uint32_t> bounces) {
    KnownCheck check{.relation = KnownCheck::Relation::Zero, .layer = layer};
    check.bounces = bounces;
    return check;
}

KnownCheck same_as(std::string_view layer, std::string_view name, double scale, std::optional<uint32_t> bounces) {
    KnownCheck check{.relation = KnownCheck::Relation::SameAs, .layer = layer};
    check.same_as = std::string(kPrefix) + std::string(name);
    check.scale = scale;
    check.bounces = bounces;
    return check;
}

KnownCheck reference(std::string_view layer, std::optional<uint32_t> bounces) {
    KnownCheck check{.relation = KnownCheck::Relation::Reference, .layer = layer};
    check.bounces = bounces;
    return check;
}

KnownCheck finite() { return {}; }

KnownCheck in_region(KnownCheck check, const std::array<double, 4>& region) {
    check.region = region;
    return check;
}

}  // namespace photond::hard_case
