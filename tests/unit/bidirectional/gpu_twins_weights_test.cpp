// The GLSL twins of path weights and of the camera's connections do what the C++ does.

#include <gtest/gtest.h>

#include "renderer/bidirectional/mis_weights.h"
#include "renderer/bidirectional/mis_weights_shared.h"
#include "renderer/eye/camera_connection.h"
#include "renderer/eye/eye_constants.h"
#include "tests/support/gpu_twin.h"
#include "tests/support/random_materials.h"

namespace photond::gpu_twins_weights_test {
namespace {

/// In the layout mis_weights.comp reads.
struct Query {
    gpu::TechniqueNumbers numbers;
    float direct, emission, cosine;
    uint32_t delta, infinite;
    float camera_pdf;
    float distance_sq[4], cos_in[4], pdf_back[4], acceptance[4];
    float pdf[2], cos_out[2];
    uint32_t delta_scattering[2];
    float more[4];
};
struct Answer {
    float weights[5];
};
static_assert(sizeof(Query) == 4 * (10 + 16 + 6 + 4));

VertexSide side_of(const Query& q, int vertex) { return {vertex % 2 == 0, q.pdf_back[vertex], q.acceptance[vertex]}; }

void follow(const Mis& mis, const Query& q, int path, SubpathWeights& w) {
    mis.arrive(w, q.distance_sq[2 * path], q.cos_in[2 * path]);
    if (q.delta_scattering[path])
        mis.scatter_delta(w, q.cos_out[path]);
    else
        mis.scatter(w, side_of(q, 2 * path), q.pdf[path], q.cos_out[path]);
    mis.arrive(w, q.distance_sq[2 * path + 1], q.cos_in[2 * path + 1]);
}

Answer weigh(const Mis& mis, const Query& q) {
    const TechniqueNumbers n{q.numbers.light_paths, q.numbers.connections, q.numbers.merges != 0,
                             q.numbers.caustic_radius};
    const LightEnd end{q.direct, q.emission, q.cosine, q.delta != 0, q.infinite != 0};
    SubpathWeights light = mis.start_light(end), eye = mis.start_eye(q.camera_pdf);
    mis.direct_at_first_hit(light, q.direct);
    follow(mis, q, 0, light);
    follow(mis, q, 1, eye);
    const VertexSide light_side = side_of(q, 1), eye_side = side_of(q, 3);
    return {{mis.light_met(eye, end, n), mis.next_event(eye, eye_side, q.more[0], q.more[1], q.more[2], end, n),
             mis.seen_by_camera(light, light_side, q.more[3], n),
             mis.connection(eye, eye_side, q.more[0], light, light_side, q.more[1], n),
             mis.merging(eye, eye_side, light, light_side, n)}};
}

TEST(GpuTwinsWeights, WeightsAreThoseOfTheCpu) {
    RandomStream random(1, RandomDomain::Test, 0, 0);
    const auto spread = [&](float octaves) { return std::exp2(octaves * (random.next() - 0.5f)); };
    std::vector<Query> queries(5000);
    for (Query& q : queries) {
        q.numbers = {1000 * spread(6), random.next() < 0.2f ? 0 : spread(4), random.next() < 0.5f, random.next()};
        q.direct = spread(8), q.emission = spread(8), q.cosine = random.next() + 1e-3f;
        q.delta = random.next() < 0.2f, q.infinite = random.next() < 0.2f;
        q.camera_pdf = 1000 * spread(6);
        for (int i = 0; i < 4; ++i) {
            q.distance_sq[i] = spread(8), q.cos_in[i] = random.next() + 1e-3f, q.pdf_back[i] = spread(8);
            q.acceptance[i] = 1e-3f * spread(6), q.more[i] = spread(8);
        }
        for (int i = 0; i < 2; ++i)
            q.pdf[i] = spread(8), q.cos_out[i] = random.next() + 1e-3f, q.delta_scattering[i] = random.next() < 0.2f;
    }
    const test::PartOfScene none{};
    for (const MisHeuristic heuristic : {MisHeuristic::Balance, MisHeuristic::Power}) {
        const test::Twin twin("tests/gpu/mis_weights.comp", &none.set(),
                              {gpu::specialize(MIS_POWER_ID, heuristic == MisHeuristic::Power)});
        const auto answers = twin.run<Answer>(queries.size(), {{"queries", queries}});
        const Mis mis(heuristic);
        for (size_t i = 0; i < queries.size(); ++i) {
            const Answer wanted = weigh(mis, queries[i]);
            for (int way = 0; way < 5; ++way)
                ASSERT_NEAR(answers[i].weights[way], wanted.weights[way], 1e-5f) << i << ", way " << way;
        }
    }
}

TEST(GpuTwinsWeights, CamerasSeeWhatTheCpusSee) {
    struct CameraQuery {
        vec3 point;
        vec2 lens;
        vec3 direction;
    };
    struct CameraAnswer {
        vec2 film;
        vec3 to_camera, target;
        float distance, pdf, responsivity_per_m2;
        float direction_pdf;
        uint32_t valid;
    };
    static_assert(sizeof(CameraQuery) == 32 && sizeof(CameraAnswer) == 52);
    const Size2 size{40, 30};
    RandomStream random(2, RandomDomain::Test, 0, 0);
    for (const bool orthographic : {false, true})
        for (const float aperture_m : {0.0f, 0.2f}) {
            Camera camera = look_at_camera({1, 2, 3}, {0, 0.5, -1}, {0, 1, 0}, 0.8f);
            camera.orthographic = orthographic, camera.ymag = 1.5f;
            camera.aperture_radius_m = aperture_m, camera.focus_distance_m = 2.5f;
            std::vector<CameraQuery> queries(2000);
            for (CameraQuery& q : queries) {
                q.point = 8.0f * vec3(random.next(), random.next(), random.next()) - 4.0f;
                q.lens = random.next_2d();
                q.direction = glm::normalize(camera.forward + 0.5f * test::random_direction(random, -1));
            }
            const std::vector constants{make_eye_constants({camera, size}, 1, 1).camera};
            const auto answers = test::run_twin<CameraAnswer>("tests/gpu/camera_connection.comp", queries.size(),
                                                              {{"camera", constants}, {"queries", queries}});
            const CameraConnector connector{CameraRays(camera, size)};
            for (size_t i = 0; i < queries.size(); ++i) {
                const CameraAnswer& a = answers[i];
                const auto seen = connector.connect(queries[i].point, queries[i].lens);
                ASSERT_EQ(a.valid != 0, seen.has_value()) << i;
                ASSERT_NEAR(a.direction_pdf / connector.pdf(queries[i].direction).pdf, 1, 1e-4f);
                // At the rim, and near the lens, rounding is magnified.
                if (!seen || seen->distance < 0.1f || glm::dot(-seen->to_camera, camera.forward) < 0.1f) continue;
                ASSERT_LE(glm::distance(a.film, seen->film), 1e-4f * (glm::length(seen->film) + 1));
                ASSERT_LE(glm::distance(a.to_camera, seen->to_camera), 1e-5f);
                ASSERT_LE(glm::distance(a.target, seen->target), 1e-5f);
                ASSERT_NEAR(a.distance, seen->distance, 1e-5f * seen->distance);
                ASSERT_NEAR(a.pdf / seen->pdf, 1, 1e-4f);
                ASSERT_NEAR(a.responsivity_per_m2 / seen->responsivity_per_m2, 1, 1e-4f);
            }
        }
}

}  // namespace
}  // namespace photond::gpu_twins_weights_test
