// The GLSL twins of photons' scattering and of the stack of media do what the C++ does.

#include <gtest/gtest.h>

#include "renderer/backends/gpu/scene_bindings.h"
#include "renderer/backends/gpu/scene_shared.h"
#include "renderer/transport/medium_stack.h"
#include "tests/support/gpu_photon_scattering.h"
#include "tests/support/random_materials.h"

namespace photond::gpu_twins_scattering_test {
namespace {

using namespace test;

float relative_difference(const Rgb& a, const Rgb& b) {
    const float most = std::max(max_component(a), max_component(b));
    return most > 0 ? max_component(glm::abs(a - b)) / most : 0.0f;
}

TEST(GpuTwinsScattering, PhotonsScatterAsOnTheCpu) {
    constexpr size_t kQueries = 2000;
    const std::vector<Case> all = cases();
    size_t valid = 0, below = 0, other_choice = 0, far_off = 0;
    RandomStream random(1, RandomDomain::Test, 0, 0);
    for (const size_t which : {0u, 1u, 7u, 8u}) {
        const Case& c = all[which];
        // Leaning normals, and mapped ones beside.
        Scene scene = triangle_scene(c.material, which % 2 ? Normals::Leaning : Normals::LeaningAndMapped);
        finish_scene(scene);
        std::vector<ScatteringQuery> queries(kQueries);
        for (ScatteringQuery& q : queries) {
            q.wi = random_direction(random, -1);
            const float u_lobe = random.next();
            q.numbers = vec3(u_lobe, random.next_2d());
            q.outgoing = random_direction(random, -1);
        }
        const auto answers = GpuPhotonScattering(scene).scatter(kHit, c.part, c.outside_ior, queries);
        for (size_t i = 0; i < kQueries; ++i) {
            SCOPED_TRACE(std::string(c.name) + ", query " + std::to_string(i));
            const ScatteringQuery& q = queries[i];
            const ShadingPoint point = make_shading_point(scene, kHit, -q.wi);
            const Bsdf bsdf = part_of(make_bsdf(scene, point, c.outside_ior), c.part);
            const PhotonScattering expected =
                scatter_photon(point, bsdf, q.wi, q.numbers.x, vec2(q.numbers.y, q.numbers.z));
            const PhotonScattering& s = answers[i].scattering;
            // Rounding of grazing cosines, and of half-vectors of lobes no narrower than alpha = 0.04.
            const auto tolerance = [&](const vec3& out) {
                float grazing = std::min(std::fabs(q.wi.z), std::fabs(out.z));
                for (const vec3& w : {q.wi, out}) grazing = std::min(grazing, std::fabs(dot(w, point.smooth_normal)));
                return 1e-4f + 1e-5f / grazing;
            };
            const auto compare = [&](const Rgb& found, const Rgb& wanted, const vec3& out) {
                const float difference = relative_difference(found, wanted);
                far_off += difference > tolerance(out);
                ASSERT_LE(difference, 100 * tolerance(out));
            };
            compare(answers[i].density, scatter_density(point, bsdf, q.wi, q.outgoing), q.outgoing);
            compare(Rgb(answers[i].pdf_sa), Rgb(scatter_pdf(point, bsdf, q.wi, q.outgoing)), q.outgoing);
            // On a border between lobes, frames or sides rounding decides.
            if (s.valid() != expected.valid() || s.delta != expected.delta || s.refraction != expected.refraction) {
                ++other_choice;
                continue;
            }
            if (!s.valid()) continue;
            ++valid,
                below += glm::dot(s.direction, point.smooth_normal) * glm::dot(s.direction, point.geometric_normal) < 0;
            ASSERT_LE(glm::distance(s.direction, expected.direction), 5e-5f);
            compare(s.weight, expected.weight, expected.direction);
            compare(Rgb(s.pdf_sa), Rgb(expected.pdf_sa), expected.direction);
        }
    }
    EXPECT_LE(other_choice, 3u);
    EXPECT_LE(far_off, 8u);  // near total reflection: what is let through is a root of what rounding leaves
    EXPECT_GT(valid, 3000u);
    EXPECT_GT(below, 100u);  // where the eye's frame is not the photon's
}

TEST(GpuTwinsScattering, StacksOfMediaAreThoseOfTheCpu) {
    struct Step {
        uint32_t material;
        uint32_t from_front;
    };
    struct Answer {
        uint32_t top, outside;
        float outside_ior;
        Rgb transmittance;
    };
    constexpr size_t kWalks = 500, kSteps = 16;
    Scene scene;
    std::vector<gpu::MaterialRecord> records;
    RandomStream random(2, RandomDomain::Test, 0, 0);
    for (uint32_t i = 0; i < 6; ++i) {
        Material m;
        m.solid = i != 2;
        m.ior = 1 + random.next();
        m.attenuation_color = Rgb(random.next(), i == 3 ? 0.0f : 1.0f, random.next());
        if (i != 1) m.attenuation_distance = 0.1f + random.next();
        gpu::MaterialRecord record{};
        record.ior = m.ior;
        record.flags = m.solid ? MATERIAL_SOLID : 0;
        record.attenuation_color = m.attenuation_color;
        record.attenuation_distance = m.attenuation_distance;
        records.push_back(record);
        scene.materials.push_back(m);
    }
    std::vector<Step> steps(kWalks * kSteps);
    for (Step& s : steps) s = {random.next_bits() % 6, random.next_bits() % 3 ? 1u : 0u};  // deeper than the stack

    const PartOfScene part{{MATERIALS_BINDING, std::as_bytes(std::span(records))}};
    const Twin twin("tests/gpu/medium_stack.comp", &part.set());
    const Absorption absorption(scene);
    for (const float distance : {0.0f, 0.3f, kInfinity}) {
        const auto answers = twin.run<Answer>(steps.size(), {{"distance", std::vector{distance}}, {"steps", steps}});
        for (size_t walk = 0; walk < kWalks; ++walk) {
            MediumStack media;
            for (size_t k = walk * kSteps; k < (walk + 1) * kSteps; ++k) {
                const Step& s = steps[k];
                ASSERT_EQ(answers[k].outside, media.outside_of(s.material, !s.from_front));
                ASSERT_EQ(answers[k].outside_ior, media.outside_ior(scene, s.material, !s.from_front));
                media.cross(s.material, s.from_front != 0);
                ASSERT_EQ(answers[k].top, media.top());
                const Rgb expected = absorption.transmittance(media, distance);
                for (int c = 0; c < 3; ++c) ASSERT_NEAR(answers[k].transmittance[c], expected[c], 2e-6f);
            }
        }
    }
}

}  // namespace
}  // namespace photond::gpu_twins_scattering_test
