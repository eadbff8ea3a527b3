// Lights that are hard by their direction, their range or their number.

#include "renderer/core/rng.h"
#include "renderer/scene/hard_case_answers.h"
#include "renderer/scene/hard_case_parts.h"

namespace photond {

namespace {

using namespace hard_case;

constexpr double kAlbedo = 0.5;
const dvec3 kLight(4, 2, 1);

Material grey() { return lambert("grey", Rgb(static_cast<float>(kAlbedo))); }

// ---- grazing

constexpr double kDegree = kPiD / 180;

Scene grazing_view() {
    Scene scene;
    add_mesh(scene, level_rectangle(-20, 20, -20, 20, 0, true, add_material(scene, grey())));
    add_directional_light(scene, {0, -1, 0}, Rgb(kLight));
    const dvec3 towards_eye(0, std::sin(kDegree), std::cos(kDegree));
    add_orthographic_camera(scene, 10.0 * towards_eye, dvec3(0), {0, 1, 0}, 0.05f);
    return scene;
}

/// From half a degree above the horizon.
const vec3 kLowSun =
    glm::normalize(vec3(static_cast<float>(std::cos(0.5 * kDegree)), static_cast<float>(-std::sin(0.5 * kDegree)), 0));

Scene grazing_light() {
    Scene scene;
    add_mesh(scene, level_rectangle(-2, 2, -2, 2, 0, true, add_material(scene, grey())));
    add_directional_light(scene, kLowSun, Rgb(kLight));
    add_camera_down(scene, 0, 1, 0, 0.5f);
    return scene;
}

Mesh faceted_ball(uint32_t material) { return make_icosphere(4, material); }

/// A ball of flat facets, lit from the left and seen from the front: the terminator runs through the image.
Scene terminator() {
    Scene scene;
    add_mesh(scene, faceted_ball(add_material(scene, grey())));
    add_directional_light(scene, {1, 0, 0}, Rgb(kLight));
    add_orthographic_camera(scene, {0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 1);
    return scene;
}

/// A convex body has no shadows but its own night: each facet that is seen and lit adds its share of the image.
dvec3 terminator_radiance() {
    const Mesh ball = faceted_ball(0);
    double sum = 0;
    for (const uvec3& t : ball.triangles) {
        const dvec3 a(ball.positions[t.x]), b(ball.positions[t.y]), c(ball.positions[t.z]);
        const dvec3 area = 0.5 * glm::cross(b - a, c - a);
        if (area.z > 0 && area.x < 0) sum += area.z * -area.x / glm::length(area);
    }
    constexpr double kImageArea = 4;  // 2 m x 2 m
    return kAlbedo / kPiD * sum / kImageArea * kLight;
}

// ---- range

constexpr float kDim = 1e-6f, kBright = 1e8f;

/// A dim light above the left half of a floor, a bright one above the right, a black board between them.
Scene dynamic_range() {
    Scene scene;
    add_mesh(scene, level_rectangle(-2, 2, -2, 2, 0, true, add_material(scene, grey())));
    const uint32_t dim = add_material(scene, emitter("dim", kDim * Rgb(kLight)));
    const uint32_t bright = add_material(scene, emitter("bright", kBright * Rgb(kLight)));
    const uint32_t black = add_material(scene, lambert("black", Rgb(0)));
    add_mesh(scene, level_rectangle(-1.5f, -0.5f, -0.5f, 0.5f, 1, false, dim));
    add_mesh(scene, level_rectangle(0.5f, 1.5f, -0.5f, 0.5f, 1, false, bright));
    add_mesh(scene, MeshBuilder().quad({0, 0, 2}, {0, 0, -2}, {0, 1.25f, -2}, {0, 1.25f, 2}).build(black));
    add_camera_down(scene, 0, 0.5f, 0, 0.5f);
    return scene;
}

std::vector<KnownCheck> dynamic_range_checks() {
    const double factor = parallel_form_factor({0, 0.5, -0.5, 0.5}, {0.5, 1.5, -0.5, 0.5}, 1);
    const auto radiance = [&](float scale) { return kAlbedo * factor * static_cast<double>(scale) * kLight; };
    return {in_region(equals("direct", radiance(kDim), 1), {0, 0, 0.5, 1}),
            in_region(equals("direct", radiance(kBright), 1), {0.5, 0, 1, 1}), zero("indirect", 1)};
}

// ---- number

constexpr uint32_t kLightsASide = 100;
constexpr float kTile = 2.0f / kLightsASide;
constexpr uint32_t kPowers = 10;

/// Which of kPowers powers the light of a cell has: 1 to 512 times the least.
uint32_t power_of(uint32_t row, uint32_t column) { return hash32(row * kLightsASide + column) % kPowers; }
float strength(uint32_t power) { return static_cast<float>(1u << power) / 64; }
float cell_start(uint32_t cell) { return static_cast<float>(cell) * kTile - 1; }

Scene ten_thousand_tiles() {
    Scene scene;
    add_mesh(scene, level_rectangle(-2, 2, -2, 2, 0, true, add_material(scene, grey())));
    std::vector<MeshBuilder> tiles(kPowers);
    for (uint32_t row = 0; row < kLightsASide; ++row)
        for (uint32_t column = 0; column < kLightsASide; ++column) {
            const float x0 = cell_start(column), x1 = cell_start(column + 1);
            const float z0 = cell_start(row), z1 = cell_start(row + 1);
            tiles[power_of(row, column)].quad({x0, 1, z0}, {x1, 1, z0}, {x1, 1, z1}, {x0, 1, z1});
        }
    for (uint32_t power = 0; power < kPowers; ++power)
        add_mesh(scene, tiles[power].build(add_material(scene, emitter("light", strength(power) * Rgb(kLight)))));
    add_camera_down(scene, 0, 0.5f, 0, 0.5f);
    return scene;
}

constexpr Rectangle kView{-0.5, 0.5, -0.5, 0.5};

/// Sum over the lights of strength x part(row, column).
template <class Part>
double sum_of_parts(const Part& part) {
    double sum = 0;
    for (uint32_t row = 0; row < kLightsASide; ++row)
        for (uint32_t column = 0; column < kLightsASide; ++column)
            sum += static_cast<double>(strength(power_of(row, column))) * part(row, column);
    return sum;
}

dvec3 tiles_radiance() {
    const double factors = sum_of_parts([](uint32_t row, uint32_t column) {
        return parallel_form_factor(kView,
                                    {double{cell_start(column)}, double{cell_start(column + 1)},
                                     double{cell_start(row)}, double{cell_start(row + 1)}},
                                    1);
    });
    return kAlbedo * factors * kLight;
}

vec3 point_light_position(uint32_t row, uint32_t column) {
    return {cell_start(column) + 0.5f * kTile, 1, cell_start(row) + 0.5f * kTile};
}

constexpr float kPointScale = 1e-3f;

Scene ten_thousand_points() {
    Scene scene;
    add_mesh(scene, level_rectangle(-2, 2, -2, 2, 0, true, add_material(scene, grey())));
    for (uint32_t row = 0; row < kLightsASide; ++row)
        for (uint32_t column = 0; column < kLightsASide; ++column)
            add_point_light(scene, point_light_position(row, column),
                            kPointScale * strength(power_of(row, column)) * Rgb(kLight));
    add_camera_down(scene, 0, 0.5f, 0, 0.5f);
    return scene;
}

/// The flux of a point light into the view is its intensity times the view's solid angle.
dvec3 points_radiance() {
    const double solid_angles = sum_of_parts([](uint32_t row, uint32_t column) {
        const dvec3 from(point_light_position(row, column));
        const dvec3 a = dvec3(kView.x0, 0, kView.y0) - from, b = dvec3(kView.x1, 0, kView.y0) - from;
        const dvec3 c = dvec3(kView.x1, 0, kView.y1) - from, d = dvec3(kView.x0, 0, kView.y1) - from;
        return triangle_solid_angle(a, b, c) + triangle_solid_angle(a, c, d);
    });
    return kAlbedo / kPiD * static_cast<double>(kPointScale) * solid_angles / kView.area() * kLight;
}

}  // namespace

void add_light_cases(std::vector<HardCase>& cases) {
    constexpr const char* kGrazing = "grazing view and grazing light";
    cases.push_back({"hard-case/grazing-view",
                     {.row = kGrazing,
                      .strains = "cosines, filters seen edge-on",
                      .text = "a floor in the zenith's sun, seen one degree above it: albedo E / pi",
                      .checks = {equals("direct", kAlbedo / kPiD * kLight, 1), zero("indirect", 1)},
                      .passes = 16},
                     grazing_view});
    cases.push_back(
        {"hard-case/grazing-light",
         {.row = kGrazing,
          .strains = "cosines, shadow acne",
          .text = "a floor in a sun half a degree above it: albedo E cos / pi",
          .checks = {equals("direct", kAlbedo / kPiD * -double{kLowSun.y} * kLight, 1), zero("indirect", 1)},
          .passes = 16},
         grazing_light});
    cases.push_back({"hard-case/grazing-terminator",
                     {.row = kGrazing,
                      .strains = "shadow acne and self-hits of facets that the light grazes",
                      .text = "a ball of facets lit from the side: the sum over its facets",
                      .checks = {equals("direct", terminator_radiance(), 1), zero("indirect", 1)}},
                     terminator});
    cases.push_back({"hard-case/dynamic-range",
                     {.row = "light of 1e-6 and of 1e8, dynamic range 1e14 in one image",
                      .strains = "sums, sampling of lights by power",
                      .text = "two rectangle lights, each above its half of a floor",
                      .checks = dynamic_range_checks()},
                     dynamic_range});
    constexpr const char* kMany = "10,000 lights";
    cases.push_back({"hard-case/lights-10000",
                     {.row = kMany,
                      .strains = "light selection, memory per light",
                      .text = "10,000 rectangle lights of ten powers above a plane: the sum of parts",
                      .checks = {equals("direct", tiles_radiance(), 1), zero("indirect", 1)}},
                     ten_thousand_tiles});
    cases.push_back({"hard-case/point-lights-10000",
                     {.row = kMany,
                      .strains = "light selection, memory per light",
                      .text = "10,000 point lights of ten powers above a plane: the sum of parts",
                      .checks = {equals("direct", points_radiance(), 1), zero("indirect", 1)}},
                     ten_thousand_points});
}

}  // namespace photond
