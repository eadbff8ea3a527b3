// A small tiled bathroom, seen for a good part in its mirror; the one light is in a globe of glass. After the bathroom
// of [Hachisuka, Ogaki and Jensen 2008] Progressive Photon Mapping. ACM TOG 27(5).

#include "renderer/scene/builtin_families.h"
#include "renderer/scene/builtin_furniture.h"

namespace photond {

namespace {

// The room's inside; the mirror hangs on the far wall, z = kFar.
constexpr float kHalfWidth = 1.1f, kNear = 1.4f, kFar = -1.2f, kHeight = 2.4f;
constexpr float kTile = 0.2f, kJoint = 0.006f;

/// Tiles with joints between them over the rectangle from `corner` along s and t (multiples of kTile long), seen from
/// where s, t and the normal are right-handed. `builder_of(column, row)` is what a tile goes into.
template <class BuilderOf>
void add_tiles(const vec3& corner, const vec3& s, const vec3& t, MeshBuilder& joints, const BuilderOf& builder_of) {
    const auto count = [](const vec3& side) { return static_cast<int>(std::lround(glm::length(side) / kTile)); };
    const int columns = count(s), rows = count(t);
    // Lines i of the grid: tile k lies between 2 k and 2 k + 1, a joint beyond it.
    const auto line = [](int i, int tiles) {
        const int tile = i / 2;
        const float at = static_cast<float>(tile) * kTile + (i % 2 ? kTile - kJoint : 0);
        return at / (static_cast<float>(tiles) * kTile);
    };
    for (int j = 0; j < 2 * rows; ++j)
        for (int i = 0; i < 2 * columns; ++i) {
            const auto at = [&](int di, int dj) { return corner + line(i + di, columns) * s + line(j + dj, rows) * t; };
            MeshBuilder& builder = i % 2 || j % 2 ? joints : builder_of(i / 2, j / 2);
            builder.quad(at(0, 0), at(1, 0), at(1, 1), at(0, 1));
        }
}

void add_room(Scene& scene) {
    MeshBuilder joints, white, green, band, light_floor, dark_floor, ceiling;
    constexpr float w = kHalfWidth, h = kHeight, depth = kNear - kFar;
    const auto on_wall = [&](int, int row) -> MeshBuilder& { return row == 5 ? band : row < 5 ? green : white; };
    add_tiles({-w, 0, kFar}, {2 * w, 0, 0}, {0, h, 0}, joints, on_wall);
    add_tiles({w, 0, kNear}, {-2 * w, 0, 0}, {0, h, 0}, joints, on_wall);
    add_tiles({-w, 0, kNear}, {0, 0, -depth}, {0, h, 0}, joints, on_wall);
    add_tiles({w, 0, kFar}, {0, 0, depth}, {0, h, 0}, joints, on_wall);
    add_tiles({-w, 0, kNear}, {2 * w, 0, 0}, {0, 0, -depth}, joints,
              [&](int column, int row) -> MeshBuilder& { return (column + row) % 2 ? dark_floor : light_floor; });
    ceiling.quad({-w, h, kFar}, {w, h, kFar}, {w, h, kNear}, {-w, h, kNear});
    add_mesh(scene, joints.build(add_material(scene, lambert("joints", Rgb(0.45f)))));
    add_mesh(scene, white.build(add_material(scene, plastic("white tiles", {0.78f, 0.79f, 0.76f}, 0.25f))));
    add_mesh(scene, green.build(add_material(scene, plastic("green tiles", {0.38f, 0.58f, 0.52f}, 0.25f))));
    add_mesh(scene, band.build(add_material(scene, plastic("blue tiles", {0.12f, 0.28f, 0.5f}, 0.25f))));
    add_mesh(scene, light_floor.build(add_material(scene, lambert("light floor tiles", {0.6f, 0.57f, 0.5f}))));
    add_mesh(scene, dark_floor.build(add_material(scene, lambert("dark floor tiles", {0.16f, 0.17f, 0.2f}))));
    add_mesh(scene, ceiling.build(add_material(scene, lambert("ceiling", Rgb(0.8f)))));
}

/// The mirror, a shelf below it with a tumbler and a bottle, and the light above it.
void add_mirror_and_light(Scene& scene, uint32_t steel, uint32_t ceramic) {
    constexpr float kPane = kFar + 0.02f, kLow = 1.03f, kHigh = 1.88f, kHalf = 0.55f, kRim = 0.025f;
    add_mesh(scene, MeshBuilder()
                        .rounded_box({-kHalf - kRim, kLow - kRim, kFar + 0.001f},
                                     {kHalf + kRim, kHigh + kRim, kPane - 0.002f}, 0.006f, 3)
                        .build(add_material(scene, lambert("mirror frame", {0.35f, 0.2f, 0.1f}))));
    add_mesh(scene,
             MeshBuilder()
                 .quad({-kHalf, kLow, kPane}, {kHalf, kLow, kPane}, {kHalf, kHigh, kPane}, {-kHalf, kHigh, kPane})
                 .build(add_material(scene, metal("mirror", Rgb(0.93f), 0))));

    constexpr float kShelf = 0.98f;
    add_mesh(scene, MeshBuilder()
                        .rounded_box({-0.45f, kShelf - 0.02f, kFar + 0.001f}, {0.45f, kShelf, kFar + 0.13f}, 0.006f, 3)
                        .build(ceramic));
    MeshBuilder tumbler, bottle;
    const uint32_t clear = add_material(scene, glass("glass"));
    furniture::add_tumbler(tumbler.place(glm::translate(mat4(1), vec3(0.3f, kShelf + 0.001f, kFar + 0.07f))));
    add_mesh(scene, tumbler.build(clear));
    const vec2 profile[] = {{0, 0},           {0.028f, 0},      {0.03f, 0.004f},  {0.03f, 0.1f}, {0.024f, 0.118f},
                            {0.011f, 0.128f}, {0.011f, 0.155f}, {0.009f, 0.157f}, {0, 0.157f}};
    bottle.place(glm::translate(mat4(1), vec3(-0.33f, kShelf + 0.001f, kFar + 0.07f))).lathe(profile, 48);
    add_mesh(scene, bottle.build(add_material(scene, plastic("bottle", {0.65f, 0.2f, 0.08f}, 0.2f))));

    constexpr vec3 kLight{0, 2.1f, kFar + 0.16f};
    MeshBuilder globe, bracket;
    furniture::add_glass_globe(globe.place(glm::translate(mat4(1), kLight)), 0.075f, 0.015f, 3, 0.04f);
    add_mesh(scene, globe.build(clear));
    add_mesh(scene,
             MeshBuilder().sphere(kLight, 0.022f, 16).build(add_material(scene, emitter("light", Rgb(800, 720, 590)))));
    // From the wall below the globe and up to it; ends just short of the glass.
    const vec3 arm[] = {{0, 1.96f, kFar + 0.001f},  {0, 1.96f, kFar + 0.09f}, {0, 1.963f, kFar + 0.13f},
                        {0, 1.975f, kFar + 0.152f}, {0, 1.99f, kLight.z},     {0, 2.015f, kLight.z}};
    bracket.pipe(arm, 0.009f, 16).cylinder({0, 2.006f, kLight.z}, 0.03f, 0.006f, 32);
    add_mesh(scene, bracket.build(steel));
}

void add_basin(Scene& scene, uint32_t chrome, uint32_t ceramic) {
    constexpr float kZ = kFar + 0.27f, kRim = 0.82f, kRadius = 0.25f, kWall = 0.018f, kDeep = 0.19f;
    constexpr uint32_t kSteps = 11;
    // A foot that goes over into the bowl; outside upwards, inside back down.
    std::vector<vec2> profile = {{0, 0.001f}, {0.13f, 0.001f}, {0.12f, 0.04f}, {0.085f, 0.12f}, {0.075f, 0.4f}};
    const auto bowl = [&](float radius, float depth, uint32_t i) {
        const float angle = 0.5f * kPi * static_cast<float>(i) / kSteps;
        return vec2(i == 0 ? 0.0f : radius * std::sin(angle), kRim - depth * std::cos(angle));
    };
    for (uint32_t i = 4; i <= kSteps; ++i) profile.push_back(bowl(kRadius, kDeep + 0.03f, i));
    for (uint32_t i = kSteps + 1; i-- > 0;) profile.push_back(bowl(kRadius - kWall, kDeep, i));
    MeshBuilder basin;
    basin.place(glm::translate(mat4(1), vec3(0, 0, kZ))).lathe(profile, 48);
    add_mesh(scene, basin.build(ceramic));

    std::vector<vec3> spout = {{0, 0.91f, kFar + 0.001f}, {0, 0.91f, kFar + 0.12f}};
    for (uint32_t i = 1; i <= 8; ++i) {
        const float angle = 0.5f * kPi * static_cast<float>(i) / 8;
        spout.emplace_back(0, 0.88f + 0.03f * std::cos(angle), kFar + 0.12f + 0.03f * std::sin(angle));
    }
    MeshBuilder tap;
    tap.pipe(spout, 0.011f, 16);
    for (const float x : {-0.09f, 0.09f}) {
        const vec3 stem[] = {{x, 0.91f, kFar + 0.001f}, {x, 0.91f, kFar + 0.04f}};
        tap.pipe(stem, 0.008f, 12).sphere({x, 0.91f, kFar + 0.055f}, 0.02f, 16);
    }
    add_mesh(scene, tap.build(chrome));
}

/// What stands and hangs elsewhere, a good part of it seen in the mirror only.
void add_rest(Scene& scene, uint32_t steel, uint32_t ceramic) {
    // A towel over its rail on the right wall.
    constexpr float kRailX = kHalfWidth - 0.07f, kRailY = 1.35f, kZ0 = -0.85f, kZ1 = -0.2f;
    const vec3 rail[] = {{kRailX, kRailY, kZ0 - 0.05f}, {kRailX, kRailY, kZ1 + 0.05f}};
    add_mesh(scene, MeshBuilder().pipe(rail, 0.009f, 12).build(steel));
    constexpr uint32_t kColumns = 25, kRows = 13;
    std::vector<vec3> cloth;
    for (uint32_t r = 0; r < kRows; ++r)
        for (uint32_t c = 0; c < kColumns; ++c) {
            const float u = static_cast<float>(c) / (kColumns - 1), v = static_cast<float>(r) / (kRows - 1);
            const float fold = 0.012f * (1 - v) * std::sin(19 * u);
            cloth.emplace_back(kRailX - 0.012f - fold - 0.012f * (1 - v), kRailY + 0.012f - 0.65f * (1 - v),
                               glm::mix(kZ0, kZ1, u));
        }
    add_mesh(scene,
             MeshBuilder().grid(cloth, kColumns).build(add_material(scene, lambert("towel", {0.7f, 0.3f, 0.12f}))));

    // A tub along the left wall.
    constexpr float kX0 = -kHalfWidth + 0.005f, kX1 = kX0 + 0.72f, kTubZ0 = -0.15f, kTubZ1 = kNear - 0.005f;
    constexpr float kWall = 0.07f, kTop = 0.58f, kRound = 0.02f;
    MeshBuilder tub;
    tub.rounded_box({kX0, 0.002f, kTubZ0}, {kX0 + kWall, kTop, kTubZ1}, kRound, 2);
    tub.rounded_box({kX1 - kWall, 0.002f, kTubZ0}, {kX1, kTop, kTubZ1}, kRound, 2);
    tub.rounded_box({kX0, 0.002f, kTubZ0}, {kX1, kTop, kTubZ0 + kWall}, kRound, 2);
    tub.rounded_box({kX0, 0.002f, kTubZ1 - kWall}, {kX1, kTop, kTubZ1}, kRound, 2);
    tub.box({kX0 + kWall / 2, 0.1f, kTubZ0 + kWall / 2}, {kX1 - kWall / 2, 0.15f, kTubZ1 - kWall / 2});
    add_mesh(scene, tub.build(ceramic));

    // Its curtain, drawn to the far half.
    constexpr float kRod = 2.0f, kCurtain0 = 0.2f, kCurtain1 = kNear - 0.03f;
    const vec3 rod[] = {{kX1, kRod, kTubZ0}, {kX1, kRod, kTubZ1}};
    add_mesh(scene, MeshBuilder().pipe(rod, 0.011f, 12).build(steel));
    constexpr uint32_t kAcross = 81, kDown = 5;
    std::vector<vec3> folds;
    for (uint32_t r = 0; r < kDown; ++r)
        for (uint32_t c = 0; c < kAcross; ++c) {
            const float u = static_cast<float>(c) / (kAcross - 1), v = static_cast<float>(r) / (kDown - 1);
            folds.emplace_back(kX1 + 0.04f * (1 - 0.4f * v) * std::sin(9 * 2 * kPi * u), 0.3f + (kRod - 0.32f) * v,
                               glm::mix(kCurtain1, kCurtain0, u));
        }
    add_mesh(scene,
             MeshBuilder().grid(folds, kAcross).build(add_material(scene, lambert("curtain", {0.75f, 0.62f, 0.25f}))));

    // The door, behind the camera, with its frame and handle.
    constexpr float kDoor = kNear - 0.03f;
    add_mesh(scene, MeshBuilder()
                        .rounded_box({-0.2f, 0.003f, kDoor}, {0.6f, 2.0f, kNear - 0.001f}, 0.006f, 2)
                        .build(add_material(scene, lambert("door", {0.3f, 0.42f, 0.36f}))));
    MeshBuilder frame;
    for (const float x : {-0.29f, 0.605f}) frame.box({x, 0.003f, kDoor - 0.01f}, {x + 0.085f, 2.005f, kNear - 0.001f});
    frame.box({-0.29f, 2.005f, kDoor - 0.01f}, {0.69f, 2.09f, kNear - 0.001f});
    add_mesh(scene, frame.build(add_material(scene, lambert("door frame", Rgb(0.7f)))));
    add_mesh(scene, MeshBuilder().sphere({-0.13f, 1.0f, kDoor - 0.045f}, 0.028f, 16).build(steel));
}

}  // namespace

Scene make_progressive_mirror_bathroom() {
    Scene scene;
    const uint32_t steel = add_material(scene, metal("brushed steel", Rgb(0.6f), 0.3f));
    const uint32_t chrome = add_material(scene, metal("chrome", Rgb(0.8f), 0));
    const uint32_t ceramic = add_material(scene, plastic("ceramic", {0.8f, 0.8f, 0.78f}, 0.2f));
    add_room(scene);
    add_mirror_and_light(scene, steel, ceramic);
    add_basin(scene, chrome, ceramic);
    add_rest(scene, steel, ceramic);
    add_camera(scene, {0.5, 1.62, 1.0}, {-0.02, 1.3, -1.2}, 0.82f);
    return scene;
}

}  // namespace photond
