// A living room made in code: daylight through a window, lamps, wood, cloth, glass, metal, textures and instances.

#include "renderer/core/srgb.h"
#include "renderer/scene/builtin_families.h"
#include "renderer/scene/builtin_furniture.h"

namespace photond {

namespace {

using furniture::add_instance;
using furniture::placed;

// The room's inside: x from -3 (window wall) to 3, z from -2.5 (far wall) to 2.5.
constexpr float kHalfWidth = 3, kHalfDepth = 2.5f, kHeight = 2.7f;
constexpr float kWindowLow = 0.85f, kWindowHigh = 2.3f, kWindowHalf = 1.2f, kWallThickness = 0.25f;

uint8_t to_srgb8(float linear) {
    return static_cast<uint8_t>(std::lround(255 * srgb_encode(std::clamp(linear, 0.0f, 1.0f))));
}

/// A texture from a function of (u, v) in [0, 1)^2 that gives linear reflectance.
template <class Function>
uint32_t add_texture(Scene& scene, const char* name, Size2 size, const Function& reflectance) {
    Texture texture;
    texture.name = name;
    texture.size = size;
    texture.texels.reserve(size.pixels());
    for (uint32_t y = 0; y < size.height; ++y)
        for (uint32_t x = 0; x < size.width; ++x) {
            const Rgb c = reflectance((static_cast<float>(x) + 0.5f) / static_cast<float>(size.width),
                                      (static_cast<float>(y) + 0.5f) / static_cast<float>(size.height));
            texture.texels.emplace_back(to_srgb8(c.x), to_srgb8(c.y), to_srgb8(c.z), 255);
        }
    scene.textures.push_back(std::move(texture));
    return static_cast<uint32_t>(scene.textures.size() - 1);
}

float cell_noise(uint32_t x, uint32_t y) { return to_unit_float(hash32(x * 0x9e3779b9u ^ hash32(y + 0x51ed270bu))); }

/// Smooth noise of period `period` in both directions, in [0, 1].
float smooth_noise(float x, float y, uint32_t period) {
    const float fx = std::floor(x), fy = std::floor(y), s = x - fx, t = y - fy;
    const auto at = [&](float i, float j) {
        return cell_noise(static_cast<uint32_t>(i) % period, static_cast<uint32_t>(j) % period);
    };
    const float a = s * s * (3 - 2 * s), b = t * t * (3 - 2 * t);
    return (1 - b) * ((1 - a) * at(fx, fy) + a * at(fx + 1, fy)) +
           b * ((1 - a) * at(fx, fy + 1) + a * at(fx + 1, fy + 1));
}

/// Floorboards that run along u, eight side by side; each its own shade, with grain and dark joints.
Rgb floorboards(float u, float v) {
    constexpr uint32_t kBoards = 8;
    const float across = v * kBoards;
    const uint32_t board = static_cast<uint32_t>(across);
    const float start = cell_noise(board, 77);
    float along = u * 2 + start;
    along -= 2 * std::floor(along / 2);
    const uint32_t piece = static_cast<uint32_t>(along);
    const float shade = 0.75f + 0.5f * cell_noise(board, 13 + piece);
    const float grain = smooth_noise(u * 12 + 31 * shade, v * 256, 256);
    const float coarse = smooth_noise(u * 4 + 17 * shade, v * 40, 64);
    const float in_board = across - static_cast<float>(board), in_piece = along - static_cast<float>(piece);
    const bool joint = in_board < 0.02f || in_board > 0.98f || in_piece < 0.003f;
    const float light = joint ? 0.25f : shade * (0.72f + 0.28f * grain) * (0.85f + 0.3f * coarse);
    return light * Rgb(0.36f, 0.21f, 0.11f);
}

/// A rug: bands of diamonds within a border.
Rgb rug(float u, float v) {
    const float edge = std::min({u, 1 - u, v * 0.66f, (1 - v) * 0.66f});
    const Rgb red(0.32f, 0.05f, 0.04f), cream(0.62f, 0.52f, 0.36f), blue(0.04f, 0.08f, 0.2f);
    const float weave = 0.85f + 0.15f * cell_noise(static_cast<uint32_t>(u * 512), static_cast<uint32_t>(v * 768));
    if (edge < 0.025f) return weave * blue;
    if (edge < 0.04f) return weave * cream;
    if (edge < 0.09f) return weave * (std::fmod((u + v) * 24, 2.0f) < 1 ? blue : red);
    if (edge < 0.1f) return weave * cream;
    const float s = std::fabs(std::fmod(u * 6, 1.0f) - 0.5f), t = std::fabs(std::fmod(v * 9, 1.0f) - 0.5f);
    const float diamond = s + t;
    return weave * (diamond < 0.15f ? cream : diamond < 0.3f ? blue : diamond < 0.38f ? cream : red);
}

/// A picture of hills below an evening sky, v = 0 at the bottom.
Rgb picture(float u, float v) {
    Rgb color = (1 - v) * Rgb(0.9f, 0.5f, 0.2f) + v * Rgb(0.12f, 0.22f, 0.5f);
    const float sun = std::hypot(u - 0.68f, (v - 0.55f) * 0.75f);
    if (sun < 0.07f) color = Rgb(0.95f, 0.85f, 0.55f);
    for (uint32_t layer = 0; layer < 5; ++layer) {
        const float l = static_cast<float>(layer);
        const float ridge = 0.55f - 0.11f * l + 0.1f * smooth_noise(u * (2 + l) + 9 * l, 5 * l, 64) +
                            0.02f * smooth_noise(u * 24 + 5 * l, 3 * l, 64);
        if (v < ridge) color = (0.45f - 0.08f * l) * Rgb(0.5f - 0.08f * l, 0.55f, 0.65f - 0.1f * l);
    }
    return color;
}

Material textured(Material material, uint32_t texture) {
    material.base_color = Rgb(1);
    material.base_color_texture.texture = static_cast<int32_t>(texture);
    return material;
}

/// Walls, ceiling, floor, the window's reveal and frame, and the sky beyond it.
void add_room(Scene& scene) {
    const uint32_t plaster = add_material(scene, lambert("plaster", {0.78f, 0.75f, 0.69f}));
    const uint32_t ceiling = add_material(scene, lambert("ceiling", {0.82f, 0.82f, 0.8f}));
    const uint32_t paint = add_material(scene, plastic("white paint", {0.8f, 0.79f, 0.76f}, 0.3f));
    const uint32_t boards = add_material(scene, textured(plastic("floorboards", Rgb(1), 0.35f),
                                                         add_texture(scene, "floorboards", {1024, 1024}, floorboards)));
    const uint32_t sky = add_material(scene, emitter("sky", Rgb(5.5f, 7.0f, 9.0f)));

    constexpr float x = kHalfWidth, z = kHalfDepth, h = kHeight;
    add_mesh(scene, MeshBuilder().quad({-x, 0, z}, {x, 0, z}, {x, 0, -z}, {-x, 0, -z}, {3, 2.5f}).build(boards, true));
    add_mesh(scene, MeshBuilder().quad({-x, h, -z}, {x, h, -z}, {x, h, z}, {-x, h, z}).build(ceiling));
    MeshBuilder walls;
    walls.quad({-x, 0, -z}, {x, 0, -z}, {x, h, -z}, {-x, h, -z}).quad({x, 0, z}, {-x, 0, z}, {-x, h, z}, {x, h, z});
    walls.quad({x, 0, -z}, {x, 0, z}, {x, h, z}, {x, h, -z});
    // The window wall: below, above and beside the opening, and the opening's four inner sides.
    constexpr float w = kWindowHalf, low = kWindowLow, high = kWindowHigh, out = -x - kWallThickness;
    const auto on_window_wall = [&](float z0, float z1, float y0, float y1) {
        walls.quad({-x, y0, z1}, {-x, y0, z0}, {-x, y1, z0}, {-x, y1, z1});
    };
    on_window_wall(-z, z, 0, low), on_window_wall(-z, z, high, h);
    on_window_wall(-z, -w, low, high), on_window_wall(w, z, low, high);
    walls.quad({out, low, w}, {-x, low, w}, {-x, low, -w}, {out, low, -w});
    walls.quad({out, high, -w}, {-x, high, -w}, {-x, high, w}, {out, high, w});
    walls.quad({out, low, -w}, {-x, low, -w}, {-x, high, -w}, {out, high, -w});
    walls.quad({-x, low, w}, {out, low, w}, {out, high, w}, {-x, high, w});
    add_mesh(scene, walls.build(plaster));

    MeshBuilder trim;
    constexpr float fx0 = -x - 0.16f, fx1 = -x - 0.1f, f = 0.055f;
    for (const float bar : {-w, -0.5f * f, w - f}) trim.rounded_box({fx0, low, bar}, {fx1, high, bar + f}, 0.008f, 2);
    for (const float bar : {low, 0.5f * (low + high) + 0.2f, high - f})
        trim.rounded_box({fx0, bar, -w}, {fx1, bar + f, w}, 0.008f, 2);
    trim.rounded_box({-x - 0.02f, low - 0.03f, -w - 0.06f}, {-x + 0.14f, low + 0.002f, w + 0.06f}, 0.01f, 4);  // sill
    constexpr float s = 0.015f, b = 0.1f;  // skirting boards
    trim.box({-x, 0, -z}, {x, b, -z + s}).box({-x, 0, z - s}, {x, b, z});
    trim.box({-x, 0, -z + s}, {-x + s, b, z - s}).box({x - s, 0, -z + s}, {x, b, z - s});
    add_mesh(scene, trim.build(paint));

    // The sky stands for the whole outside: a panel a little larger than the window that looks into the room.
    add_mesh(scene, MeshBuilder()
                        .quad({out - 0.3f, low - 0.4f, w + 0.5f}, {out - 0.3f, low - 0.4f, -w - 0.5f},
                              {out - 0.3f, high + 0.6f, -w - 0.5f}, {out - 0.3f, high + 0.6f, w + 0.5f})
                        .build(sky));
}

void add_dining_corner(Scene& scene, uint32_t wood, uint32_t brass, uint32_t light) {
    constexpr vec3 kTableAt{-0.9f, 0, -0.6f};
    constexpr float kTableTop = 0.74f;
    MeshBuilder table;
    table.place(placed(kTableAt));
    furniture::add_table(table, 1.9f, 0.95f, kTableTop);
    add_mesh(scene, table.build(wood));

    MeshBuilder frame, cushion;
    furniture::add_chair(frame, cushion);
    const uint32_t linen = add_material(scene, lambert("linen", {0.16f, 0.3f, 0.33f}));
    const uint32_t first = static_cast<uint32_t>(scene.meshes.size());
    scene.meshes.push_back(frame.build(wood));
    scene.meshes.push_back(cushion.build(linen));
    constexpr struct {
        float x, z, yaw;
    } kChairs[] = {{-0.5f, 0.58f, 3.05f},  {0.5f, 0.74f, 2.75f}, {-0.5f, -0.6f, 0.05f},
                   {0.5f, -0.62f, -0.08f}, {-1.28f, 0, 1.62f},   {1.34f, 0.06f, -1.4f}};
    for (const auto& chair : kChairs)
        for (const uint32_t part : {0u, 1u})
            add_instance(scene, first + part, kTableAt + vec3(chair.x, 0, chair.z), chair.yaw);

    const uint32_t china = add_material(scene, plastic("china", {0.82f, 0.82f, 0.8f}, 0.1f));
    const uint32_t glaze = add_material(scene, plastic("blue glaze", {0.05f, 0.14f, 0.3f}, 0.15f));
    const uint32_t clear = add_material(scene, glass("clear glass"));
    const uint32_t orange = add_material(scene, plastic("orange", {0.75f, 0.28f, 0.03f}, 0.4f));
    const uint32_t apple = add_material(scene, plastic("apple", {0.42f, 0.05f, 0.03f}, 0.2f));
    const vec3 top = kTableAt + vec3(0, kTableTop + 0.001f, 0);

    MeshBuilder bowl, vase, oranges, apples;
    bowl.place(placed(top));
    furniture::add_bowl(bowl);
    add_mesh(scene, bowl.build(china));
    vase.place(placed(top + vec3(0.33f, 0, -0.05f)));
    furniture::add_vase(vase);
    add_mesh(scene, vase.build(glaze));
    oranges.sphere(top + vec3(-0.045f, 0.056f, 0.03f), 0.038f, 48).sphere(top + vec3(0.012f, 0.115f, 0.0f), 0.037f, 48);
    oranges.sphere(top + vec3(0.045f, 0.058f, 0.035f), 0.038f, 48);
    apples.sphere(top + vec3(-0.035f, 0.056f, -0.05f), 0.037f, 48)
        .sphere(top + vec3(0.05f, 0.06f, -0.045f), 0.036f, 48);
    add_mesh(scene, oranges.build(orange));
    add_mesh(scene, apples.build(apple));

    MeshBuilder plate, tumbler;
    furniture::add_plate(plate), furniture::add_tumbler(tumbler);
    const uint32_t setting = static_cast<uint32_t>(scene.meshes.size());
    scene.meshes.push_back(plate.build(china));
    scene.meshes.push_back(tumbler.build(clear));
    for (const float sx : {-0.5f, 0.5f})
        for (const float sz : {-0.3f, 0.3f}) {
            add_instance(scene, setting, top + vec3(sx, 0, sz), 0);
            add_instance(scene, setting + 1, top + vec3(sx + 0.17f, 0, sz * 0.55f), 0);
        }

    MeshBuilder lamps, enamel, bulbs;
    for (const float dx : {-0.6f, 0.0f, 0.6f}) {
        const mat4 hang = placed(vec3(kTableAt.x + dx, kHeight, kTableAt.z));
        lamps.place(hang), enamel.place(hang), bulbs.place(hang);
        furniture::add_pendant_lamp(lamps, enamel, bulbs, 0.85f);
    }
    add_mesh(scene, lamps.build(brass));
    add_mesh(scene, enamel.build(add_material(scene, lambert("enamel", Rgb(0.85f, 0.83f, 0.8f)))));
    add_mesh(scene, bulbs.build(light));
}

void add_sitting_corner(Scene& scene, uint32_t wood, uint32_t brass, uint32_t light, RandomStream& random) {
    const uint32_t velvet = add_material(scene, lambert("velvet", {0.3f, 0.1f, 0.08f}));
    const uint32_t cotton = add_material(scene, lambert("lampshade", {0.75f, 0.68f, 0.55f}));
    const uint32_t rug_cloth =
        add_material(scene, textured(lambert("rug", Rgb(1)), add_texture(scene, "rug", {512, 768}, rug)));
    MeshBuilder cover, feet;
    const mat4 at_wall = placed({2.4f, 0, -0.3f}, -kPi / 2);
    cover.place(at_wall), feet.place(at_wall);
    furniture::add_sofa(cover, feet, 2.1f);
    add_mesh(scene, cover.build(velvet));
    add_mesh(scene, feet.build(wood));

    MeshBuilder low_table;
    low_table.place(placed({1.35f, 0.008f, -0.3f}));
    furniture::add_table(low_table, 0.6f, 1.0f, 0.38f);
    add_mesh(scene, low_table.build(wood));

    constexpr uint32_t kColumns = 49, kRows = 65;
    std::vector<vec3> cloth;
    for (uint32_t r = 0; r < kRows; ++r)
        for (uint32_t c = 0; c < kColumns; ++c) {
            const float u = static_cast<float>(c) / (kColumns - 1), v = static_cast<float>(r) / (kRows - 1);
            const float wave = 0.003f * smooth_noise(u * 5, v * 7, 64);
            cloth.emplace_back(0.6f + 1.5f * u, 0.004f + wave, 0.85f - 2.3f * v);
        }
    add_mesh(scene, MeshBuilder().grid(cloth, kColumns).build(rug_cloth, true));

    MeshBuilder stand, shade, bulb;
    const mat4 at_sofa = placed({2.55f, 0, -1.75f});
    stand.place(at_sofa), shade.place(at_sofa), bulb.place(at_sofa);
    furniture::add_floor_lamp(stand, shade, bulb);
    add_mesh(scene, stand.build(brass));
    add_mesh(scene, shade.build(cotton));
    add_mesh(scene, bulb.build(light));

    MeshBuilder pot, earth, leaves;
    const mat4 at_window = placed({-2.3f, 0, -1.85f});
    pot.place(at_window), earth.place(at_window), leaves.place(at_window);
    furniture::add_plant(pot, earth, leaves, random);
    add_mesh(scene, pot.build(add_material(scene, lambert("terracotta", {0.5f, 0.2f, 0.11f}))));
    add_mesh(scene, earth.build(add_material(scene, lambert("earth", {0.06f, 0.04f, 0.03f}))));
    add_mesh(scene, leaves.build(add_material(scene, plastic("leaf", {0.06f, 0.2f, 0.05f}, 0.35f))));
}

void add_far_wall(Scene& scene, uint32_t wood, RandomStream& random) {
    constexpr Rgb kCovers[] = {{0.35f, 0.06f, 0.05f}, {0.06f, 0.12f, 0.25f}, {0.08f, 0.2f, 0.1f},
                               {0.55f, 0.45f, 0.3f},  {0.12f, 0.1f, 0.09f},  {0.5f, 0.25f, 0.06f}};
    constexpr size_t kCoverCount = std::size(kCovers);
    MeshBuilder shelves, books[kCoverCount];
    const mat4 at_wall = placed({1.35f, 0, -kHalfDepth + 0.016f});
    shelves.place(at_wall);
    for (MeshBuilder& book : books) book.place(at_wall);
    furniture::add_bookcase(shelves, books, 1.5f, 2.05f, random);
    add_mesh(scene, shelves.build(wood));
    for (size_t i = 0; i < kCoverCount; ++i)
        add_mesh(scene, books[i].build(add_material(scene, plastic("book cover", kCovers[i], 0.5f))));

    // A picture and a mirror, each in its frame.
    const uint32_t black = add_material(scene, plastic("black frame", Rgb(0.03f), 0.3f));
    const auto hang = [&](const vec2& low, const vec2& high, uint32_t material, bool with_uv) {
        constexpr float kBack = -kHalfDepth + 0.001f, kFront = kBack + 0.03f, kRim = 0.04f;
        MeshBuilder frame;
        frame.rounded_box({low.x, low.y, kBack}, {low.x + kRim, high.y, kFront}, 0.006f, 3);
        frame.rounded_box({high.x - kRim, low.y, kBack}, {high.x, high.y, kFront}, 0.006f, 3);
        frame.rounded_box({low.x + kRim, low.y, kBack}, {high.x - kRim, low.y + kRim, kFront}, 0.006f, 3);
        frame.rounded_box({low.x + kRim, high.y - kRim, kBack}, {high.x - kRim, high.y, kFront}, 0.006f, 3);
        add_mesh(scene, frame.build(black));
        const vec2 a = low + vec2(kRim), b = high - vec2(kRim);
        constexpr float kPane = kBack + 0.012f;
        add_mesh(scene, MeshBuilder()
                            .quad({a.x, a.y, kPane}, {b.x, a.y, kPane}, {b.x, b.y, kPane}, {a.x, b.y, kPane})
                            .build(material, with_uv));
    };
    const uint32_t paper = add_texture(scene, "picture", {512, 384}, picture);
    hang({-2.0f, 1.25f}, {-0.9f, 2.05f}, add_material(scene, textured(lambert("picture", Rgb(1)), paper)), true);
    hang({-0.6f, 1.1f}, {0.2f, 2.1f}, add_material(scene, metal("mirror", Rgb(0.92f), 0)), false);
}

void add_curtains(Scene& scene, RandomStream& random) {
    constexpr float kRail = 2.45f, kX = -kHalfWidth + 0.1f;
    MeshBuilder cloth;
    // A curtain hangs along its own x; turned so that its front looks into the room.
    for (const float z0 : {kWindowHalf + 0.45f, -kWindowHalf + 0.25f}) {
        cloth.place(placed({kX, 0.03f, z0}, kPi / 2));
        furniture::add_curtain(cloth, 0.7f, kRail - 0.05f, 7, random);
    }
    add_mesh(scene, cloth.build(add_material(scene, lambert("curtain", {0.62f, 0.55f, 0.42f}))));
    const vec3 rail[] = {{kX, kRail, -kWindowHalf - 0.6f}, {kX, kRail, kWindowHalf + 0.6f}};
    add_mesh(scene, MeshBuilder().pipe(rail, 0.014f, 24).build(add_material(scene, metal("steel", Rgb(0.55f), 0.25f))));
}

}  // namespace

Scene make_interior() {
    Scene scene;
    RandomStream random(1, RandomDomain::BuiltinScene, 0, 0);  // the same room every time
    const uint32_t wood = add_material(scene, plastic("oak", {0.33f, 0.19f, 0.09f}, 0.4f));
    const uint32_t brass = add_material(scene, metal("brass", {0.91f, 0.78f, 0.42f}, 0.22f));
    const uint32_t light = add_material(scene, emitter("lamp", Rgb(70, 52, 32)));
    add_room(scene);
    add_dining_corner(scene, wood, brass, light);
    add_sitting_corner(scene, wood, brass, light, random);
    add_far_wall(scene, wood, random);
    add_curtains(scene, random);
    add_camera(scene, {1.2, 1.6, 2.42}, {0.1, 0.85, -1.0}, 1.0f);
    return scene;
}

}  // namespace photond
