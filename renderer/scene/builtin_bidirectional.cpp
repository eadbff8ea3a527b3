// Scenes that methods which join paths from the eye and from the lights are measured on: the box of SmallVCM, and a
// room lit through a gap.
//
// [Georgiev et al. 2012] Light Transport Simulation with Vertex Connection and Merging. ACM TOG 31(6). The box is that
// of the public program beside it, SmallVCM, in its own numbers (z up there; here y is). Its floor is Phong, exponent
// 90; here it is GGX of alpha 0.147, which fits that lobe best at 60 degrees, where the camera sees the floor. So
// images are like those of SmallVCM, and not the same. [Veach and Guibas 1997] Metropolis Light Transport. SIGGRAPH:
// the door that stands ajar.

#include "renderer/scene/builtin_families.h"
#include "renderer/scene/builtin_furniture.h"

namespace photond {

namespace {

// ---- SmallVCM's box, open towards the camera at +z.

constexpr float kLeft = -1.27029f, kRight = 1.28975f, kBottom = -1.28002f, kTop = 1.28002f, kBack = -1.30455f,
                kFront = 1.25549f;

/// 0.1 of diffuse reflectance under a lobe that reflects 0.7 at all angles.
Material glossy_floor() {
    constexpr float kAlpha = 0.147f;
    Material floor = lambert("glossy floor", Rgb(0.1f / 0.3f));
    floor.specular = 0.7f;
    floor.ior = 0;  // the whole of `specular`, at normal incidence too
    floor.roughness = std::sqrt(kAlpha);
    return floor;
}

Scene small_vcm_box() {
    Scene scene;
    const vec3 lower{kLeft, kBottom, kBack}, upper{kRight, kTop, kFront};
    const auto wall = [&](Material material, const vec3& a, const vec3& b, const vec3& c, const vec3& d) {
        add_mesh(scene, MeshBuilder().quad(a, b, c, d).build(add_material(scene, std::move(material))));
    };
    const vec3 &l = lower, &u = upper;
    wall(glossy_floor(), {l.x, l.y, u.z}, {u.x, l.y, u.z}, {u.x, l.y, l.z}, {l.x, l.y, l.z});
    wall(lambert("blue", {0.156863f, 0.172549f, 0.803922f}), {l.x, l.y, l.z}, {u.x, l.y, l.z}, {u.x, u.y, l.z},
         {l.x, u.y, l.z});
    wall(lambert("green", {0.156863f, 0.803922f, 0.172549f}), {l.x, l.y, u.z}, {l.x, l.y, l.z}, {l.x, u.y, l.z},
         {l.x, u.y, u.z});
    wall(lambert("red", {0.803922f, 0.152941f, 0.152941f}), {u.x, l.y, l.z}, {u.x, l.y, u.z}, {u.x, u.y, u.z},
         {u.x, u.y, l.z});
    wall(lambert("white", Rgb(0.803922f)), {l.x, u.y, l.z}, {u.x, u.y, l.z}, {u.x, u.y, u.z}, {l.x, u.y, u.z});

    const dvec3 eye(-0.0439815, 0.222539, 4.12529), forward(0.00688625, -0.0542161, -0.998505);
    Camera camera = look_at_camera(eye, eye + forward, {3.73896e-4, 0.998529, -0.0542148}, kPi / 4);
    camera.name = "camera";
    scene.cameras.push_back(std::move(camera));
    return scene;
}

void add_ball(Scene& scene, const vec3& centre, float radius, Material material) {
    constexpr uint32_t kSlices = 192;  // the source's balls are exact
    add_mesh(scene, MeshBuilder().sphere(centre, radius, kSlices).build(add_material(scene, std::move(material))));
}

/// A mirror on the left and glass on the right.
void add_small_balls(Scene& scene) {
    add_ball(scene, {-0.53885f, -0.78002f, -0.02453f}, 0.5f, metal("mirror", Rgb(1), 0));
    Material clear = glass("glass");
    clear.ior = 1.6f;
    add_ball(scene, {0.55831f, -0.78002f, -0.02453f}, 0.5f, std::move(clear));
}

/// The flat box that hangs from the ceiling; its lower side is the lamp, or white.
void add_light_box(Scene& scene, bool shines) {
    constexpr float kHalf = 0.25f, kLow = 1.26002f;
    const uint32_t white = add_material(scene, lambert("light box", Rgb(0.803922f)));
    MeshBuilder sides, face;
    const vec3 corners[] = {{-kHalf, 0, kHalf}, {kHalf, 0, kHalf}, {kHalf, 0, -kHalf}, {-kHalf, 0, -kHalf}};
    const auto at = [&](int i, float y) { return vec3(corners[i % 4].x, y, corners[i % 4].z); };
    for (int i = 0; i < 4; ++i) sides.quad(at(i, kLow), at(i + 1, kLow), at(i + 1, kTop), at(i, kTop));
    face.quad(at(0, kLow), at(3, kLow), at(2, kLow), at(1, kLow));
    add_mesh(scene, sides.build(white));
    add_mesh(scene, face.build(shines ? add_material(scene, emitter("lamp", Rgb(25.03329895614464f))) : white));
}

}  // namespace

/// SmallVCM's scene 0: glass and mirror balls under the sun, whose light delta scatterings alone bring to some places.
Scene make_small_vcm_sun() {
    Scene scene = small_vcm_box();
    add_small_balls(scene);
    add_light_box(scene, false);
    PunctualLight sun;
    sun.name = "sun";
    sun.kind = PunctualLight::Kind::Directional;
    sun.intensity = {10, 4, 0};
    sun.direction = glm::normalize(vec3(-1, -1, -1.5f));
    scene.punctual_lights.push_back(sun);
    return scene;
}

/// Its scene 1: a large mirror ball under the lamp on the ceiling.
Scene make_small_vcm_ceiling() {
    Scene scene = small_vcm_box();
    add_ball(scene, {0.00973f, -0.48002f, -0.02453f}, 0.8f, metal("mirror", Rgb(1), 0));
    add_light_box(scene, true);
    return scene;
}

/// Its scene 2: glass and mirror balls under a point.
Scene make_small_vcm_point() {
    Scene scene = small_vcm_box();
    add_small_balls(scene);
    PunctualLight point;
    point.name = "point";
    point.intensity = Rgb(70 / (4 * kPi));
    point.position = {0, 1, 0.5f};
    scene.punctual_lights.push_back(point);
    return scene;
}

/// Its scene 3: glass and mirror balls under an even sky.
Scene make_small_vcm_sky() {
    Scene scene = small_vcm_box();
    add_small_balls(scene);
    add_light_box(scene, false);
    Environment sky;
    sky.map = {{2, 1}, {2, Rgb(135, 206, 250) / 255.0f}};
    scene.environment = std::move(sky);
    return scene;
}

/// A closed room with a table; its door stands ajar, and behind that a passage is lit by a lamp that turns away from
/// it.
Scene make_ajar_door() {
    constexpr float kHalf = 2, kHeight = 2.6f, kNear = 2.6f, kFar = -1.6f, kThick = 0.1f, kPassage = -3.2f;
    constexpr float kHinge = 1.5f, kOpening = 0.6f, kDoorHeight = 2.05f, kAjar = 0.3f;  // [m], [rad]
    Scene scene;
    const uint32_t plaster = add_material(scene, lambert("plaster", {0.76f, 0.74f, 0.7f}));
    const uint32_t boards = add_material(scene, lambert("boards", {0.48f, 0.34f, 0.22f}));
    const uint32_t paint = add_material(scene, lambert("door", {0.3f, 0.36f, 0.4f}));
    const uint32_t wood = add_material(scene, plastic("table", {0.42f, 0.26f, 0.14f}, 0.3f));

    // The room and the passage: floor, ceiling and side walls of each, and what closes them at their far ends.
    MeshBuilder walls, floors;
    for (const auto& [front, back] : {std::pair{kNear, kFar}, std::pair{kFar - kThick, kPassage}}) {
        floors.quad({-kHalf, 0, front}, {kHalf, 0, front}, {kHalf, 0, back}, {-kHalf, 0, back});
        walls.quad({-kHalf, kHeight, back}, {kHalf, kHeight, back}, {kHalf, kHeight, front}, {-kHalf, kHeight, front});
        walls.quad({-kHalf, 0, front}, {-kHalf, 0, back}, {-kHalf, kHeight, back}, {-kHalf, kHeight, front});
        walls.quad({kHalf, 0, back}, {kHalf, 0, front}, {kHalf, kHeight, front}, {kHalf, kHeight, back});
    }
    walls.quad({-kHalf, 0, kPassage}, {kHalf, 0, kPassage}, {kHalf, kHeight, kPassage}, {-kHalf, kHeight, kPassage});
    walls.quad({kHalf, 0, kNear}, {-kHalf, 0, kNear}, {-kHalf, kHeight, kNear}, {kHalf, kHeight, kNear});
    // The wall between, with its doorway.
    walls.box({-kHalf, 0, kFar - kThick}, {kOpening, kHeight, kFar});
    walls.box({kHinge, 0, kFar - kThick}, {kHalf, kHeight, kFar});
    walls.box({kOpening, kDoorHeight, kFar - kThick}, {kHinge, kHeight, kFar});
    floors.quad({kOpening, 0, kFar}, {kHinge, 0, kFar}, {kHinge, 0, kFar - kThick}, {kOpening, 0, kFar - kThick});

    MeshBuilder door;
    door.place(glm::rotate(glm::translate(mat4(1), vec3(kHinge, 0, kFar)), kAjar, vec3(0, 1, 0)));
    door.box({kOpening - kHinge + 0.005f, 0.005f, -0.04f}, {-0.005f, kDoorHeight - 0.005f, 0});

    MeshBuilder table;
    furniture::add_table(table, 1.4f, 0.8f, 0.72f);
    add_mesh(scene, floors.build(boards));
    add_mesh(scene, walls.build(plaster));
    add_mesh(scene, door.build(paint));
    add_mesh(scene, table.build(wood));
    const auto ball = [&](float x, float z, float radius, uint32_t material) {
        add_mesh(scene, MeshBuilder().sphere({x, 0.721f + radius, z}, radius, 96).build(material));
    };
    ball(-0.45f, 0.05f, 0.16f, add_material(scene, glass("glass")));
    ball(0, -0.1f, 0.18f, add_material(scene, metal("brushed metal", {0.9f, 0.75f, 0.5f}, 0.35f)));
    ball(0.45f, 0.08f, 0.15f, add_material(scene, lambert("clay", {0.7f, 0.3f, 0.2f})));

    // A shade open upwards: the lamp is seen from the ceiling of the passage alone.
    MeshBuilder shade, bulb;
    const vec2 profile[] = {{0, 1.4f}, {0.16f, 1.4f}, {0.2f, 1.62f}, {0.19f, 1.62f}, {0.15f, 1.41f}, {0, 1.41f}};
    shade.place(glm::translate(mat4(1), vec3(-1, 0, -2.4f))).lathe(profile, 48);
    bulb.place(glm::translate(mat4(1), vec3(-1, 0, -2.4f)));
    bulb.quad({-0.1f, 1.42f, 0.1f}, {0.1f, 1.42f, 0.1f}, {0.1f, 1.42f, -0.1f}, {-0.1f, 1.42f, -0.1f});
    add_mesh(scene, shade.build(paint));
    add_mesh(scene, bulb.build(add_material(scene, emitter("lamp", Rgb(9000, 7800, 6200)))));
    add_camera(scene, {-0.5, 1.55, 2.45}, {0.15, 0.95, -0.6}, 0.85f);
    return scene;
}

}  // namespace photond
