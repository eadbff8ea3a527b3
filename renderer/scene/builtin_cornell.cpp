// The Cornell box: measured geometry and the reflectances in common use for it.
// [Cornell University Program of Computer Graphics 1998] Cornell Box Data. Millimetres are mapped by x' = (278 -
// x)/100, y' = y/100, z' = -z/100, as in tests/data/reference; corners and triangles are those of its scene.glb.

#include "renderer/scene/builtin_cornell.h"

#include "renderer/scene/builtin_families.h"
#include "renderer/scene/mesh_builder.h"

namespace photond {

namespace {

constexpr Rgb kWhite{0.725f, 0.71f, 0.68f};
constexpr Rgb kRed{0.63f, 0.065f, 0.05f};
constexpr Rgb kGreen{0.14f, 0.45f, 0.091f};

constexpr float kFront = 0, kBack = -5.592f, kCeiling = 5.488f;

void add_quad(Scene& scene, uint32_t material, const vec3& a, const vec3& b, const vec3& c, const vec3& d) {
    add_mesh(scene, MeshBuilder().quad(a, b, c, d).build(material));
}

void add_ceiling_light(Scene& scene) {
    const uint32_t light = add_material(scene, emitter("light", kCornellLightRadiance));
    constexpr float kHeight = 5.478f;
    add_quad(scene, light, {-0.65f, kHeight, -2.27f}, {-0.65f, kHeight, -3.32f}, {0.65f, kHeight, -3.32f},
             {0.65f, kHeight, -2.27f});
}

/// A block from the corners of its top, counter-clockwise seen from above; it has no bottom, as measured.
Mesh make_block(uint32_t material, const vec3 (&top)[4], const int (&side_order)[4]) {
    MeshBuilder block;
    block.quad(top[0], top[1], top[2], top[3]);
    for (const int s : side_order) {
        const vec3 a = top[(s + 1) % 4], b = top[s];
        block.quad({a.x, 0, a.z}, a, b, {b.x, 0, b.z});
    }
    return block.build(material);
}

void add_short_block(Scene& scene, uint32_t material) { add_mesh(scene, make_cornell_short_block(material)); }

/// A block of the tall one's size and place, turned so that its front shows the room instead of the dark before it.
void add_mirror_block(Scene& scene, uint32_t material) {
    constexpr float kHalf = 0.825f, kTop = 3.3f, kTurn = 0.73f;  // [rad] from the back wall
    const vec3 centre(-0.9f, kTop, -3.5f);
    const vec3 right(kHalf * std::cos(kTurn), 0, -kHalf * std::sin(kTurn));
    const vec3 front(kHalf * std::sin(kTurn), 0, kHalf * std::cos(kTurn));
    add_mesh(scene, make_block(material,
                               {centre - right + front, centre + right + front, centre + right - front,
                                centre - right - front},
                               {0, 1, 2, 3}));
}

constexpr uint32_t kWhiteMaterial = 0;

}  // namespace

Scene make_cornell_room(const Material& floor_material) {
    Scene scene;
    const uint32_t white = add_material(scene, lambert("white", kWhite));
    const uint32_t red = add_material(scene, lambert("red", kRed));
    const uint32_t green = add_material(scene, lambert("green", kGreen));
    const uint32_t floor = floor_material.name.empty() ? white : add_material(scene, floor_material);
    add_quad(scene, floor, {-2.748f, 0, kFront}, {2.78f, 0, kFront}, {2.78f, 0, kBack}, {-2.716f, 0, kBack});
    add_quad(scene, white, {-2.78f, kCeiling, kFront}, {-2.78f, kCeiling, kBack}, {2.78f, kCeiling, kBack},
             {2.78f, kCeiling, kFront});
    add_quad(scene, white, {-2.716f, 0, kBack}, {2.78f, 0, kBack}, {2.78f, kCeiling, kBack}, {-2.78f, kCeiling, kBack});
    add_quad(scene, green, {2.78f, 0, kBack}, {2.78f, 0, kFront}, {2.78f, kCeiling, kFront}, {2.78f, kCeiling, kBack});
    add_quad(scene, red, {-2.748f, 0, kFront}, {-2.716f, 0, kBack}, {-2.78f, kCeiling, kBack},
             {-2.78f, kCeiling, kFront});

    Camera camera;
    camera.name = "camera";
    camera.position = vec3(0, 2.73f, 8);
    camera.yfov = 0.6860478808414068f;
    scene.cameras.push_back(camera);
    return scene;
}

Mesh make_cornell_short_block(uint32_t material) {
    constexpr float kTop = 1.65f;
    return make_block(material,
                      {{1.48f, kTop, -0.65f}, {1.96f, kTop, -2.25f}, {0.38f, kTop, -2.72f}, {-0.12f, kTop, -1.14f}},
                      {2, 3, 0, 1});
}

void add_cornell_tall_block(Scene& scene, uint32_t material) {
    constexpr float kTop = 3.3f;
    add_mesh(scene,
             make_block(material,
                        {{-1.45f, kTop, -2.47f}, {0.13f, kTop, -2.96f}, {-0.36f, kTop, -4.56f}, {-1.94f, kTop, -4.06f}},
                        {3, 2, 1, 0}));
}

Scene make_cornell_box() {
    Scene scene = make_cornell_room({});
    add_ceiling_light(scene);
    add_short_block(scene, kWhiteMaterial);
    add_cornell_tall_block(scene, kWhiteMaterial);
    return scene;
}

Scene make_cornell_box_spot() {
    Scene scene = make_cornell_room({});
    add_short_block(scene, kWhiteMaterial);
    add_cornell_tall_block(scene, kWhiteMaterial);
    PunctualLight spot;
    spot.name = "roof spot";
    spot.kind = PunctualLight::Kind::Spot;
    spot.intensity = 80.0f * Rgb(1, 0.9f, 0.75f);
    spot.position = vec3(0, 5.45f, -1);
    spot.direction = glm::normalize(vec3(0, -0.829f, -0.559f));
    spot.cos_inner = std::cos(0.3490658503988659f);
    spot.cos_outer = std::cos(0.7853981633974483f);
    scene.punctual_lights.push_back(spot);
    return scene;
}

Scene make_cornell_box_glass() {
    Scene scene = make_cornell_room({});
    add_ceiling_light(scene);
    add_mirror_block(scene, add_material(scene, metal("mirror", Rgb(0.95f), 0)));
    constexpr float kRadius = 0.95f;
    constexpr uint32_t kSlices = 192;
    // A little above the floor, so that no two surfaces touch.
    add_mesh(scene, MeshBuilder()
                        .sphere({0.95f, kRadius + 0.005f, -1.5f}, kRadius, kSlices)
                        .build(add_material(scene, glass("glass"))));
    return scene;
}

Scene make_cornell_box_glossy() {
    Scene scene = make_cornell_room(plastic("varnished floor", kWhite, 0.25f));
    add_ceiling_light(scene);
    add_short_block(scene, add_material(scene, plastic("blue plastic", {0.1f, 0.18f, 0.45f}, 0.12f)));
    add_cornell_tall_block(scene, add_material(scene, metal("brushed copper", {0.955f, 0.638f, 0.538f}, 0.3f)));
    return scene;
}

namespace {

/// Brushed floor and tall block, GGX of the same width as a lobe of Phong's with that exponent: alpha^2 = 2 / (exponent
/// + 2) [Walter 2007, section 5.3], and roughness^2 = alpha.
Scene make_box_of_glossiness(float exponent) {
    const float roughness = std::pow(2 / (exponent + 2), 0.25f);
    Scene scene = make_cornell_room(metal("brushed floor", kWhite, roughness));
    add_ceiling_light(scene);
    add_short_block(scene, 0);
    add_cornell_tall_block(scene, add_material(scene, metal("brushed copper", {0.955f, 0.638f, 0.538f}, roughness)));
    return scene;
}

}  // namespace

Scene make_box_of_glossiness_10() { return make_box_of_glossiness(10); }
Scene make_box_of_glossiness_30() { return make_box_of_glossiness(30); }
Scene make_box_of_glossiness_50() { return make_box_of_glossiness(50); }

}  // namespace photond
