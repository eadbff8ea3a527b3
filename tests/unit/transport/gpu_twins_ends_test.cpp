// The GLSL twins of what bidirectional methods ask of lights and of vertices do what the C++ does: densities by both
// samplers, and scattering between two paths.

#include <gtest/gtest.h>

#include "renderer/backends/gpu/device_scene.h"
#include "renderer/transport/environment_sampling.h"
#include "renderer/transport/light_ends.h"
#include "renderer/transport/light_tables_shared.h"
#include "renderer/transport/vertex_scattering.h"
#include "tests/support/gpu_twin.h"
#include "tests/support/leaning_triangle.h"
#include "tests/support/lit_rooms.h"
#include "tests/support/random_materials.h"

namespace photond::gpu_twins_ends_test {
namespace {

using namespace test;

/// In the layout light_ends.comp reads.
struct EndQuery {
    vec3 p, n, wi;
    vec3 light_numbers;
    float distance;
    float u_light;
    vec2 u_position, u_direction;
};
struct End {
    float direct, emission, cosine;
    uint32_t delta, infinite;
};
struct EndAnswer {
    End of_sample;
    float pdf_direct_sa;
    End of_emission;
    float direct_at_first_hit;
    End of_environment;
};
static_assert(sizeof(EndQuery) == 72 && sizeof(EndAnswer) == 68);

bool alike(float a, float b, float tolerance) { return std::fabs(a - b) <= tolerance * std::max(std::fabs(a), 1e-6f); }

/// Where a number falls within rounding of a border between lights, the two draw from different ones.
bool alike(const End& found, const LightEnd& end) {
    constexpr float kTolerance = 1e-3f;
    return found.delta == uint32_t{end.delta} && found.infinite == uint32_t{end.infinite} &&
           alike(found.direct, end.direct, kTolerance) && alike(found.emission, end.emission, kTolerance) &&
           alike(found.cosine, end.cosine, kTolerance);
}

TEST(GpuTwinsEnds, LightsHaveTheDensitiesOfTheCpu) {
    const Scene scene = room_of_all_lights();
    const LightSampler lights(scene, EnvironmentDensity::Compensated);  // as those who weigh light's ends have it
    const EmissionSampler emission(scene);
    const LightEnds ends(scene, lights, emission);
    RandomStream random(7, RandomDomain::Test, 0, 0);
    std::vector<EndQuery> queries(8000);
    for (EndQuery& q : queries) {
        q.p = vec3(3 * random.next() - 1.5f, 0.01f, 3 * random.next() - 1.5f);
        q.n = random.next() < 0.2f ? vec3(0) : vec3(0, 1, 0);
        q.wi = random_direction(random, 0.05f);
        q.light_numbers = vec3(random.next(), random.next_2d());
        q.distance = 0.5f + random.next();
        q.u_light = random.next();
        q.u_position = random.next_2d(), q.u_direction = random.next_2d();
    }
    const gpu::DeviceScene on_device(gpu_device(), scene);
    const std::vector<gpu::Specialization> fixed =
        on_device.specialization(std::vector{gpu::specialize(LIGHT_SAMPLES_COMPENSATED_ID, true)});
    const auto answers = Twin("tests/gpu/light_ends.comp", &on_device.set(), fixed)
                             .run<EndAnswer>(queries.size(), {{"queries", queries}});
    size_t sampled = 0, emitted = 0, apart = 0;
    for (size_t i = 0; i < queries.size(); ++i) {
        const EndQuery& q = queries[i];
        const EndAnswer& a = answers[i];
        apart += !alike(a.of_environment, ends.of_environment(q.p, q.n, q.wi));
        LightSample light;
        const bool lit = lights.sample(q.p, q.n, q.light_numbers.x, {q.light_numbers.y, q.light_numbers.z}, light);
        if (lit && a.pdf_direct_sa > 0) {
            float pdf_direct_sa = 0;
            const LightEnd end = ends.of_sample(light, pdf_direct_sa);
            ++sampled, apart += !alike(a.of_sample, end) || !alike(a.pdf_direct_sa, pdf_direct_sa, 1e-3f);
        } else {
            apart += lit || a.pdf_direct_sa > 0;
        }
        EmissionSample start;
        const bool carries = emission.sample(q.u_light, q.u_position, q.u_direction, start);
        if (carries && a.direct_at_first_hit >= 0) {
            ++emitted;
            apart += !alike(a.of_emission, ends.of_emission(start)) ||
                     !alike(a.direct_at_first_hit, ends.direct_at_first_hit(start, q.p, q.n, q.distance), 1e-3f);
        } else {
            apart += carries || a.direct_at_first_hit >= 0;
        }
    }
    EXPECT_GT(sampled, 4000u);
    EXPECT_GT(emitted, 7000u);
    EXPECT_LE(apart, 40u);
}

/// In the layout vertex_scattering.comp reads.
struct VertexQuery {
    vec3 from, to;
};
struct VertexAnswer {
    Rgb f_cos;
    float eye_pdf, light_pdf;
    Rgb density;
    float density_light_pdf, density_eye_pdf;
    vec3 lit_normal;
};
static_assert(sizeof(VertexAnswer) == 52);

TEST(GpuTwinsEnds, VerticesScatterAsOnTheCpu) {
    struct Place {
        Hit hit;
        float outside_ior;
    };
    const std::vector<Case> all = cases();
    RandomStream random(8, RandomDomain::Test, 0, 0);
    size_t compared = 0, apart = 0;
    for (const size_t which : {0u, 1u, 3u, 8u}) {
        const Case& c = all[which];
        // Leaning normals, and mapped ones beside.
        Scene scene = triangle_scene(c.material, which % 2 ? Normals::Leaning : Normals::LeaningAndMapped);
        finish_scene(scene);
        std::vector<VertexQuery> queries(2000);
        for (VertexQuery& q : queries) {
            q.from = random_direction(random, 0.05f), q.to = random_direction(random, 0.05f);
            if (random.next() < 0.3f) q.from.z = -q.from.z;
            if (random.next() < 0.3f) q.to.z = -q.to.z;
        }
        const gpu::DeviceScene on_device(gpu_device(), scene);
        const std::vector place{Place{kHit, c.outside_ior}};
        const auto answers = Twin("tests/gpu/vertex_scattering.comp", &on_device.set(), on_device.specialization())
                                 .run<VertexAnswer>(queries.size(), {{"place", place}, {"queries", queries}});
        for (size_t i = 0; i < queries.size(); ++i) {
            const VertexQuery& q = queries[i];
            const VertexAnswer& a = answers[i];
            SurfaceVertex vertex;
            vertex.from = q.from;
            vertex.point = make_shading_point(scene, kHit, -q.from);
            vertex.bsdf = make_bsdf(scene, vertex.point, c.outside_ior);
            const EyeScattering eye = scatter_to_light(vertex, q.to);
            const LightScattering light = scatter_to_eye(vertex, q.to);
            const float found[] = {a.f_cos.x,   a.eye_pdf,           a.light_pdf,
                                   a.density.y, a.density_light_pdf, a.density_eye_pdf};
            const float wanted[] = {eye.f_cos.x,     eye.eye_pdf,     eye.light_pdf,
                                    light.density.y, light.light_pdf, light.eye_pdf};
            for (size_t k = 0; k < std::size(found); ++k) apart += !alike(found[k], wanted[k], 2e-3f);
            compared += !is_black(eye.f_cos);
            ASSERT_LE(glm::distance(a.lit_normal, lit_normal(vertex)), 1e-5f);
        }
    }
    EXPECT_GT(compared, 3000u);
    EXPECT_LE(apart, 40u);  // of 48,000, where rounding of half-vectors and of grazing cosines is magnified
}

}  // namespace
}  // namespace photond::gpu_twins_ends_test
