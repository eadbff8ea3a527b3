// Scenes of the papers on progressive photon mapping, in small: all light that is to be seen comes through glass, and
// much of it is seen through glass or in mirrors as well.
//
// [Hachisuka, Ogaki and Jensen 2008] Progressive Photon Mapping. ACM TOG 27(5).

#include "renderer/scene/builtin_families.h"
#include "renderer/scene/builtin_furniture.h"

namespace photond {

namespace {

constexpr float kTwoPi = 2 * kPi;

/// Places what looks along its own +y at `position`, looking along `direction`.
mat4 looking(const vec3& position, const vec3& direction) {
    const Frame frame(glm::normalize(direction));
    return {vec4(frame.bitangent, 0), vec4(frame.normal, 0), vec4(frame.tangent, 0), vec4(position, 1)};
}

// ---- Lamp. The head looks along +y from its opening at y = 0.

constexpr float kShadeRadius = 0.075f, kShadeDepth = 0.085f, kBulbMiddle = -0.014f, kNeckEnd = -0.056f;

/// A bulb as of a desk lamp, its neck towards -y: glass about a hollow, both closed.
void add_bulb(MeshBuilder& glass) {
    constexpr float kBall = 0.03f, kNeck = 0.013f, kWall = 0.0015f;
    constexpr uint32_t kSteps = 28;
    const auto profile = [&](float inset) {
        // The ball from its top down to where the neck begins, then a straight neck; upwards.
        const float ball = kBall - inset, neck = kNeck - inset, end = kNeckEnd + inset;
        std::vector<vec2> points = {{0, end}, {0.8f * neck, end}, {neck, end + 0.2f * kNeck}};
        const float first = std::asin(neck / ball);
        for (uint32_t i = 0; i <= kSteps; ++i) {
            const float angle = first + (kPi - first) * static_cast<float>(i) / kSteps;
            points.emplace_back(i == kSteps ? 0.0f : ball * std::sin(angle), kBulbMiddle - ball * std::cos(angle));
        }
        return points;
    };
    std::vector<vec2> inside = profile(kWall);
    std::reverse(inside.begin(), inside.end());
    glass.lathe(profile(0), 64).lathe(inside, 64);
}

/// Enamel around the reflector, hollow and closed.
void add_shade(MeshBuilder& enamel) {
    constexpr uint32_t kSteps = 16;
    constexpr float kOuter = 0.0025f, kInner = 0.0008f;
    std::vector<vec2> profile;
    const auto add = [&](uint32_t i, float beyond) {
        const float t = static_cast<float>(i) / kSteps;
        profile.emplace_back((kShadeRadius + beyond) * t, (kShadeDepth + beyond) * (t * t - 1));
    };
    for (uint32_t i = 0; i <= kSteps; ++i) add(i, kOuter);
    for (uint32_t i = kSteps + 1; i-- > 0;) add(i, kInner);
    enamel.lathe(profile, 64);
}

void add_corner(Scene& scene) {
    constexpr float kLow = -0.45f, kHigh = 1.3f, kTop = 1.2f;
    add_mesh(scene, MeshBuilder()
                        .quad({kLow, 0, kHigh}, {kHigh, 0, kHigh}, {kHigh, 0, kLow}, {kLow, 0, kLow})
                        .build(add_material(scene, lambert("table", {0.55f, 0.42f, 0.3f}))));
    add_mesh(scene, MeshBuilder()
                        .quad({kLow, 0, kLow}, {kHigh, 0, kLow}, {kHigh, kTop, kLow}, {kLow, kTop, kLow})
                        .quad({kLow, 0, kHigh}, {kLow, 0, kLow}, {kLow, kTop, kLow}, {kLow, kTop, kHigh})
                        .build(add_material(scene, lambert("plaster", {0.75f, 0.72f, 0.66f}))));
}

}  // namespace

Scene make_progressive_lamp() {
    // A filament in a bulb in a polished reflector, turned to the corner of a room.
    Scene scene;
    add_corner(scene);
    const uint32_t steel = add_material(scene, metal("steel", Rgb(0.6f), 0.2f));
    const uint32_t silver = add_material(scene, metal("polished silver", {0.95f, 0.93f, 0.88f}, 0));
    const uint32_t enamel = add_material(scene, plastic("green enamel", {0.12f, 0.42f, 0.26f}, 0.3f));
    const uint32_t clear = add_material(scene, glass("bulb"));
    const uint32_t filament = add_material(scene, emitter("filament", Rgb(2400, 1900, 1250)));

    constexpr vec3 kHead{0.0f, 0.33f, -0.08f}, kAim{-0.62f, -0.42f, 0.38f}, kFoot{0.13f, 0, -0.2f};
    const mat4 head = looking(kHead, kAim);
    MeshBuilder stand, bulb, shade, reflector, holder, coil;
    for (MeshBuilder* part : {&bulb, &shade, &reflector, &holder, &coil}) part->place(head);
    add_bulb(bulb);
    add_shade(shade);
    furniture::add_reflector(reflector, kShadeRadius, kShadeDepth, 96);
    holder.cylinder({0, 0.003f - kShadeDepth, 0}, 0.014f, kNeckEnd + kShadeDepth - 0.0045f,
                    32);  // between the reflector and the bulb
    coil.torus({0, kBulbMiddle, 0}, 0.006f, 0.0012f, 32, 12);
    for (const float side : {-1.0f, 1.0f}) {  // the wires that hold it, polished and a little apart from it
        const vec3 wire[] = {{0.006f * side, kBulbMiddle - 0.0016f, 0}, {0.003f * side, kNeckEnd + 0.003f, 0}};
        reflector.pipe(wire, 0.0003f, 6);
    }

    const vec2 base[] = {{0, 0.0005f},    {0.085f, 0.0005f}, {0.088f, 0.004f}, {0.085f, 0.012f},
                         {0.02f, 0.022f}, {0.009f, 0.03f},   {0.009f, 0.05f},  {0, 0.05f}};
    stand.place(glm::translate(mat4(1), kFoot)).lathe(base, 64);
    const vec3 joint = vec3(head * vec4(0, -kShadeDepth - 0.012f, 0, 1));
    std::vector<vec3> neck;  // bends over from upright to the head
    constexpr uint32_t kSteps = 16;
    for (uint32_t i = 0; i <= kSteps; ++i) {
        const float t = static_cast<float>(i) / kSteps, s = t * t * t * t;
        neck.emplace_back(glm::mix(kFoot.x, joint.x, s), glm::mix(0.05f, joint.y, t), glm::mix(kFoot.z, joint.z, s));
    }
    stand.place(mat4(1)).pipe(neck, 0.006f, 16).sphere(joint, 0.014f, 24);

    add_mesh(scene, stand.build(steel));
    add_mesh(scene, bulb.build(clear));
    add_mesh(scene, shade.build(enamel));
    add_mesh(scene, reflector.build(silver));
    add_mesh(scene, holder.build(steel));
    add_mesh(scene, coil.build(filament));
    add_camera(scene, {0.1, 0.38, 0.85}, {-0.1, 0.19, -0.1}, 0.6f);
    return scene;
}

Scene make_progressive_box() {
    // A box of coloured walls whose only light is in a globe of thick, ringed glass.
    Scene scene;
    const uint32_t white = add_material(scene, lambert("white", {0.74f, 0.72f, 0.68f}));
    const uint32_t red = add_material(scene, lambert("red", {0.6f, 0.1f, 0.07f}));
    const uint32_t blue = add_material(scene, lambert("blue", {0.12f, 0.2f, 0.55f}));
    const uint32_t clear = add_material(scene, glass("glass"));
    const uint32_t mirror = add_material(scene, metal("mirror", Rgb(0.93f), 0));
    const uint32_t light = add_material(scene, emitter("light", Rgb(330, 290, 230)));

    constexpr float w = 1, h = 2;
    add_mesh(scene, MeshBuilder()
                        .quad({-w, 0, w}, {w, 0, w}, {w, 0, -w}, {-w, 0, -w})
                        .quad({-w, h, -w}, {w, h, -w}, {w, h, w}, {-w, h, w})
                        .quad({-w, 0, -w}, {w, 0, -w}, {w, h, -w}, {-w, h, -w})
                        .build(white));
    add_mesh(scene, MeshBuilder().quad({-w, 0, w}, {-w, 0, -w}, {-w, h, -w}, {-w, h, w}).build(red));
    add_mesh(scene, MeshBuilder().quad({w, 0, -w}, {w, 0, w}, {w, h, w}, {w, h, -w}).build(blue));

    constexpr vec3 kLamp{0, 1.68f, 0};
    constexpr float kGlobe = 0.14f;
    MeshBuilder globe;
    furniture::add_glass_globe(globe.place(glm::translate(mat4(1), kLamp)), kGlobe, 0.04f, 6, 0.05f);
    add_mesh(scene, globe.build(clear));
    add_mesh(scene, MeshBuilder().sphere(kLamp, 0.035f, 24).build(light));
    const float rod_low = kLamp.y + 1.05f * kGlobe + 0.004f;
    add_mesh(scene, MeshBuilder()
                        .cylinder({0, rod_low, 0}, 0.012f, h - 0.001f - rod_low, 24)
                        .build(add_material(scene, metal("brass", {0.91f, 0.78f, 0.42f}, 0.25f))));

    constexpr float kLift = 0.003f;  // so that no two surfaces touch
    add_mesh(scene, MeshBuilder().sphere({0.45f, 0.32f + kLift, 0.35f}, 0.32f, 64).build(clear));
    add_mesh(scene, MeshBuilder().sphere({-0.42f, 0.38f + kLift, -0.3f}, 0.38f, 48).build(mirror));
    add_camera(scene, {0, 1, 3.95}, {0, 1, 0}, 0.7f);
    return scene;
}

namespace {

constexpr vec3 kTorusLamp{-0.55f, 1.25f, -0.35f};

/// A torus cast into a block of glass that lies on a floor; without a light.
Scene make_torus_in_glass() {
    constexpr float kHalf = 0.1f, kLift = 0.001f;
    Scene scene;
    const uint32_t floor = add_material(scene, lambert("floor", {0.62f, 0.6f, 0.57f}));
    const uint32_t clay = add_material(scene, lambert("clay", {0.78f, 0.52f, 0.16f}));
    add_mesh(scene, MeshBuilder().quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}).build(floor));
    add_mesh(scene, MeshBuilder()
                        .box({-kHalf, kLift, -kHalf}, {kHalf, kLift + 2 * kHalf, kHalf})
                        .build(add_material(scene, glass("glass"))));
    const mat4 middle = glm::translate(mat4(1), vec3(0, kLift + kHalf, 0));
    MeshBuilder torus;
    torus.place(glm::rotate(glm::rotate(middle, 0.4f, vec3(0, 1, 0)), 0.85f, vec3(1, 0, 0)));
    add_mesh(scene, torus.torus(vec3(0), 0.055f, 0.023f, 96, 40).build(clay));
    add_camera(scene, {0.3, 0.46, 0.56}, {0.02, 0.07, 0}, 0.5f);
    return scene;
}

}  // namespace

Scene make_progressive_torus() {
    Scene scene = make_torus_in_glass();
    constexpr float kHalf = 0.15f;
    const vec3 s(kHalf, 0, 0), t(0, 0, kHalf);
    add_mesh(scene, MeshBuilder()
                        .quad(kTorusLamp - s + t, kTorusLamp - s - t, kTorusLamp + s - t, kTorusLamp + s + t)
                        .build(add_material(scene, emitter("lamp", Rgb(75, 70, 62)))));
    return scene;
}

Scene make_progressive_torus_spot() {
    // No path from the eye meets a light that is a point: what is within the glass stays dark to such methods.
    Scene scene = make_torus_in_glass();
    PunctualLight spot;
    spot.name = "spot";
    spot.kind = PunctualLight::Kind::Spot;
    spot.intensity = Rgb(6, 5.6f, 5);
    spot.position = kTorusLamp;
    spot.direction = glm::normalize(vec3(0, 0.1f, 0) - kTorusLamp);
    spot.cos_inner = std::cos(0.22f);
    spot.cos_outer = std::cos(0.3f);
    scene.punctual_lights.push_back(spot);
    return scene;
}

}  // namespace photond
