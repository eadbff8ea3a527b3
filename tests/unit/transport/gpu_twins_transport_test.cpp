// The GLSL twins of the small functions of transport, photons and geometry, over many random arguments.

#include <gtest/gtest.h>

#include "renderer/core/rng.h"
#include "renderer/methods/photon_splatting/connect_weight.h"
#include "renderer/photons/kernel.h"
#include "renderer/transport/fresnel.h"
#include "renderer/transport/mis.h"
#include "renderer/transport/sampling.h"
#include "tests/support/gpu_twin.h"

namespace photond::gpu_twins_transport_test {
namespace {

using namespace test;

/// transport_maths.comp's.
struct Results {
    vec3 cosine_hemisphere;
    vec2 triangle;
    vec2 fresnel;
    vec3 heuristics;
    vec3 tangent, bitangent, offset;
    float connect;
    vec2 kernels[4];
};
static_assert(sizeof(Results) == 4 * 28);

constexpr KernelShape kShapes[] = {KernelShape::Constant, KernelShape::Cone, KernelShape::Gaussian,
                                   KernelShape::Epanechnikov};

TEST(GpuTwinsTransport, FunctionsAreThoseOfTheCpu) {
    RandomStream random(1, RandomDomain::Test, 0, 0);
    std::vector<vec4> arguments(20'000);
    for (vec4& a : arguments) {
        const vec2 xy = random.next_2d();
        a = vec4(xy, random.next_2d());
    }
    std::vector<Kernel> kernels;
    std::vector<gpu::KernelRecord> records;
    for (const KernelShape shape : kShapes) {
        kernels.emplace_back(shape, 1.3f);
        records.push_back(kernels.back().device_record());
    }
    const auto results = run_twin<Results>("tests/gpu/transport_maths.comp", arguments.size(),
                                           {{"kernels", records}, {"arguments", arguments}});
    for (size_t i = 0; i < arguments.size(); ++i) {
        SCOPED_TRACE(i);
        const vec4 a = arguments[i];
        const Results& r = results[i];
        ASSERT_LE(glm::distance(r.cosine_hemisphere, sample_cosine_hemisphere(vec2(a))), 1e-6f / r.cosine_hemisphere.z);
        ASSERT_EQ(r.triangle, sample_triangle(vec2(a)));
        const DielectricFresnel fresnel = fresnel_dielectric(a.x, 2 * a.y);
        // Near total reflection the cosine is the root of what rounding leaves of 1 - sin^2.
        const float sin2_t = (1 - sqr(a.x)) / sqr(2 * a.y);
        if (std::fabs(1 - sin2_t) > 1e-5f) {
            ASSERT_NEAR(r.fresnel.x, fresnel.reflectance, 1e-5f + 1e-5f / std::sqrt(std::fabs(1 - sin2_t)));
            ASSERT_NEAR(r.fresnel.y, fresnel.cos_t, 2e-6f * (1 + sin2_t) / std::sqrt(std::fabs(1 - sin2_t)));
        }
        const vec3 heuristics(balance_heuristic(a.x, a.y), power_heuristic(a.x, a.y),
                              area_to_solid_angle_pdf(a.x, a.y, a.z));
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(r.heuristics[c], heuristics[c], 2e-6f * heuristics[c]);
        // Rounding of the normal itself is magnified where it nearly points along -z.
        const Frame frame(glm::normalize(vec3(a) - 0.5f));
        const float pole = std::max(1 - std::fabs(frame.normal.z), 0.1f);
        ASSERT_LE(glm::distance(r.tangent, frame.tangent), 2e-6f / pole);
        ASSERT_LE(glm::distance(r.bitangent, frame.bitangent), 2e-6f / pole);
        // Near the origin the offset is a share of a rounded cosine, elsewhere a whole number of units in the last
        // place.
        const vec3 p = std::exp2(20 * (a.w - 0.5f)) * (vec3(a.y, a.z, a.x) - 0.5f);
        const vec3 offset = offset_ray_origin(p, frame.normal);
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(r.offset[c], offset[c], 2e-6f * std::fabs(p[c]) + 4e-12f);
        const float connect = connect_factor(FloatLanes(4 * sqr(a.x)), FloatLanes(a.y), sqr(a.z) + 1e-6f, a.w)[0];
        ASSERT_NEAR(r.connect, connect, 2e-5f * connect);
        for (size_t k = 0; k < kernels.size(); ++k) {
            ASSERT_NEAR(r.kernels[k].x, kernels[k](a.x), 2e-6f) << k;
            // The twin inverts what is found by bisection here; both feel the rounding of u where the density is low.
            ASSERT_NEAR(r.kernels[k].y, kernels[k].sample_disc(a.y), 3e-6f + 1e-6f / std::max(a.y, 1e-3f)) << k;
        }
    }
}

}  // namespace
}  // namespace photond::gpu_twins_transport_test
