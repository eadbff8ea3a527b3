#include "renderer/scene/builtin_furniture.h"

#include <array>

namespace photond::furniture {

namespace {

constexpr float kTwoPi = 2 * kPi;

/// Adds shapes in a space moved by `offset` and turned by `yaw` about +y, then returns to the builder's own.
template <class Add>
void at(MeshBuilder& builder, const vec3& offset, float yaw, const Add& add) {
    const mat4 outer = builder.placing();
    builder.place(glm::rotate(glm::translate(outer, offset), yaw, vec3(0, 1, 0)));
    add();
    builder.place(outer);
}

void add_tapered_leg(MeshBuilder& wood, const vec3& foot, float height, float foot_radius, float top_radius) {
    const vec2 profile[] = {{0, 0}, {foot_radius, 0}, {top_radius, height}, {0, height}};
    at(wood, foot, 0, [&] { wood.lathe(profile, 24); });
}

}  // namespace

void add_instance(Scene& scene, uint32_t mesh, const vec3& at, float yaw) {
    const mat4 placing = placed(at, yaw);
    Instance instance;
    instance.mesh = mesh;
    instance.identity = false;
    instance.to_world = mat4x3(placing);
    instance.normal_to_world = mat3(placing);  // a rotation is its own inverse transpose
    scene.instances.push_back(instance);
}

void add_table(MeshBuilder& wood, float width, float depth, float height) {
    constexpr float kTop = 0.04f, kInset = 0.1f;
    wood.rounded_box({-width / 2, height - kTop, -depth / 2}, {width / 2, height, depth / 2}, 0.012f, 4);
    const float x = width / 2 - kInset, z = depth / 2 - kInset, rail_low = height - kTop - 0.09f;
    for (const float s : {-1.0f, 1.0f}) {
        for (const float t : {-1.0f, 1.0f}) add_tapered_leg(wood, {s * x, 0, t * z}, height - kTop, 0.022f, 0.035f);
        wood.box({-x, rail_low, s * z - 0.012f}, {x, height - kTop, s * z + 0.012f});
        wood.box({s * x - 0.012f, rail_low, -z}, {s * x + 0.012f, height - kTop, z});
    }
}

void add_chair(MeshBuilder& frame, MeshBuilder& cushion) {
    constexpr float kSeat = 0.45f, kHalf = 0.2f, kBackTop = 0.86f;
    constexpr uint32_t kSides = 16, kSpindles = 7;
    frame.rounded_box({-kHalf - 0.02f, kSeat - 0.035f, -kHalf - 0.02f}, {kHalf + 0.02f, kSeat, kHalf + 0.02f}, 0.015f,
                      4);
    cushion.rounded_box({-kHalf, kSeat + 0.001f, -kHalf}, {kHalf, kSeat + 0.05f, kHalf}, 0.024f, 6);
    for (const float s : {-1.0f, 1.0f}) {
        const vec3 front[] = {{s * 0.21f, 0.002f, 0.22f}, {s * 0.18f, kSeat - 0.03f, 0.17f}};
        const vec3 back[] = {{s * 0.21f, 0.005f, -0.24f}, {s * 0.185f, kSeat, -0.185f}, {s * 0.19f, kBackTop, -0.28f}};
        frame.pipe(front, 0.017f, kSides).pipe(back, 0.017f, kSides);
        const vec3 stretcher[] = {{s * 0.2f, 0.16f, 0.205f}, {s * 0.2f, 0.16f, -0.222f}};
        frame.pipe(stretcher, 0.01f, kSides);
    }
    // The curved top rail and the spindles below it.
    std::array<vec3, 25> rail;
    const auto rail_at = [](float t) {
        return vec3(0.21f * t, kBackTop + 0.025f * (1 - t * t), -0.28f - 0.035f * (1 - t * t));
    };
    for (size_t i = 0; i < rail.size(); ++i)
        rail[i] = rail_at(2 * static_cast<float>(i) / static_cast<float>(rail.size() - 1) - 1);
    frame.pipe(rail, 0.02f, kSides);
    for (uint32_t i = 0; i < kSpindles; ++i) {
        const float t = (static_cast<float>(i) + 0.5f) / kSpindles * 1.7f - 0.85f;
        const vec3 top = rail_at(t),
                   spindle[] = {{0.17f * t, kSeat - 0.01f, -0.19f}, 0.5f * (top + vec3(0.17f * t, kSeat, -0.2f)), top};
        frame.pipe(spindle, 0.008f, 10);
    }
}

void add_sofa(MeshBuilder& cover, MeshBuilder& feet, float width) {
    constexpr float kDepth = 0.9f, kSeat = 0.42f, kBack = 0.82f, kArm = 0.2f, kRound = 0.05f;
    constexpr uint32_t kSteps = 8, kCushions = 3;
    const float half = width / 2, inner = half - kArm;
    cover.rounded_box({-half, 0.1f, -kDepth / 2}, {half, 0.27f, kDepth / 2}, 0.03f, kSteps);
    for (const float s : {-1.0f, 1.0f}) {
        const float x0 = std::min(s * half, s * inner), x1 = std::max(s * half, s * inner);
        cover.rounded_box({x0, 0.1f, -kDepth / 2}, {x1, 0.6f, kDepth / 2 + 0.01f}, kRound, kSteps);
        for (const float t : {-1.0f, 1.0f})
            add_tapered_leg(feet, {s * (half - 0.1f), 0, t * 0.35f}, 0.101f, 0.018f, 0.028f);
    }
    cover.rounded_box({-inner, 0.1f, -kDepth / 2}, {inner, kBack - 0.06f, -kDepth / 2 + 0.2f}, kRound, kSteps);
    const float each = 2 * inner / kCushions;
    for (uint32_t i = 0; i < kCushions; ++i) {
        const float x0 = -inner + each * static_cast<float>(i) + 0.004f, x1 = x0 + each - 0.008f;
        cover.rounded_box({x0, 0.272f, -0.28f}, {x1, kSeat, kDepth / 2}, kRound, kSteps);
        // Back cushions lean.
        const mat4 outer = cover.placing();
        cover.place(glm::rotate(glm::translate(outer, vec3(0, kSeat + 0.01f, -0.24f)), -0.18f, vec3(1, 0, 0)));
        cover.rounded_box({x0, 0, 0}, {x1, kBack - kSeat, 0.17f}, 0.07f, kSteps);
        cover.place(outer);
    }
}

void add_bookcase(MeshBuilder& wood, std::span<MeshBuilder> books, float width, float height, RandomStream& random) {
    constexpr float kDepth = 0.3f, kBoard = 0.025f;
    const uint32_t shelves = static_cast<uint32_t>(std::floor(height / 0.36f));
    const float half = width / 2, step = (height - kBoard) / static_cast<float>(shelves);
    wood.box({-half, 0, 0}, {-half + kBoard, height, kDepth}).box({half - kBoard, 0, 0}, {half, height, kDepth});
    wood.box({-half + kBoard, 0, 0}, {half - kBoard, height, 0.01f});
    for (uint32_t s = 0; s <= shelves; ++s) {
        const float y = step * static_cast<float>(s);
        wood.box({-half + kBoard, y, 0.01f}, {half - kBoard, y + kBoard, kDepth});
        if (s == shelves) break;
        const float room = step - kBoard, base = y + kBoard + 0.0005f;
        float x = -half + kBoard + 0.003f;
        const float end = half - kBoard - 0.003f - 0.25f * random.next();
        while (true) {
            const float thick = 0.014f + 0.035f * random.next() * random.next();
            const float tall = room * (0.6f + 0.33f * random.next()), deep = 0.15f + 0.08f * random.next();
            if (x + thick > end) break;
            const size_t which =
                std::min(static_cast<size_t>(random.next() * static_cast<float>(books.size())), books.size() - 1);
            const float front = kDepth - 0.03f - 0.02f * random.next();
            books[which].rounded_box({x, base, front - deep}, {x + thick, base + tall, front}, 0.003f, 2);
            x += thick + 0.0008f;
        }
    }
}

void add_curtain(MeshBuilder& cloth, float width, float drop, uint32_t folds, RandomStream& random) {
    const uint32_t columns = folds * 16 + 1, rows = 72;
    std::vector<float> strength(folds + 1), phase(folds + 1);
    for (float& s : strength) s = 0.7f + 0.6f * random.next();
    for (float& p : phase) p = 0.8f * (random.next() - 0.5f);
    std::vector<vec3> points;
    points.reserve(size_t{columns} * rows);
    for (uint32_t r = 0; r < rows; ++r) {
        const float down = static_cast<float>(r) / static_cast<float>(rows - 1);  // rows run upwards: 1 is the rail
        const float y = drop * down, loose = 1 - down;
        for (uint32_t c = 0; c < columns; ++c) {
            const float s = static_cast<float>(c) / static_cast<float>(columns - 1),
                        fold = s * static_cast<float>(folds);
            const size_t k = std::min(static_cast<size_t>(fold), strength.size() - 2);
            const float t = fold - static_cast<float>(k);
            const float amplitude = (1 - t) * strength[k] + t * strength[k + 1];
            const float shift = ((1 - t) * phase[k] + t * phase[k + 1]) * loose;
            const float z = 0.045f * amplitude * (0.6f + 0.4f * loose) * std::sin(kTwoPi * fold + shift);
            points.emplace_back(width * s + 0.005f * loose * std::sin(2 * kTwoPi * fold + 3 * shift), y, z);
        }
    }
    cloth.grid(points, columns);
}

void add_floor_lamp(MeshBuilder& metal, MeshBuilder& shade, MeshBuilder& bulb) {
    const vec2 base[] = {{0, 0},          {0.15f, 0},     {0.15f, 0.012f}, {0.02f, 0.03f},
                         {0.011f, 0.05f}, {0.011f, 1.5f}, {0, 1.5f}};
    metal.lathe(base, 48, 0.3f);
    // Cloth of two sides, a little apart, so that light from within leaves at top and bottom only.
    const vec2 outer[] = {{0.21f, 1.28f}, {0.15f, 1.62f}}, inner[] = {{0.148f, 1.62f}, {0.208f, 1.28f}};
    shade.lathe(outer, 64).lathe(inner, 64);
    const vec2 rims[2][2] = {{{0.208f, 1.28f}, {0.21f, 1.28f}}, {{0.15f, 1.62f}, {0.148f, 1.62f}}};
    for (const auto& rim : rims) shade.lathe(rim, 64);
    bulb.sphere({0, 1.55f, 0}, 0.045f, 12);
}

void add_pendant_lamp(MeshBuilder& metal, MeshBuilder& enamel, MeshBuilder& bulb, float cord) {
    const vec3 line[] = {{0, 0, 0}, {0, -cord, 0}};
    metal.pipe(line, 0.003f, 8);
    std::vector<vec2> shell;  // outside upwards, inside back down
    constexpr uint32_t kSteps = 20;
    constexpr float kRadius = 0.17f, kWall = 0.003f;
    const auto arc = [&](float radius, uint32_t i) {
        const float angle = 0.5f * kPi * static_cast<float>(i) / kSteps;
        return vec2(i == kSteps ? 0.0f : radius * std::cos(angle), -cord - kRadius + radius * std::sin(angle));
    };
    for (uint32_t i = 0; i <= kSteps; ++i) shell.push_back(arc(kRadius, i));
    metal.lathe(shell, 64);
    shell.clear();
    for (uint32_t i = kSteps + 1; i-- > 0;) shell.push_back(arc(kRadius - kWall, i));
    shell.push_back({kRadius, -cord - kRadius});
    enamel.lathe(shell, 64, 1.0f);
    bulb.sphere({0, -cord - kRadius + 0.06f, 0}, 0.05f, 12);
}

void add_plant(MeshBuilder& pot, MeshBuilder& earth, MeshBuilder& leaves, RandomStream& random) {
    const vec2 outside[] = {{0, 0},          {0.13f, 0},      {0.17f, 0.3f},  {0.185f, 0.3f},
                            {0.185f, 0.34f}, {0.165f, 0.34f}, {0.158f, 0.28f}};
    const vec2 soil[] = {{0.159f, 0.29f}, {0.08f, 0.3f}, {0, 0.305f}};
    pot.lathe(outside, 64, 0.4f);
    earth.lathe(soil, 48);
    constexpr uint32_t kLeaves = 34, kLength = 18, kAcross = 5;
    for (uint32_t l = 0; l < kLeaves; ++l) {
        const float yaw = kTwoPi * (static_cast<float>(l) * 0.61803399f + 0.1f * random.next());
        const float length = 0.45f + 0.35f * random.next(), lean = 0.25f + 0.9f * random.next(),
                    width = 0.035f + 0.02f * random.next();
        const vec3 out(std::cos(yaw), 0, -std::sin(yaw)), side(std::sin(yaw), 0, std::cos(yaw));
        std::vector<vec3> points;
        vec3 spine = 0.05f * random.next() * out + vec3(0, 0.3f, 0);
        float pitch = 1.45f - 0.25f * lean;  // upwards at first, bending over with its own weight
        for (uint32_t i = 0; i < kLength; ++i) {
            const float t = static_cast<float>(i) / (kLength - 1);
            const float half = width * std::pow(std::sin(kPi * std::min(0.97f, 0.06f + 0.91f * t)), 0.8f);
            const vec3 along = std::cos(pitch) * out + std::sin(pitch) * vec3(0, 1, 0), up = glm::cross(along, side);
            for (uint32_t c = 0; c < kAcross; ++c) {
                const float s = 2 * static_cast<float>(c) / (kAcross - 1) - 1;
                points.push_back(spine + half * s * side - 0.35f * half * (1 - s * s) * up);
            }
            spine += length / (kLength - 1) * along;
            pitch -= lean * 2.1f / kLength * (0.5f + t);
        }
        leaves.grid(points, kAcross);
    }
}

void add_bowl(MeshBuilder& clay) {
    std::vector<vec2> profile = {{0, 0}, {0.06f, 0}, {0.062f, 0.008f}};
    constexpr uint32_t kSteps = 14;
    const auto wall = [](float radius, uint32_t i) {
        const float angle = (0.12f + 0.85f * static_cast<float>(i) / kSteps) * 0.5f * kPi;
        return vec2(radius * std::sin(angle), 0.165f - radius * std::cos(angle));
    };
    for (uint32_t i = 3; i <= kSteps; ++i) profile.push_back(wall(0.16f, i));
    for (uint32_t i = kSteps + 1; i-- > 0;) profile.push_back(wall(0.153f, i));
    profile.push_back({0, profile.back().y - 0.002f});
    clay.lathe(profile, 96);
}

void add_vase(MeshBuilder& clay) {
    std::vector<vec2> profile = {{0, 0}, {0.05f, 0}};
    constexpr uint32_t kSteps = 40;
    const auto radius = [](float t) { return 0.05f + 0.055f * std::sin(kPi * std::min(1.0f, t * 1.25f)) - 0.02f * t; };
    for (uint32_t i = 1; i <= kSteps; ++i) {
        const float t = static_cast<float>(i) / kSteps;
        profile.emplace_back(radius(t), 0.32f * t);
    }
    for (uint32_t i = kSteps; i > 2; --i) {
        const float t = static_cast<float>(i) / kSteps;
        profile.emplace_back(radius(t) - 0.006f, 0.32f * t);
    }
    clay.lathe(profile, 96, 0.9f);
}

void add_plate(MeshBuilder& china) {
    const vec2 profile[] = {{0, 0},           {0.075f, 0},     {0.08f, 0.004f}, {0.128f, 0.018f}, {0.13f, 0.021f},
                            {0.126f, 0.022f}, {0.08f, 0.009f}, {0.07f, 0.006f}, {0, 0.006f}};
    china.lathe(profile, 96);
}

void add_tumbler(MeshBuilder& glass) {
    const vec2 profile[] = {{0, 0},           {0.028f, 0},      {0.031f, 0.003f},  {0.038f, 0.108f}, {0.0375f, 0.11f},
                            {0.0365f, 0.11f}, {0.036f, 0.108f}, {0.0295f, 0.012f}, {0.027f, 0.01f},  {0, 0.01f}};
    glass.lathe(profile, 96);
}

void add_glass_globe(MeshBuilder& glass, float radius, float wall, uint32_t rings, float wave) {
    constexpr uint32_t kSlices = 40, kInsideSteps = 24;
    const auto arc = [](uint32_t i, uint32_t steps, float r) {
        const float angle = kPi * static_cast<float>(i) / static_cast<float>(steps);
        return vec2(i == 0 || i == steps ? 0.0f : r * std::sin(angle), -r * std::cos(angle));
    };
    std::vector<vec2> outside, inside;  // upwards, and downwards: the glass lies between
    const uint32_t steps = std::max(kInsideSteps, 10 * rings);
    for (uint32_t i = 0; i <= steps; ++i) {
        const float turns = static_cast<float>(rings * i) / static_cast<float>(steps);
        outside.push_back(arc(i, steps, radius * (1 + wave * std::cos(kTwoPi * turns))));
    }
    for (uint32_t i = kInsideSteps + 1; i-- > 0;) inside.push_back(arc(i, kInsideSteps, radius - wall));
    glass.lathe(outside, kSlices).lathe(inside, kSlices);
}

void add_reflector(MeshBuilder& mirror, float radius, float depth, uint32_t slices) {
    constexpr uint32_t kSteps = 24;
    std::vector<vec2> profile;  // downwards: the inside is the front
    for (uint32_t i = kSteps + 1; i-- > 0;) {
        const float t = static_cast<float>(i) / kSteps;
        profile.emplace_back(radius * t, depth * (t * t - 1));
    }
    mirror.lathe(profile, slices);
}

}  // namespace photond::furniture
