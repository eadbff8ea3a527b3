// Tools on a floor in the beam of a flashlight that lies among them. After the tools of [Hachisuka and Jensen 2009]
// Stochastic Progressive Photon Mapping. ACM TOG 28(5): the light's glass and reflector cast caustics, which are seen
// again in glossy metal, flashlight and pliers out of focus.

#include "renderer/scene/builtin_families.h"
#include "renderer/scene/builtin_furniture.h"

namespace photond {

namespace {

constexpr float kLift = 0.0005f;  // above the floor, so that no two surfaces touch

mat4 placed(const vec3& at, float yaw) { return glm::rotate(glm::translate(mat4(1), at), yaw, vec3(0, 1, 0)); }

/// Lies down, in a space placed by `at`, what stands on y = 0 otherwise: +y goes to +x, `height` above the floor there.
mat4 lying(const mat4& at, float height) {
    return glm::rotate(glm::translate(at, vec3(0, height, 0)), -kPi / 2, vec3(0, 0, 1));
}

vec2 on_hexagon(float radius, float turn) {
    const float sector = turn * 6 - std::floor(turn * 6);
    const float to_flat = std::cos(kPi / 6) / std::cos((sector - 0.5f) * kPi / 3);
    return radius * to_flat * vec2(std::cos(2 * kPi * turn), -std::sin(2 * kPi * turn));
}

/// A hexagonal prism about +y with a round hole of `hole` radius, 0 for none.
void add_hexagon(MeshBuilder& metal, float radius, float low, float high, float hole) {
    constexpr uint32_t kSlices = 24;
    for (uint32_t i = 0; i < kSlices; ++i) {
        const auto at = [&](uint32_t k, bool outer, float y) {
            const float turn = static_cast<float>(k % kSlices) / kSlices;
            const vec2 p =
                outer ? on_hexagon(radius, turn) : hole * vec2(std::cos(2 * kPi * turn), -std::sin(2 * kPi * turn));
            return vec3(p.x, y, p.y);
        };
        metal.quad(at(i, true, low), at(i + 1, true, low), at(i + 1, true, high), at(i, true, high));
        if (hole > 0) {
            metal.quad(at(i + 1, false, low), at(i, false, low), at(i, false, high), at(i + 1, false, high));
            metal.quad(at(i, false, high), at(i, true, high), at(i + 1, true, high), at(i + 1, false, high));
            metal.quad(at(i + 1, false, low), at(i + 1, true, low), at(i, true, low), at(i, false, low));
        } else {
            metal.triangle({0, high, 0}, at(i, true, high), at(i + 1, true, high));
            metal.triangle({0, low, 0}, at(i + 1, true, low), at(i, true, low));
        }
    }
}

constexpr float kBoltHead = 0.0085f, kBoltHeadHeight = 0.0055f, kBoltRadius = 0.0045f, kBoltLength = 0.036f;

/// A bolt that stands on its head.
void add_bolt(MeshBuilder& metal) {
    add_hexagon(metal, kBoltHead, 0, kBoltHeadHeight, 0);
    constexpr float kPitch = 0.0016f, kDepth = 0.0007f, kPlain = 0.013f;
    std::vector<vec2> profile = {{kBoltRadius, kBoltHeadHeight}, {kBoltRadius, kPlain}};
    float y = kPlain;
    for (; y + kPitch < kBoltLength; y += kPitch) {
        profile.emplace_back(kBoltRadius - kDepth, y + 0.5f * kPitch);
        profile.emplace_back(kBoltRadius, y + kPitch);
    }
    profile.emplace_back(kBoltRadius - kDepth, y + 0.5f * kPitch);
    profile.emplace_back(0.0f, y + 0.5f * kPitch);
    metal.lathe(profile, 32, 0.2f);
}

/// Long-nosed pliers that lie flat and open along +x, their rivet at the origin.
void add_pliers(MeshBuilder& metal, MeshBuilder& grips) {
    constexpr float kMiddle = 0.009f;
    constexpr uint32_t kSteps = 14;
    const mat4 outer = metal.placing();
    for (const float side : {-1.0f, 1.0f}) {
        // The jaw: a long cone, flatter than wide, a little apart from the other.
        const vec2 jaw[] = {{0, 0},      {0.0068f, 0}, {0.0068f, 0.006f}, {0.0022f, 0.052f}, {0.0016f, 0.0535f},
                            {0, 0.0535f}};
        mat4 at = glm::translate(outer, vec3(0.006f, kMiddle, 0.0072f * side));
        at = glm::rotate(glm::rotate(at, -0.06f * side, vec3(0, 1, 0)), -kPi / 2, vec3(0, 0, 1));
        metal.place(glm::scale(at, vec3(0.75f, 1, 1))).lathe(jaw, 32, 0.3f);
        // The handle comes from the other side of the rivet and bends outwards.
        metal.place(outer), grips.place(outer);
        std::vector<vec3> bare, held;
        for (uint32_t i = 0; i <= kSteps; ++i) {
            const float t = static_cast<float>(i) / kSteps;
            const vec3 p(0.01f - 0.12f * t, kMiddle, -side * (0.004f + 0.024f * std::sin(2.2f * t)));
            (t < 0.36f ? bare : held).push_back(p);
            if (t < 0.36f && t + 1.0f / kSteps >= 0.36f) held.push_back(p);
        }
        bare.push_back(held[1]);
        metal.pipe(bare, 0.0042f, 20);
        grips.pipe(held, 0.0065f, 20).sphere(held.front(), 0.0065f, 20).sphere(held.back(), 0.0065f, 20);
    }
    metal.place(outer).cylinder({0, kMiddle - 0.0065f, 0}, 0.0125f, 0.013f, 48);
    metal.cylinder({0, kMiddle + 0.0068f, 0}, 0.0055f, 0.0015f, 32);
    metal.place(outer);
}

/// The flashlight lights along +y from its front at y = 0.
void add_flashlight(Scene& scene, const mat4& at) {
    constexpr float kBody = 0.028f, kInside = 0.0242f, kGlassRadius = 0.0236f, kGlassLow = -0.0035f,
                    kGlassHigh = -0.0012f;
    constexpr float kDish = 0.0225f, kDishRim = kGlassLow - 0.0002f, kDishDepth = 0.024f;
    MeshBuilder body, dish, front, bulb;
    for (MeshBuilder* part : {&body, &front, &bulb}) part->place(at);
    const vec2 profile[] = {{0, -0.15f},         {0.024f, -0.15f},       {0.0275f, -0.147f},  {0.0275f, -0.125f},
                            {0.021f, -0.118f},   {0.021f, -0.06f},       {kBody, -0.045f},    {kBody, -0.001f},
                            {kBody - 0.001f, 0}, {kInside + 0.0003f, 0}, {kInside, -0.0003f}, {kInside, -0.035f},
                            {0, -0.035f}};
    body.lathe(profile, 64, 0.3f);
    furniture::add_reflector(dish.place(glm::translate(at, vec3(0, kDishRim, 0))), kDish, kDishDepth, 96);
    front.cylinder({0, kGlassLow, 0}, kGlassRadius, kGlassHigh - kGlassLow, 96);
    // Nearer to the apex than the focus, so that the beam widens.
    constexpr float kFocus = kDish * kDish / (4 * kDishDepth);
    bulb.sphere({0, kDishRim - kDishDepth + 0.8f * kFocus, 0}, 0.0015f, 16);
    add_mesh(scene, body.build(add_material(scene, plastic("yellow body", {0.7f, 0.45f, 0.05f}, 0.3f))));
    add_mesh(scene, dish.build(add_material(scene, metal("reflector", Rgb(0.93f), 0))));
    add_mesh(scene, front.build(add_material(scene, glass("front glass"))));
    add_mesh(scene, bulb.build(add_material(scene, emitter("bulb", Rgb(4200, 3900, 3300)))));
}

}  // namespace

Scene make_progressive_flashlight() {
    Scene scene;
    const uint32_t floor = add_material(scene, lambert("floor", {0.62f, 0.58f, 0.52f}));
    const uint32_t steel = add_material(scene, metal("polished steel", {0.72f, 0.71f, 0.69f}, 0.1f));
    const uint32_t brass = add_material(scene, metal("polished brass", {0.91f, 0.76f, 0.42f}, 0.12f));
    const uint32_t rubber = add_material(scene, plastic("red grips", {0.55f, 0.05f, 0.04f}, 0.35f));
    constexpr float kBack = -0.17f, kRight = 0.27f, kFar = 1, kTop = 0.5f;
    add_mesh(
        scene,
        MeshBuilder().quad({-kFar, 0, kFar}, {kRight, 0, kFar}, {kRight, 0, kBack}, {-kFar, 0, kBack}).build(floor));
    add_mesh(scene, MeshBuilder()
                        .quad({-kFar, 0, kBack}, {kRight, 0, kBack}, {kRight, kTop, kBack}, {-kFar, kTop, kBack})
                        .quad({kRight, 0, kBack}, {kRight, 0, kFar}, {kRight, kTop, kFar}, {kRight, kTop, kBack})
                        .build(add_material(scene, lambert("wall", {0.75f, 0.74f, 0.72f}))));
    add_flashlight(scene, lying(placed({-0.065f, 0, -0.045f}, -0.3f), 0.028f + kLift));

    MeshBuilder bolts, nuts, pliers, grips;
    const float lying_height = kBoltHead * std::cos(kPi / 6) + kLift;
    const auto turned = [](const mat4& at) { return glm::rotate(at, kPi / 6, vec3(0, 1, 0)); };  // onto a flat side
    add_bolt(bolts.place(turned(lying(placed({0.035f, 0, 0.035f}, 0.9f), lying_height))));
    add_bolt(bolts.place(turned(lying(placed({0.095f, 0, 0.05f}, -0.5f), lying_height))));
    add_bolt(bolts.place(placed({0.06f, kLift, -0.015f}, 0.2f)));
    add_hexagon(nuts.place(placed({0.005f, kLift, 0.045f}, 0.4f)), 0.0085f, 0, 0.0065f, 0.0046f);
    add_hexagon(nuts.place(placed({0.11f, kLift, 0.01f}, 0.1f)), 0.0085f, 0, 0.0065f, 0.0046f);
    const mat4 away = placed({0.09f, 0, -0.075f}, 2.85f);
    add_pliers(pliers.place(away), grips.place(away));
    add_mesh(scene, bolts.build(steel));
    add_mesh(scene, nuts.build(brass));
    add_mesh(scene, pliers.build(steel));
    add_mesh(scene, grips.build(rubber));

    add_camera(scene, {0.06, 0.2, 0.28}, {0.005, 0.012, -0.005}, 0.74f);
    Camera& camera = scene.cameras.back();
    camera.aperture_radius_m = 0.003f;
    camera.focus_distance_m = glm::dot(vec3(0.06f, 0.01f, 0.03f) - camera.position, camera.forward);
    return scene;
}

}  // namespace photond
