// The hard cases: what is promised of each scene, that the closed forms are right (against quadrature that shares
// nothing with them), and that path tracing reaches the answers.

#include "renderer/scene/hard_cases.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "protocol/error.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/hard_case_answers.h"
#include "tests/support/path_render.h"
#include "tests/support/statistics.h"

namespace photond::hard_cases_test {
namespace {

using Relation = KnownCheck::Relation;

constexpr double kFalseAlarm = 1e-6;  // of all comparisons with path tracing together

std::vector<const HardCase*> scene_cases() {
    std::vector<const HardCase*> scenes;
    for (const HardCase& hard_case : hard_cases())
        if (hard_case.make) scenes.push_back(&hard_case);
    return scenes;
}

// ---- closed forms

/// Form factor between rectangles by the midpoint rule over both; `place` puts a rectangle's point into space.
template <class PlaceFrom, class PlaceTo>
double integrated_form_factor(const Rectangle& from, const Rectangle& to, const PlaceFrom& place_from,
                              const dvec3& normal_from, const PlaceTo& place_to, const dvec3& normal_to) {
    constexpr int kSteps = 24;
    double sum = 0;
    const auto point = [](const Rectangle& r, int i, int j) {
        return std::pair{r.x0 + (r.x1 - r.x0) * (i + 0.5) / kSteps, r.y0 + (r.y1 - r.y0) * (j + 0.5) / kSteps};
    };
    for (int i = 0; i < kSteps * kSteps; ++i)
        for (int j = 0; j < kSteps * kSteps; ++j) {
            const auto [x, y] = point(from, i % kSteps, i / kSteps);
            const auto [u, v] = point(to, j % kSteps, j / kSteps);
            const dvec3 between = place_to(u, v) - place_from(x, y);
            const double distance_sq = glm::dot(between, between);
            sum += glm::dot(between, normal_from) * -glm::dot(between, normal_to) / (M_PI * distance_sq * distance_sq);
        }
    return sum * to.area() / std::pow(kSteps, 4);
}

TEST(HardCaseAnswers, FormFactorsAgreeWithQuadratureAndTheCatalogue) {
    // Opposite and adjacent faces of a cube [Howell 1982].
    EXPECT_NEAR(parallel_form_factor({0, 1, 0, 1}, {0, 1, 0, 1}, 1), 0.199825, 1e-6);
    EXPECT_NEAR(perpendicular_form_factor({0, 1, 0, 1}, {0, 1, 0, 1}), 0.200044, 1e-6);
    const Rectangle a{0.3, 1.1, -0.4, 0.5}, b{0.2, 0.9, 0.1, 1.4};
    const double parallel = integrated_form_factor(
        a, b, [](double x, double y) { return dvec3(x, y, 0); }, dvec3(0, 0, 1),
        [](double x, double y) { return dvec3(x, y, 0.7); }, dvec3(0, 0, -1));
    EXPECT_NEAR(parallel_form_factor(a, b, 0.7), parallel, 1e-3 * parallel);
    const double perpendicular = integrated_form_factor(
        a, b, [](double x, double y) { return dvec3(x, y, 0); }, dvec3(0, 0, 1),
        [](double x, double y) { return dvec3(0, y, x); }, dvec3(1, 0, 0));
    EXPECT_NEAR(perpendicular_form_factor(a, b), perpendicular, 1e-3 * perpendicular);
}

TEST(HardCaseAnswers, PolygonsAndSolidAnglesAgreeWithWhatIsKnown) {
    // A point below the corner of a rectangle: half of a/sqrt(1+a^2) atan(b/sqrt(1+a^2)) and its mirror.
    const dvec3 square[] = {{0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {1, 0, 1}};
    const double exact = std::sqrt(0.5) * std::atan(std::sqrt(0.5));
    EXPECT_NEAR(std::fabs(polygon_irradiance(dvec3(0), dvec3(0, 0, 1), square)), exact, 1e-12);
    EXPECT_NEAR(triangle_solid_angle({1, 0, 0}, {0, 1, 0}, {0, 0, 1}), M_PI / 2, 1e-12);
    // At alpha 1 and normal incidence single scattering keeps 1 - ln 2 (D = 1/pi, G = 2c/(1 + c)).
    EXPECT_NEAR(ggx_directional_albedo(1, 1), 1 - std::log(2.0), 1e-4);
    EXPECT_NEAR(ggx_directional_albedo(0.01, std::sqrt(0.5)), 1, 1e-4);
}

// ---- scenes

TEST(HardCases, AreWholeAndNamedOnce) {
    std::set<std::string> names;
    for (const HardCase& hard_case : hard_cases()) {
        SCOPED_TRACE(hard_case.name);
        EXPECT_TRUE(hard_case.name.starts_with("hard-case/"));
        EXPECT_TRUE(names.insert(hard_case.name).second);
        EXPECT_FALSE(hard_case.answer.row.empty() || hard_case.answer.strains.empty() || hard_case.answer.text.empty());
        EXPECT_NE(bool(hard_case.make), !hard_case.test.empty()) << "a scene, or a test in its place";
        EXPECT_EQ(hard_case.answer.checks.empty(), !hard_case.test.empty());
    }
    EXPECT_EQ(builtin_scene_names("hard-cases").size(), scene_cases().size());
    EXPECT_THROW(builtin_scene_names("hard-case"), Error);
}

TEST(HardCases, ChecksSayWhatTheirRelationNeeds) {
    const std::set<std::string_view> layers{"beauty", "direct", "indirect", "emitted"};
    for (const HardCase* hard_case : scene_cases())
        for (const KnownCheck& check : hard_case->answer.checks) {
            SCOPED_TRACE(hard_case->name);
            const bool valued = check.relation == Relation::Equals || check.relation == Relation::AtMost;
            EXPECT_EQ(check.value.has_value(), valued);
            EXPECT_EQ(!check.same_as.empty(), check.relation == Relation::SameAs);
            EXPECT_TRUE(check.same_as.empty() || find_hard_case(check.same_as)) << check.same_as;
            EXPECT_TRUE(layers.contains(check.layer));
            const auto& [x0, y0, x1, y1] = check.region;
            EXPECT_TRUE(0 <= x0 && x0 < x1 && x1 <= 1 && 0 <= y0 && y0 < y1 && y1 <= 1);
            // On whole pixels, so that the mean over pixels is the mean over the region.
            for (const double edge : {x0 * hard_case->answer.size.width, x1 * hard_case->answer.size.width,
                                      y0 * hard_case->answer.size.height, y1 * hard_case->answer.size.height})
                EXPECT_EQ(edge, std::round(edge));
            for (int c = 0; check.value && c < 3; ++c) EXPECT_TRUE(std::isfinite((*check.value)[c]));
            EXPECT_GE(check.tolerance, 0);
        }
}

TEST(HardCases, ScenesAreSmallAndSound) {
    for (const HardCase* hard_case : scene_cases()) {
        SCOPED_TRACE(hard_case->name);
        const Scene scene = make_builtin_scene(hard_case->name);
        EXPECT_EQ(scene.name, hard_case->name);
        EXPECT_EQ(find_camera(scene, "").name, "camera");
        EXPECT_LE(scene.triangle_count, 50'000u) << "the list must stay fast";
        EXPECT_TRUE(std::isfinite(scene.bounds.radius()));
        for (const Mesh& mesh : scene.meshes)
            for (const uvec3& t : mesh.triangles) ASSERT_LT(std::max({t.x, t.y, t.z}), mesh.positions.size());
    }
}

// ---- path tracing

/// Pixels of a check's layer, times of one image.
struct Rendered {
    std::vector<float> beauty, emitted, direct, indirect;
    const std::vector<float>& layer(std::string_view name) const {
        if (name == "emitted") return emitted;
        if (name == "direct") return direct;
        return name == "indirect" ? indirect : beauty;
    }
};

constexpr Size2 kSize{16, 16};

Rendered path_traced(const Scene& scene, std::optional<uint32_t> bounces, uint64_t seed, uint32_t passes) {
    test::RenderSettings settings;
    settings.size = kSize;
    settings.passes = passes;
    settings.seed = seed;
    settings.params.indirect_bounces = bounces;
    const Film film = test::render(scene, settings);
    return {film.resolve_beauty(), film.resolve(Layer::Emitted), film.resolve(Layer::Direct),
            film.resolve(Layer::Indirect)};
}

double region_mean(const std::vector<float>& pixels, const KnownCheck& check, size_t channel) {
    const auto& [x0, y0, x1, y1] = check.region;
    double sum = 0, count = 0;
    for (uint32_t y = uint32_t(y0 * kSize.height); y < uint32_t(y1 * kSize.height); ++y)
        for (uint32_t x = uint32_t(x0 * kSize.width); x < uint32_t(x1 * kSize.width); ++x, ++count)
            sum += double(pixels[3 * (size_t{y} * kSize.width + x) + channel]);
    return sum / count;
}

constexpr size_t kReplicates = 12;
constexpr std::string_view kLongest = "hard-case/furnace-albedo-99";  // paths of hundreds of vertices

/// Of the cases whose light is found by few paths, more are followed.
uint32_t passes_of(const std::string& name) {
    if (name == kLongest) return 64;
    if (name == "hard-case/facing-patches-flux") return 128;
    return name == "hard-case/two-colours-stripes" ? 32 : 8;
}

/// Path tracing itself breaks here: where two solids share a face, a ray meets either first and steps over the other,
/// and which solid it is in is lost.
bool breaks_path_tracing(const std::string& name) { return name == "hard-case/touching-dielectrics"; }

size_t count_of_comparisons() {
    size_t count = 0;
    for (const HardCase* hard_case : scene_cases())
        for (const KnownCheck& check : hard_case->answer.checks)
            count += check.value || check.relation == Relation::SameAs;
    return count;
}

/// The images of kReplicates seeds.
std::vector<Rendered> images_of(const std::string& name, std::optional<uint32_t> bounces) {
    const Scene scene = make_builtin_scene(name);
    std::vector<Rendered> images;
    for (uint64_t seed = 1; seed <= kReplicates; ++seed)
        images.push_back(path_traced(scene, bounces, seed, passes_of(name)));
    return images;
}

void expect_value(const std::vector<double>& means, const KnownCheck& check, const std::string& name) {
    const double exact = check.value->x;
    const test::Interval measured = test::mean_interval(means, kFalseAlarm, count_of_comparisons());
    if (exact == 0) {  // nothing varies about nothing
        EXPECT_EQ(measured.mean, 0);
        return;
    }
    constexpr double kFloat = 1e-5;  // of numbers added up in single precision
    const double slack = measured.half_width + (check.tolerance + kFloat) * exact;
    if (check.relation == Relation::Equals && !breaks_path_tracing(name))
        EXPECT_LE(std::abs(measured.mean - exact), slack) << "measured " << measured.mean << ", exact " << exact;
    else
        EXPECT_LE(measured.mean - slack, exact);
    constexpr double kMustDetect = 0.5;
    EXPECT_LE(2 * measured.half_width, kMustDetect * exact) << "too noisy to notice a defect";
}

void expect_known_answer(const HardCase& hard_case, const KnownCheck& check, const std::vector<Rendered>& images) {
    std::vector<double> means;
    for (const Rendered& image : images) {
        const std::vector<float>& pixels = image.layer(check.layer);
        const auto [least, most] = std::minmax_element(pixels.begin(), pixels.end());
        EXPECT_TRUE(*least >= 0 && std::isfinite(*most));
        EXPECT_TRUE(check.relation != Relation::Zero || *most == 0) << *most;
        means.push_back(region_mean(pixels, check, 0));
    }
    if (check.value) expect_value(means, check, hard_case.name);
}

template <class Wanted>
void expect_known_answers(const Wanted& wanted) {
    for (const HardCase* hard_case : scene_cases()) {
        if (!wanted(hard_case->name)) continue;
        std::map<std::optional<uint32_t>, std::vector<Rendered>> images;  // by bounces
        for (const KnownCheck& check : hard_case->answer.checks) {
            if (check.relation == Relation::SameAs || check.relation == Relation::Reference) continue;
            SCOPED_TRACE(hard_case->name + " " + std::string(check.layer));
            std::vector<Rendered>& of_depth = images[check.bounces];
            if (of_depth.empty()) of_depth = images_of(hard_case->name, check.bounces);
            expect_known_answer(*hard_case, check, of_depth);
        }
    }
}

TEST(HardCases, PathTracingReachesTheKnownAnswers) {
    expect_known_answers([](const std::string& name) { return name != kLongest; });
}

TEST(LongHardCases, PathTracingReachesTheKnownAnswerOfTheDeepestFurnace) {
    expect_known_answers([](const std::string& name) { return name == kLongest; });
}

TEST(HardCases, PathTracingSeesOneRoomInAllItsGuises) {
    std::map<std::string, std::vector<Rendered>> images;  // by scene
    const auto images_once = [&](const std::string& name, const KnownCheck& check) -> const std::vector<Rendered>& {
        std::vector<Rendered>& of_scene = images[name];
        if (of_scene.empty()) of_scene = images_of(name, check.bounces);
        return of_scene;
    };
    for (const HardCase* hard_case : scene_cases())
        for (const KnownCheck& check : hard_case->answer.checks) {
            if (check.relation != Relation::SameAs) continue;
            SCOPED_TRACE(hard_case->name);
            std::vector<double> excess;  // relative to the other scene's image of the same seed
            for (size_t i = 0; i < kReplicates; ++i) {
                const double mine = region_mean(images_once(hard_case->name, check)[i].layer(check.layer), check, 0);
                const double other = region_mean(images_once(check.same_as, check)[i].layer(check.layer), check, 0);
                excess.push_back(mine / (check.scale * other) - 1);
            }
            const test::Interval measured = test::mean_interval(excess, kFalseAlarm, count_of_comparisons());
            EXPECT_LE(std::abs(measured.mean), measured.half_width + 1e-4) << measured.mean;
            EXPECT_LE(measured.half_width, 0.1) << "too noisy to notice a defect";
        }
}

}  // namespace
}  // namespace photond::hard_cases_test
