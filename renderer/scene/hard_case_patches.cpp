// Lambert patches whose light is a form factor: nothing is seen but what one rectangle sends another.
//
// All receivers are seen by an orthographic camera, so that the image's mean is the mean over the rectangle in view: a
// receiver of albedo rho before a reflector or emitter of uniform radiance L shows rho L F, F from the rectangle in
// view to the other. Reflectors are lit evenly, by light from far away: L = albedo E / pi.

#include "renderer/scene/hard_case_answers.h"
#include "renderer/scene/hard_case_parts.h"

namespace photond {

namespace {

using namespace hard_case;

constexpr double kAlbedo = 0.5;
const dvec3 kLight(4, 2, 1);  // radiance of emitters, irradiance across the beams of lights far away

Material grey() { return lambert("grey", Rgb(static_cast<float>(kAlbedo))); }

HardCase patch_case(const char* name, const char* row, const char* strains, const char* text,
                    std::vector<KnownCheck> checks, Scene (*make)()) {
    return {
        std::string(kPrefix) + name, {.row = row, .strains = strains, .text = text, .checks = std::move(checks)}, make};
}

// ---- a rectangle light above a plane

Scene light_above_plane(float gap, float camera_x, float half_view) {
    Scene scene;
    add_mesh(scene, level_rectangle(-2, 2, -2, 2, 0, true, add_material(scene, grey())));
    add_mesh(scene,
             level_rectangle(-0.5f, 0.5f, -0.5f, 0.5f, gap, false, add_material(scene, emitter("light", Rgb(kLight)))));
    add_camera_down(scene, camera_x, 0.5f * gap, 0, half_view);
    return scene;
}

std::vector<KnownCheck> light_above_plane_checks(double gap, double camera_x, double half_view) {
    const Rectangle view{camera_x - half_view, camera_x + half_view, -half_view, half_view};
    const double factor = parallel_form_factor(view, {-0.5, 0.5, -0.5, 0.5}, gap);
    return {equals("direct", kAlbedo * factor * kLight, 1), zero("indirect", 1), zero("emitted", 1)};
}

// ---- two patches, the lower one lit from far away past the upper one

const vec3 kOblique = glm::normalize(vec3(std::sqrt(3.0f), -1, 0));  // 60 degrees from the vertical
double oblique_slope() { return -double{kOblique.x} / double{kOblique.y}; }

Scene facing_patches(float half_lower, float half_upper, float gap, float camera_x, float half_view) {
    Scene scene;
    const uint32_t material = add_material(scene, grey());
    add_mesh(scene, level_rectangle(-half_lower, half_lower, -half_lower, half_lower, 0, true, material));
    add_mesh(scene, level_rectangle(-half_upper, half_upper, -half_upper, half_upper, gap, false, material));
    add_directional_light(scene, kOblique, Rgb(kLight));
    add_orthographic_camera(scene, {camera_x, 0.5 * double{gap}, 0}, {camera_x, 10, 0}, {0, 0, -1}, half_view);
    return scene;
}

std::vector<KnownCheck> facing_patches_checks(double half_lower, double half_upper, double gap, double camera_x,
                                              double half_view) {
    const Rectangle view{camera_x - half_view, camera_x + half_view, -half_view, half_view};
    const Rectangle lower{-half_lower, half_lower, -half_lower, half_lower};
    const double shift = gap * oblique_slope();  // of the upper patch's shadow
    const Rectangle shadow{std::max(lower.x0, shift - half_upper), std::min(lower.x1, shift + half_upper),
                           std::max(lower.y0, -half_upper), std::min(lower.y1, half_upper)};
    double factor = parallel_form_factor(view, lower, gap);
    if (shadow.x0 < shadow.x1) factor -= parallel_form_factor(view, shadow, gap);
    const dvec3 reflected = kAlbedo / kPiD * -double{kOblique.y} * kLight;
    return {equals("indirect", kAlbedo * factor * reflected, 1), zero("direct", 1)};
}

// ---- a lit floor and a wall that the light only grazes

constexpr Rectangle kWallView{0.01, 0.51, -0.25, 0.25};  // height, then along the wall

/// A floor of stripes along z, a wall at z = 0; the sun is in the zenith. Stripes by their bounds in x.
Scene floor_and_wall(const std::vector<float>& bounds, const std::vector<Rgb>& albedos) {
    Scene scene;
    std::vector<uint32_t> materials;
    materials.reserve(albedos.size());
    for (const Rgb& albedo : albedos) materials.push_back(add_material(scene, lambert("floor", albedo)));
    const uint32_t wall = add_material(scene, grey());
    std::vector<MeshBuilder> floors(albedos.size());
    for (size_t i = 0; i + 1 < bounds.size(); ++i) {
        const float x0 = bounds[i], x1 = bounds[i + 1];
        floors[i % floors.size()].quad({x0, 0, 2}, {x1, 0, 2}, {x1, 0, 0}, {x0, 0, 0});
    }
    for (size_t i = 0; i < floors.size(); ++i) add_mesh(scene, floors[i].build(materials[i]));
    add_mesh(scene, MeshBuilder().quad({-1, 0, 0}, {1, 0, 0}, {1, 2, 0}, {-1, 2, 0}).build(wall));
    add_directional_light(scene, {0, -1, 0}, Rgb(kLight));
    add_orthographic_camera(scene, {0, 0.26, 1}, {0, 0.26, 0}, {0, 1, 0}, 0.25f);
    return scene;
}

dvec3 wall_radiance(const Rectangle& view, const std::vector<float>& bounds, const std::vector<Rgb>& albedos) {
    dvec3 sum(0);
    for (size_t i = 0; i + 1 < bounds.size(); ++i)
        sum += perpendicular_form_factor(view, {0, 2, double{bounds[i]}, double{bounds[i + 1]}}) *
               dvec3(albedos[i % albedos.size()]);
    return kAlbedo / kPiD * sum * kLight;
}

/// The whole view, and its lowest eighth, at the edge.
std::vector<KnownCheck> wall_checks(const std::vector<float>& bounds, const std::vector<Rgb>& albedos) {
    const Rectangle low{kWallView.x0, kWallView.x0 + (kWallView.x1 - kWallView.x0) / 8, kWallView.y0, kWallView.y1};
    return {equals("indirect", wall_radiance(kWallView, bounds, albedos), 1),
            in_region(equals("indirect", wall_radiance(low, bounds, albedos), 1), {0, 0.875, 1, 1}), zero("direct", 1)};
}

const std::vector<Rgb> kGreyFloor{Rgb(static_cast<float>(kAlbedo))};
const std::vector<Rgb> kRedAndGreen{{0.75f, 0.125f, 0.125f}, {0.125f, 0.75f, 0.125f}};
const std::vector<float> kWholeFloor{-1, 1};
const std::vector<float> kTwoHalves{-1, 0.0137f, 1};  // on no voxel's boundary

std::vector<float> narrow_stripes() {
    constexpr int kStripes = 128;
    std::vector<float> bounds;
    for (int i = 0; i <= kStripes; ++i) bounds.push_back(static_cast<float>(i) * 2 / kStripes - 1);
    return bounds;
}

// ---- a wedge of 10 degrees

constexpr double kWedge = 10 * kPiD / 180;
constexpr double kWedgeFrom = 0.1, kWedgeTo = 0.5, kWedgeHalfWidth = 0.2;

dvec3 along_plate() { return {std::cos(kWedge), std::sin(kWedge), 0}; }
dvec3 below_plate() { return {std::sin(kWedge), -std::cos(kWedge), 0}; }

/// The light comes down along the upper plate: it lights the floor to its very edge and the plate not at all.
Scene wedge() {
    Scene scene;
    const uint32_t material = add_material(scene, grey());
    const vec3 end(along_plate());
    add_mesh(scene, level_rectangle(0, 1, -1, 1, 0, true, material));
    add_mesh(scene, MeshBuilder().quad({0, 0, -1}, {end.x, end.y, -1}, {end.x, end.y, 1}, {0, 0, 1}).build(material));
    add_directional_light(scene, -end, Rgb(kLight));
    const dvec3 middle = 0.5 * (kWedgeFrom + kWedgeTo) * along_plate();
    add_orthographic_camera(scene, middle + 0.005 * below_plate(), middle - below_plate(), along_plate(),
                            static_cast<float>(kWedgeHalfWidth));
    return scene;
}

std::vector<KnownCheck> wedge_checks() {
    const dvec3 floor[] = {{0, 0, 1}, {1, 0, 1}, {1, 0, -1}, {0, 0, -1}};
    constexpr int kAlong = 128, kAcross = 16;  // midpoints: the irradiance varies slowly over the view
    double sum = 0;
    for (int i = 0; i < kAlong; ++i)
        for (int j = 0; j < kAcross; ++j) {
            const double s = kWedgeFrom + (kWedgeTo - kWedgeFrom) * (i + 0.5) / kAlong;
            const dvec3 point = s * along_plate() + dvec3(0, 0, kWedgeHalfWidth * (2 * (j + 0.5) / kAcross - 1));
            sum += std::fabs(polygon_irradiance(point, below_plate(), floor));
        }
    const double irradiance = sum / (kAlong * kAcross);  // of a floor of radiance 1
    const dvec3 reflected = kAlbedo / kPiD * std::sin(kWedge) * kLight;
    return {equals("indirect", kAlbedo / kPiD * irradiance * reflected, 1, 1e-5)};
}

// ---- a red and a green face, back to back

/// Seen from above: the floor on both sides of a thin partition, each face lit level by its own sun.
Scene two_faced_partition() {
    Scene scene;
    constexpr float kHalf = 0.0005f;
    add_mesh(scene, level_rectangle(-1, 1, -1, 1, 0, true, add_material(scene, grey())));
    const uint32_t red = add_material(scene, lambert("red", kRedAndGreen[0]));
    const uint32_t green = add_material(scene, lambert("green", kRedAndGreen[1]));
    add_mesh(scene, MeshBuilder().quad({-kHalf, 0, -1}, {-kHalf, 0, 1}, {-kHalf, 1, 1}, {-kHalf, 1, -1}).build(red));
    add_mesh(scene, MeshBuilder().quad({kHalf, 0, 1}, {kHalf, 0, -1}, {kHalf, 1, -1}, {kHalf, 1, 1}).build(green));
    add_directional_light(scene, {1, 0, 0}, Rgb(kLight));
    add_directional_light(scene, {-1, 0, 0}, Rgb(kLight));
    add_camera_down(scene, 0, 2, 0, 0.5f);
    return scene;
}

std::vector<KnownCheck> two_faced_partition_checks() {
    // Of each side the outer three quarters in view: 0.125 to 0.5 from the middle.
    const double factor = perpendicular_form_factor({0.1245, 0.4995, -0.5, 0.5}, {0, 1, -1, 1});
    const auto radiance = [&](size_t face) { return kAlbedo / kPiD * factor * dvec3(kRedAndGreen[face]) * kLight; };
    return {in_region(equals("indirect", radiance(0), 1), {0, 0, 0.375, 1}),
            in_region(equals("indirect", radiance(1), 1), {0.625, 0, 1, 1}), zero("direct", 1)};
}

// ---- a floor far from edges

constexpr float kFar = 50;

Scene floor_far_from_edges() {
    Scene scene;
    const uint32_t material = add_material(scene, grey());
    add_mesh(scene, level_rectangle(-kFar, kFar, -kFar, kFar, 0, true, material));
    add_mesh(scene, MeshBuilder()
                        .quad({-kFar, 0, kFar}, {-kFar, 0, -kFar}, {-kFar, kFar, -kFar}, {-kFar, kFar, kFar})
                        .build(material));
    add_directional_light(scene, {-1, 0, 0}, Rgb(kLight));
    add_camera_down(scene, 0, 10, 0, 10);
    return scene;
}

std::vector<KnownCheck> floor_far_from_edges_checks() {
    const double far = double{kFar};
    const double factor = perpendicular_form_factor({far - 10, far + 10, -10, 10}, {0, far, -far, far});
    return {equals("indirect", kAlbedo * kAlbedo / kPiD * factor * kLight, 1), zero("direct", 1)};
}

// ---- a sphere

constexpr double kSphereAlbedo = 0.75;

Mesh sphere_from_inside(uint32_t material) {
    Mesh sphere = make_icosphere(4, material);
    for (uvec3& t : sphere.triangles) std::swap(t.y, t.z);
    return sphere;
}

Scene integrating_sphere() {
    Scene scene;
    add_mesh(scene, sphere_from_inside(add_material(scene, lambert("wall", Rgb(static_cast<float>(kSphereAlbedo))))));
    add_point_light(scene, vec3(0), Rgb(kLight));
    add_camera(scene, dvec3(0), dvec3(0, 0, -1), 1.2f);
    return scene;
}

/// A point of a sphere sends each part of it the same: direct light E = I / R^2 and each bounce albedo times that. The
/// facets hold the mean, flux over area; their distance from the centre varies by 6e-4 R, which is the tolerance.
std::vector<KnownCheck> integrating_sphere_checks() {
    const Mesh sphere = sphere_from_inside(0);
    double area = 0;
    for (const uvec3& t : sphere.triangles) {
        const dvec3 a(sphere.positions[t.x]), b(sphere.positions[t.y]), c(sphere.positions[t.z]);
        area += 0.5 * glm::length(glm::cross(b - a, c - a));
    }
    const dvec3 direct = kSphereAlbedo * 4 / area * kLight;
    constexpr double kFacets = 6e-4;
    return {equals("direct", direct, 1, kFacets), equals("indirect", kSphereAlbedo * direct, 1, kFacets),
            equals("indirect", kSphereAlbedo / (1 - kSphereAlbedo) * direct, {}, kFacets)};
}

}  // namespace

void add_patch_cases(std::vector<HardCase>& cases) {
    cases.push_back(patch_case("analytic-direct", "analytic direct", "light sampling",
                               "a rectangle light above a plane", light_above_plane_checks(1, 0.25, 0.5),
                               [] { return light_above_plane(1, 0.25f, 0.5f); }));
    constexpr const char* kFacing = "two facing patches";
    cases.push_back(patch_case("facing-patches", kFacing, "form factors", "one bounce between equal patches 1 m apart",
                               facing_patches_checks(0.5, 0.5, 1, 0, 0.45),
                               [] { return facing_patches(0.5f, 0.5f, 1, 0, 0.45f); }));
    cases.push_back(patch_case("facing-patches-flux", kFacing, "the flux of a photon or virtual light: the 1/pi",
                               "one bounce from a patch of 0.1 m to one of 1 m above it",
                               facing_patches_checks(0.05, 0.5, 0.5, 0, 0.45),
                               [] { return facing_patches(0.05f, 0.5f, 0.5f, 0, 0.45f); }));
    cases.push_back(patch_case("facing-patches-contact", kFacing, "singularity of virtual lights, splats at contact",
                               "one bounce into a gap of 0.01 m, at its lit edge",
                               facing_patches_checks(1, 0.5, 0.01f, -0.475f, 0.02f),
                               [] { return facing_patches(1, 0.5f, 0.01f, -0.475f, 0.02f); }));
    cases.push_back(patch_case("facing-patches-close-light", kFacing, "light sampling at contact",
                               "a rectangle light 0.01 m above a plane", light_above_plane_checks(0.01f, 0, 0.45),
                               [] { return light_above_plane(0.01f, 0, 0.45f); }));
    cases.push_back(patch_case("integrating-sphere", "integrating sphere, one bounce",
                               "photon density, curvature, disc filters",
                               "indirect light of a sphere lit from its centre: the same everywhere",
                               integrating_sphere_checks(), integrating_sphere));

    constexpr const char* kCorner = "corner, 90 and 10 degrees";
    std::vector<KnownCheck> corner = wall_checks(kWholeFloor, kGreyFloor);
    corner.push_back(reference("indirect", 4));
    cases.push_back(patch_case("corner-90", kCorner, "leaks, kernel clipping at edges",
                               "one bounce from a lit floor to a wall, at their common edge", std::move(corner),
                               [] { return floor_and_wall(kWholeFloor, kGreyFloor); }));
    cases.push_back(patch_case("corner-10", kCorner, "leaks, kernel clipping at edges",
                               "one bounce from a lit floor to a plate that leans 10 degrees from it", wedge_checks(),
                               wedge));

    constexpr const char* kColours = "a cell with two colours";
    cases.push_back(patch_case("two-colours", kColours, "what is averaged in a voxel",
                               "one bounce from a floor half red, half green", wall_checks(kTwoHalves, kRedAndGreen),
                               [] { return floor_and_wall(kTwoHalves, kRedAndGreen); }));
    cases.push_back(patch_case("two-colours-stripes", kColours, "what is averaged in a voxel",
                               "one bounce from a floor of red and green stripes 1/64 m wide",
                               wall_checks(narrow_stripes(), kRedAndGreen),
                               [] { return floor_and_wall(narrow_stripes(), kRedAndGreen); }));
    cases.push_back(patch_case("two-colours-back-to-back", kColours, "faces that look apart within a voxel",
                               "one bounce from a partition of 0.001 m, red on one side and green on the other",
                               two_faced_partition_checks(), two_faced_partition));
    cases.push_back(patch_case("floor-far-from-edges", "a floor far from edges",
                               "reach: no light is lost with distance",
                               "one bounce from a wall 50 m away onto the middle of a floor",
                               floor_far_from_edges_checks(), floor_far_from_edges));
}

}  // namespace photond
