// Scenes that move, each by one animation: a Cornell box in which everything does, and the hard cases of motion.

#include "renderer/scene/builtin_cornell.h"
#include "renderer/scene/builtin_families.h"
#include "renderer/scene/mesh_builder.h"
#include "renderer/scene/rig_builder.h"

namespace photond {

namespace {

std::shared_ptr<const ObjectMesh> rigid(Mesh mesh) {
    auto object = std::make_shared<ObjectMesh>();
    object->mesh = std::move(mesh);
    return object;
}

RigNode node_at(const dvec3& translation, int32_t parent = -1) {
    RigNode node;
    node.translation = translation;
    node.parent = parent;
    return node;
}

/// A node with the camera of the measured box, which the scene's own list follows.
uint32_t add_camera_node(Scene& scene, Rig& rig) {
    Camera camera = scene.cameras.front();
    RigNode node = node_at(dvec3(camera.position));
    node.name = camera.name;
    node.camera = static_cast<int32_t>(rig.cameras.size());
    rig.cameras.push_back(std::move(camera));
    return add_node(rig, std::move(node));
}

void adopt(Scene& scene, Rig&& rig, Animation&& animation) {
    rig.animations.push_back(std::move(animation));
    adopt_rig(scene, std::make_shared<const Rig>(std::move(rig)));
}

/// Turns about its own middle, once in `seconds`.
void add_turning_block(Scene& scene, Rig& rig, Animation& animation, float seconds) {
    const dvec3 middle(0.925, 0, -1.69);
    Mesh block = make_cornell_short_block(0);
    for (vec3& p : block.positions) p -= vec3(middle);
    const uint32_t node = add_node(rig, node_at(middle));
    add_rigged_mesh(scene, rig, rigid(std::move(block)), node);
    const auto turned = [](double turns) { return turn_about({0, 1, 0}, turns * 2 * double{kPi}); };
    animation.channels.push_back(drive(Property::Rotation, node,
                                       {0, seconds / 4, seconds / 2, seconds * 3 / 4, seconds},
                                       keys_of({turned(0), turned(0.25), turned(0.5), turned(0.75), turned(1)})));
}

/// A square lamp below a shade, on a rod that hangs from the ceiling at the node which this gives.
uint32_t add_lamp(Scene& scene, Rig& rig) {
    constexpr float kRod = 1, kHalf = 0.525f, kShade = 0.06f;
    const uint32_t node = add_node(rig, node_at({0, 5.488, -2.795}));
    const uint32_t lamp = add_material(scene, emitter("lamp", kCornellLightRadiance * 1.2f));
    const uint32_t shade = add_material(scene, lambert("shade", Rgb(0.3f)));
    MeshBuilder holder;
    holder.box({-kHalf - 0.03f, -kRod, -kHalf - 0.03f}, {kHalf + 0.03f, -kRod + kShade, kHalf + 0.03f});
    holder.box({-0.015f, -kRod + kShade, -0.015f}, {0.015f, -0.001f, 0.015f});
    add_rigged_mesh(scene, rig, rigid(holder.build(shade)), node);
    const float y = -kRod - 0.002f;
    add_rigged_mesh(scene, rig,
                    rigid(MeshBuilder()
                              .quad({-kHalf, y, kHalf}, {-kHalf, y, -kHalf}, {kHalf, y, -kHalf}, {kHalf, y, kHalf})
                              .build(lamp)),
                    node);
    return node;
}

/// To both sides, once in `seconds`.
void swing(Animation& animation, uint32_t lamp, float seconds) {
    const auto swung = [](double angle) { return turn_about({0, 0, 1}, angle); };
    animation.channels.push_back(drive(Property::Rotation, lamp,
                                       {0, seconds / 4, seconds / 2, seconds * 3 / 4, seconds},
                                       keys_of({swung(0), swung(0.5), swung(0), swung(-0.5), swung(0)})));
}

/// A round figure with three joints one above the other, that bows.
void add_bending_figure(Scene& scene, Rig& rig, Animation& animation, float seconds) {
    constexpr float kHeights[] = {0, 0.9f, 1.6f};  // of the joints
    const vec2 profile[] = {{0.02f, 0.002f}, {0.42f, 0.002f}, {0.36f, 0.25f}, {0.28f, 0.55f}, {0.24f, 0.85f},
                            {0.27f, 1.05f},  {0.33f, 1.3f},   {0.30f, 1.5f},  {0.13f, 1.62f}, {0.12f, 1.72f},
                            {0.24f, 1.85f},  {0.27f, 2.0f},   {0.22f, 2.18f}, {0.1f, 2.27f},  {0.01f, 2.29f}};
    std::vector<vec2> fine;  // so that bends are round
    for (size_t i = 0; i + 1 < std::size(profile); ++i)
        for (int k = 0; k < 4; ++k) fine.push_back(glm::mix(profile[i], profile[i + 1], static_cast<float>(k) / 4));
    fine.push_back(profile[std::size(profile) - 1]);
    auto object = std::make_shared<ObjectMesh>();
    object->mesh = MeshBuilder().lathe(fine, 48, 1).build(add_material(scene, lambert("figure", {0.5f, 0.45f, 0.6f})));
    object->joint_sets = 1;
    for (const vec3& p : object->mesh.positions) {
        // The share of each joint changes over a hand's breadth about the next one.
        const auto above = [&](float height) { return glm::smoothstep(height - 0.25f, height + 0.25f, p.y); };
        const float second = above(kHeights[1]), third = above(kHeights[2]);
        object->influences.push_back({0, 1 - second});
        object->influences.push_back({1, second * (1 - third)});
        object->influences.push_back({2, second * third});
        object->influences.push_back({0, 0});
    }
    RigSkin skin;
    const dvec3 foot(-1.5, 0, -1.3);
    for (int joint = 0; joint < 3; ++joint) {
        const double below = joint == 0 ? 0 : double{kHeights[joint - 1]};
        const dvec3 from_parent = joint == 0 ? foot : dvec3(0, double{kHeights[joint]} - below, 0);
        const int32_t parent = joint == 0 ? -1 : static_cast<int32_t>(skin.joints.back());
        skin.joints.push_back(add_node(rig, node_at(from_parent, parent)));
        dmat4 inverse_bind(1);
        inverse_bind[3] = {0, -double{kHeights[joint]}, 0, 1};
        skin.inverse_bind.push_back(inverse_bind);
    }
    const uint32_t waist = skin.joints[1], neck = skin.joints[2];
    rig.skins.push_back(std::move(skin));
    add_rigged_mesh(scene, rig, std::move(object), add_node(rig, {}), 0);
    const auto bowed = [](double angle) { return turn_about(glm::normalize(dvec3(1, 0, -0.6)), angle); };
    for (const auto& [joint, angle] : {std::pair{waist, 0.8}, std::pair{neck, 0.5}})
        animation.channels.push_back(drive(Property::Rotation, joint, {0, seconds / 4, seconds / 2, seconds},
                                           keys_of({bowed(0), bowed(angle), bowed(-0.3 * angle), bowed(0)})));
}

constexpr float kSeconds = 4;

}  // namespace

Scene make_moving_cornell_box() {
    Scene scene = make_cornell_room();
    Rig rig;
    Animation animation{.name = "everything", .channels = {}};
    add_cornell_tall_block(scene, 0);
    add_turning_block(scene, rig, animation, kSeconds);
    swing(animation, add_lamp(scene, rig), kSeconds);
    add_bending_figure(scene, rig, animation, kSeconds);
    const uint32_t camera = add_camera_node(scene, rig);
    // To the right and nearer, and back, smoothly.
    animation.channels.push_back(drive(Property::Translation, camera, {0, kSeconds / 2, kSeconds},
                                       {0,     0, 0, -0.6f, 2.73f, 8,    0.6f, 0, 0,  //
                                        0,     0, 0, 0.6f,  2.5f,  7.2f, 0,    0, 0,  //
                                        -0.6f, 0, 0, -0.6f, 2.73f, 8,    0,    0, 0},
                                       Interpolation::CubicSpline));
    animation.channels.push_back(
        drive(Property::Rotation, camera, {0, kSeconds / 2, kSeconds},
              keys_of({turn_about({0, 1, 0}, -0.05), turn_about({0, 1, 0}, 0.05), turn_about({0, 1, 0}, -0.05)})));
    adopt(scene, std::move(rig), std::move(animation));
    return scene;
}

// A sheet of a millimetre crosses the room, with its edge to the camera: what a structure kept of the frame before
// would leave its shadow behind.
Scene make_moving_thin_object() {
    Scene scene = make_cornell_room();
    Rig rig;
    Animation animation{.name = "passing", .channels = {}};
    add_lamp(scene, rig);
    const uint32_t node = add_node(rig, node_at({-2.2, 0, -2.8}));
    const uint32_t sheet = add_material(scene, lambert("sheet", Rgb(0.5f)));
    add_rigged_mesh(scene, rig, rigid(MeshBuilder().box({-0.0005f, 0.3f, -1.5f}, {0.0005f, 3, 1.5f}).build(sheet)),
                    node);
    animation.channels.push_back(drive(Property::Translation, node, {0, 1}, {-2.2f, 0, -2.8f, 2.2f, 0, -2.8f}));
    add_camera_node(scene, rig);
    adopt(scene, std::move(rig), std::move(animation));
    return scene;
}

// A block jumps from one side of the room to the other.
Scene make_moving_teleport() {
    Scene scene = make_cornell_room();
    Rig rig;
    Animation animation{.name = "jump", .channels = {}};
    add_lamp(scene, rig);
    const uint32_t node = add_node(rig, node_at({-1.6, 0, -2}));
    add_rigged_mesh(scene, rig, rigid(MeshBuilder().box({-0.8f, 0.001f, -0.8f}, {0.8f, 1.6f, 0.8f}).build(0)), node);
    animation.channels.push_back(drive(Property::Translation, node, {0, 0.5f, 1},
                                       {-1.6f, 0, -2, 1.6f, 0, -3.4f, 1.6f, 0, -3.4f}, Interpolation::Step));
    add_camera_node(scene, rig);
    adopt(scene, std::move(rig), std::move(animation));
    return scene;
}

// A block is not there before half a second: it is scaled to nothing.
Scene make_moving_appearing() {
    Scene scene = make_cornell_room();
    Rig rig;
    Animation animation{.name = "appear", .channels = {}};
    add_lamp(scene, rig);
    const uint32_t node = add_node(rig, node_at({0, 0, -2.4}));
    add_rigged_mesh(scene, rig, rigid(MeshBuilder().box({-0.9f, 0.001f, -0.9f}, {0.9f, 2.4f, 0.9f}).build(0)), node);
    animation.channels.push_back(
        drive(Property::Scale, node, {0, 0.5f, 1}, {0, 0, 0, 1, 1, 1, 1, 1, 1}, Interpolation::Step));
    add_camera_node(scene, rig);
    adopt(scene, std::move(rig), std::move(animation));
    return scene;
}

namespace {

/// A room whose lamp has these strengths before and after half a second.
Scene make_switched(Scene scene, float before, float after) {
    Rig rig;
    Animation animation{.name = "switch", .channels = {}};
    add_lamp(scene, rig);
    add_cornell_tall_block(scene, 0);
    RiggedMaterial lamp;
    lamp.material = static_cast<uint32_t>(scene.materials.size()) - 2;  // the shade's comes after it
    lamp.rest = scene.materials[lamp.material];
    lamp.emissive_factor = dvec3(lamp.rest.emission);
    rig.materials.push_back(std::move(lamp));
    animation.channels.push_back(
        drive(Property::EmissiveStrength, 0, {0, 0.5f, 1}, {before, after, after}, Interpolation::Step));
    add_camera_node(scene, rig);
    adopt(scene, std::move(rig), std::move(animation));
    return scene;
}

}  // namespace

// The lamp is dark before half a second: the room has no light at all then.
Scene make_moving_light_switched_on() { return make_switched(make_cornell_room(), 0, 1); }

// The lamp is dark from half a second on: a smaller and warmer one on the wall to the left is left.
Scene make_moving_light_switched_off() {
    Scene scene = make_cornell_room();
    const uint32_t sconce = add_material(scene, emitter("sconce", kCornellLightRadiance * Rgb(1, 0.6f, 0.3f)));
    const vec3 corner(-2.76f, 2.6f, -3);
    add_mesh(scene, MeshBuilder()
                        .quad(corner, corner + vec3(0, 0, -0.6f), corner + vec3(0.02f, 0.6f, -0.6f),
                              corner + vec3(0.02f, 0.6f, 0))
                        .build(sconce));
    return make_switched(std::move(scene), 1, 0);
}

}  // namespace photond
