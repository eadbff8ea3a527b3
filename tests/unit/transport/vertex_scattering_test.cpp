// Densities of scattering at a vertex that two paths share: the same whichever of them is asked, and those that the
// paths are drawn by.

#include "renderer/transport/vertex_scattering.h"

#include <gtest/gtest.h>

#include "tests/support/leaning_triangle.h"
#include "tests/support/random_materials.h"

namespace photond::vertex_scattering_test {
namespace {

SurfaceVertex met_from(const Scene& scene, const vec3& from, float outside_ior) {
    SurfaceVertex vertex;
    vertex.from = from;
    vertex.point = make_shading_point(scene, test::kHit, -from);
    vertex.bsdf = make_bsdf(scene, vertex.point, outside_ior);
    return vertex;
}

/// Calls visit(case's name, scene, outside_ior) for all materials and normals.
template <class Visit>
void for_all_surfaces(const Visit& visit) {
    for (const test::Case& c : test::cases())
        for (const test::Normals normals : test::kAllNormals) {
            SCOPED_TRACE(testing::Message() << c.name << ", normals " << static_cast<int>(normals));
            visit(test::triangle_scene(c.material, normals), c.outside_ior);
        }
}

void expect_alike(float a, float b) { EXPECT_NEAR(a, b, 2e-4f * std::max({std::fabs(a), std::fabs(b), 1e-3f})); }

TEST(VertexScattering, IsTheSameFromBothEnds) {
    RandomStream random(1, RandomDomain::Test, 0, 0);
    size_t compared = 0;
    for_all_surfaces([&](const Scene& scene, float outside_ior) {
        for (int i = 0; i < 200; ++i) {
            // Off the horizon, where rounding decides on which side a direction is.
            vec3 to_eye = test::random_direction(random, 0.1f), to_light = test::random_direction(random, 0.1f);
            if (random.next() < 0.5f) to_eye.z = -to_eye.z;
            if (random.next() < 0.5f) to_light.z = -to_light.z;
            const SurfaceVertex eye = met_from(scene, to_eye, outside_ior),
                                light = met_from(scene, to_light, outside_ior);
            const EyeScattering onward = scatter_to_light(eye, to_light);
            const LightScattering back = scatter_to_eye(light, to_eye);
            ASSERT_EQ(is_black(onward.f_cos), is_black(back.density));
            if (is_black(onward.f_cos)) continue;
            ++compared;
            expect_alike(onward.eye_pdf, back.eye_pdf);
            expect_alike(onward.light_pdf, back.light_pdf);
            // density |cos_g(light)| / |cos_g(eye)| is f |cos_s(light)|.
            const float cosines = std::fabs(to_light.z / to_eye.z);
            for (int c = 0; c < 3; ++c) expect_alike(onward.f_cos[c], back.density[c] * cosines);
        }
    });
    EXPECT_GT(compared, 2000u);
}

TEST(VertexScattering, DensitiesAreThoseOfWhatIsDrawn) {
    RandomStream random(2, RandomDomain::Test, 0, 0);
    size_t compared = 0;
    for_all_surfaces([&](const Scene& scene, float outside_ior) {
        for (int i = 0; i < 200; ++i) {
            vec3 from = test::random_direction(random, 0.1f);
            if (random.next() < 0.5f) from.z = -from.z;
            const SurfaceVertex vertex = met_from(scene, from, outside_ior);
            const PhotonScattering photon =
                scatter_photon(vertex.point, vertex.bsdf, from, random.next(), random.next_2d());
            if (photon.valid() && !photon.delta) {
                ++compared;
                expect_alike(photon.pdf_sa, scatter_pdf(vertex.point, vertex.bsdf, from, photon.direction));
                const LightScattering scattering = scatter_to_eye(vertex, photon.direction);
                expect_alike(photon.pdf_sa, scattering.light_pdf);
                for (int c = 0; c < 3; ++c) expect_alike(photon.weight[c] * photon.pdf_sa, scattering.density[c]);
                expect_alike(scattering.eye_pdf, eye_pdf_back(vertex, photon.direction));
            }
            const Frame& frame = vertex.point.shading;
            const BsdfSample sample = vertex.bsdf.sample(frame.to_local(from), random.next(), random.next_2d());
            if (sample.valid() && !sample.delta) {
                const vec3 to = frame.to_world(sample.wi);
                const EyeScattering scattering = scatter_to_light(vertex, to);
                expect_alike(sample.pdf_sa, scattering.eye_pdf);
                expect_alike(scattering.light_pdf, light_pdf_back(vertex, to));
            }
        }
    });
    EXPECT_GT(compared, 2000u);
}

/// Share of the numbers by which `bsdf` sends `from` to `to`.
double choice_probability(const Bsdf& bsdf, const vec3& from, const vec3& to) {
    constexpr int kSteps = 2048;
    int found = 0;
    for (int i = 0; i < kSteps; ++i) {
        const BsdfSample sample = bsdf.sample(from, (float(i) + 0.5f) / kSteps, {0.3f, 0.6f});
        found += sample.valid() && sample.delta && glm::length(sample.wi - to) < 1e-3f ? 1 : 0;
    }
    return double(found) / kSteps;
}

/// What path weights take for granted of delta lobes: either path chooses them with one probability. (Where refraction
/// shares the choice with other lobes it is nearly so.)
TEST(VertexScattering, DeltaLobesAreChosenAlikeFromBothSides) {
    RandomStream random(3, RandomDomain::Test, 0, 0);
    size_t reflected = 0, refracted = 0;
    for (int i = 0; i < 2000; ++i) {
        Bsdf::Parameters p = test::random_material(random);
        p.geometric_normal = {0, 0, 1};
        p.roughness = 0;
        if (random.next() < 0.5f) p.metallic = 0, p.transmission = 1, p.solid = true;
        const bool pure = p.metallic == 0 && p.transmission == 1;
        const Bsdf bsdf = Bsdf::layered(p);
        const vec3 from = test::random_direction(random, 0.1f);
        const BsdfSample sample = bsdf.sample(from, random.next(), random.next_2d());
        if (!sample.valid() || !sample.delta || std::fabs(sample.wi.z) < 0.1f) continue;
        if (sample.refraction && !pure) continue;
        (sample.refraction ? refracted : reflected) += 1;
        // The way back, as met from the other end.
        const Bsdf other = sample.transmission ? bsdf.from_far_side({0, 0, 1}) : bsdf;
        const auto turned = [&](const vec3& w) { return sample.transmission ? vec3(w.x, w.y, -w.z) : w; };
        EXPECT_NEAR(choice_probability(other, turned(sample.wi), turned(from)),
                    choice_probability(bsdf, from, sample.wi), 5e-3)
            << "transmission " << p.transmission << ", solid " << p.solid;
    }
    EXPECT_GT(reflected, 300u);
    EXPECT_GT(refracted, 300u);
}

}  // namespace
}  // namespace photond::vertex_scattering_test
