#include "renderer/transport/light_tables.h"

#include <algorithm>
#include <string>

#include "protocol/error.h"
#include "renderer/transport/discrete_distribution.h"
#include "renderer/transport/emission_sampling.h"
#include "renderer/transport/emitter.h"
#include "renderer/transport/environment_sampling.h"
#include "renderer/transport/light_ends.h"
#include "renderer/transport/light_sampling.h"
#include "renderer/transport/light_tree.h"
#include "renderer/transport/light_triangle.h"
#include "renderer/transport/punctual.h"

namespace photond {

namespace {

static_assert(kNoEmitter == NO_EMITTER);
static_assert(LightTree::kNoLeaf == LEAF_NO_DEPTH);
static_assert(LightTree::kMostLevels <= 32 + LEAF_DEPTH_SHIFT, "a leaf's path fits its two words");

gpu::EmitterRecord to_device(const Emitter& e) {
    static_assert(static_cast<uint32_t>(Emitter::Shape::Triangle) == EMITTER_TRIANGLE &&
                  static_cast<uint32_t>(Emitter::Shape::Parallelogram) == EMITTER_PARALLELOGRAM &&
                  static_cast<uint32_t>(Emitter::Shape::Point) == EMITTER_POINT &&
                  static_cast<uint32_t>(Emitter::Shape::Spot) == EMITTER_SPOT);
    gpu::EmitterRecord out{};
    out.corner = e.corner;
    out.kind = static_cast<uint32_t>(e.shape) | (e.two_sided ? EMITTER_TWO_SIDED : 0) | (e.varies ? EMITTER_VARIES : 0);
    out.edge1 = e.edge1;
    out.instance = e.instance;
    out.edge2 = e.edge2;
    out.triangle = e.triangle;
    out.normal = e.normal;
    out.area_m2 = e.area_m2;
    out.radiance = e.radiance;
    return out;
}

gpu::EmitterRecord to_device(const LightTriangle& triangle, const TriangleLight& light) {
    gpu::EmitterRecord out{};
    out.corner = triangle.corner;
    out.kind = EMITTER_TRIANGLE | (light.two_sided ? EMITTER_TWO_SIDED : 0) | (triangle.varies ? EMITTER_VARIES : 0);
    out.edge1 = triangle.edge1;
    out.instance = light.instance;
    out.edge2 = triangle.edge2;
    out.triangle = light.triangle;
    out.normal = triangle.normal;
    out.area_m2 = light.area_m2;
    out.radiance = light.radiance;
    return out;
}

gpu::LightNodeRecord to_device(const LightTree::Node& node) {
    gpu::LightNodeRecord out{};
    out.centre = node.centre;
    out.radius = node.radius;
    out.axis = node.axis;
    out.cos_cone = node.cos_cone;
    out.sin_cone = node.sin_cone;
    out.cos_emission = node.cos_emission;
    out.intensity = node.intensity;
    out.link = node.right_or_light | (node.leaf ? LIGHT_NODE_LEAF : 0) | (node.two_sided ? LIGHT_NODE_TWO_SIDED : 0);
    return out;
}

gpu::PunctualLightRecord to_device(const PunctualLight& light) {
    static_assert(static_cast<uint32_t>(PunctualLight::Kind::Point) == PUNCTUAL_POINT &&
                  static_cast<uint32_t>(PunctualLight::Kind::Spot) == PUNCTUAL_SPOT &&
                  static_cast<uint32_t>(PunctualLight::Kind::Directional) == PUNCTUAL_DIRECTIONAL);
    gpu::PunctualLightRecord out{};
    out.intensity = light.intensity;
    out.kind = static_cast<uint32_t>(light.kind);
    out.position = light.position;
    out.range_m = light.range_m;
    out.direction = light.direction;
    out.cos_outer = light.cos_outer;
    if (light.kind == PunctualLight::Kind::Spot) {
        const SpotCone cone(light);
        const SpotCone::Shares shares = cone.shares();
        out.inverse_width = 1 / cone.width();
        out.plateau = static_cast<float>(shares.plateau);
        out.ramp = static_cast<float>(shares.ramp);
        out.reach = static_cast<float>(cone.width() * shares.top);
    }
    return out;
}

/// Appends them; where they begin.
template <class T>
uint32_t append(std::vector<T>& to, std::span<const T> numbers) {
    const size_t first = to.size();
    if (first + numbers.size() > UINT32_MAX)
        throw Error(ErrorCode::Unsupported, "", "the lights' tables are too large for the device");
    to.insert(to.end(), numbers.begin(), numbers.end());
    return static_cast<uint32_t>(first);
}

void add_light_sampler(LightTables& tables, const Scene& scene, const LightSampler& sampler) {
    if (sampler.tree().nodes().size() > LIGHT_NODE_INDEX)
        throw Error(ErrorCode::Unsupported, "",
                    std::to_string(sampler.emitters().size()) + " lights to choose from are more than the device's " +
                        std::to_string(LIGHT_NODE_INDEX / 2));
    gpu::LightConstants& constants = tables.constants;
    tables.emitters.reserve(sampler.emitters().size());
    for (const Emitter& emitter : sampler.emitters()) tables.emitters.push_back(to_device(emitter));
    tables.nodes.reserve(sampler.tree().nodes().size());
    for (const LightTree::Node& node : sampler.tree().nodes()) tables.nodes.push_back(to_device(node));
    constants.nodes = static_cast<uint32_t>(tables.nodes.size());

    std::vector<uint32_t> leaves;
    leaves.reserve(2 * sampler.tree().leaves().size());
    for (const LightTree::Leaf& leaf : sampler.tree().leaves()) {
        leaves.push_back(static_cast<uint32_t>(leaf.path));
        leaves.push_back(static_cast<uint32_t>(leaf.path >> 32) | uint32_t{leaf.depth} << LEAF_DEPTH_SHIFT);
    }
    constants.leaves = append<uint32_t>(tables.words, leaves);
    constants.first_of_instance = append(tables.words, sampler.first_of_instance());
    constants.emitter_of_triangle = append(tables.words, sampler.emitter_of_triangle());
    constants.directional = append(tables.words, sampler.directional());
    std::vector<uint32_t> of_punctual(scene.punctual_lights.size(), kNoEmitter);
    for (uint32_t e = 0; e < sampler.emitters().size(); ++e) {
        const Emitter& emitter = sampler.emitters()[e];
        if (emitter.shape >= Emitter::Shape::Point) of_punctual[emitter.instance] = e;
    }
    constants.emitter_of_punctual = append<uint32_t>(tables.words, of_punctual);
    constants.directional_lights = static_cast<uint32_t>(sampler.directional().size());
}

void add_emission_sampler(LightTables& tables, const Scene& scene, const EmissionSampler& sampler) {
    gpu::LightConstants& constants = tables.constants;
    const std::span<const LightTriangle> triangles = sampler.triangles();
    constants.triangle_lights = static_cast<uint32_t>(triangles.size());
    // Emitters are the triangles one by one, and points and spots after them, but where two are one parallelogram.
    const bool merged = std::ranges::any_of(
        tables.emitters, [](const gpu::EmitterRecord& e) { return (e.kind & EMITTER_SHAPE) == EMITTER_PARALLELOGRAM; });
    if (merged) {
        constants.first_triangle_light = static_cast<uint32_t>(tables.emitters.size());
        tables.emitters.reserve(tables.emitters.size() + triangles.size());
        for (size_t i = 0; i < triangles.size(); ++i)
            tables.emitters.push_back(to_device(triangles[i], scene.triangle_lights[i]));
    }
    if (sampler.choice().empty()) return;
    constants.choice_cdf = append(tables.floats, sampler.choice().cdf());
    constants.choice_guide = append(tables.words, sampler.choice().guide());
    constants.choice_guides = static_cast<uint32_t>(sampler.choice().guide().size()) - 1;
}

void add_environment(LightTables& tables, const Environment& environment, const EnvironmentSampler& sampler) {
    gpu::LightConstants& constants = tables.constants;
    const Size2 size = environment.map.size;
    constants.environment_width = size.width;
    constants.environment_height = size.height;
    constants.environment_scale = environment.scale;
    constants.environment_rotation = environment.rotation;
    constants.environment_mean_radiance = sampler.mean_radiance();
    std::vector<float> row_edges;
    for (uint32_t row = 0; row <= size.height; ++row) row_edges.push_back(sampler.row_edge(row));
    constants.row_cdf = append(tables.floats, sampler.row_cdf());
    constants.row_edges = append<float>(tables.floats, row_edges);
    constants.column_cdf = append(tables.floats, sampler.column_cdf());
    const EnvironmentSampler compensated(environment, EnvironmentDensity::Compensated);
    constants.compensated_row_cdf = append(tables.floats, compensated.row_cdf());
    constants.compensated_column_cdf = append(tables.floats, compensated.column_cdf());
    tables.environment = environment.map.radiance;
}

}  // namespace

LightTables make_light_tables(const Scene& scene) {
    const LightSampler light_sampler(scene);
    const EmissionSampler emission_sampler(scene);
    LightTables tables;
    add_light_sampler(tables, scene, light_sampler);
    const LightEnds ends(scene, light_sampler, emission_sampler);
    for (size_t e = 0; e < tables.emitters.size(); ++e) tables.emitters[e].emission_per_m2 = ends.emission_per_m2()[e];
    add_emission_sampler(tables, scene, emission_sampler);
    if (scene.environment) add_environment(tables, *scene.environment, *light_sampler.environment());
    for (const PunctualLight& light : scene.punctual_lights) tables.punctual_lights.push_back(to_device(light));
    tables.constants.punctual_lights = static_cast<uint32_t>(scene.punctual_lights.size());
    tables.constants.instances = static_cast<uint32_t>(scene.instances.size());
    tables.constants.centre = scene.bounds.centre();
    tables.constants.radius_m = scene.bounds.radius();
    return tables;
}

}  // namespace photond
