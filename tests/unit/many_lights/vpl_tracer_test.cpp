// What virtual lights promise beside the right flux (statistical/vpl_flux_test): bits that do not depend on threads,
// the order, limits, which intersector finds what, roulette that drops none where it need not, and the area they light.

#include "renderer/many_lights/vpl_tracer.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstring>

#include "renderer/scene/builtin_families.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/mesh_builder.h"
#include "renderer/transport/bsdf.h"
#include "tests/support/photons.h"
#include "tests/support/threads.h"

namespace photond::vpl_tracer_test {
namespace {

using test::PhotonScene;
using Spread = ReflectedPhoton::Spread;

VplTracing settings(uint32_t vpls, uint32_t bounces = 1, uint32_t map_side = 64) {
    return {.vpls = vpls, .map_side = map_side, .bounces = bounces};
}

TracedReflections trace(const PhotonScene& lit, const VplTracing& tracing, uint64_t seed = 1, uint32_t pass = 0,
                        const TexelImportance& importance = {}) {
    Stats stats;
    return VplTracer(lit.scene, *lit.intersector, *lit.intersector, lit.emission, tracing)
        .trace(seed, pass, importance, stats, CancelToken{});
}

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}
bool same(const TracedReflections& a, const TracedReflections& b) {
    return same_bits(a.photons, b.photons) && same_bits(a.surfaces, b.surfaces);
}

/// A floor that a spot light looks at straight from above: a disc of radius 0.97.
Scene lit_floor(const Material& material) {
    Scene scene;
    add_mesh(scene,
             MeshBuilder().quad({-3, 0, 3}, {3, 0, 3}, {3, 0, -3}, {-3, 0, -3}).build(add_material(scene, material)));
    PunctualLight spot;
    spot.kind = PunctualLight::Kind::Spot;
    spot.position = {0, 2, 0};
    spot.direction = {0, -1, 0};
    spot.cos_inner = 0.95f;
    spot.cos_outer = 0.9f;
    scene.punctual_lights.push_back(spot);
    finish_scene(scene);
    return scene;
}

/// The Cornell box with a glass ball and coated walls: lights of both spreads, and paths through glass.
Scene mixed_scene() {
    Scene scene = make_builtin_scene("cornell-box-glass");
    for (Material& material : scene.materials)
        if (is_black(material.emission) && material.specular == 0) {
            material = plastic("coated", material.base_color, 0.8f);
            break;
        }
    finish_scene(scene);
    return scene;
}

float half_of_it(const ReflectedPhoton& photon) { return photon.position.x < 0 ? 0.0f : 1.0f; }

TEST(VplTracer, TheSameForAnyNumberOfThreadsAndAPureFunctionOfThePass) {
    const PhotonScene lit(mixed_scene());
    for (const TexelImportance& importance : {TexelImportance{}, TexelImportance(half_of_it)}) {
        std::vector<TracedReflections> traced;
        for (const int threads : {1, 2, 8})
            traced.push_back(
                test::on_threads(threads, [&] { return trace(lit, settings(3'000, 3), 1, 4, importance); }));
        EXPECT_FALSE(traced[0].surfaces.empty());
        for (const TracedReflections& other : traced) {
            EXPECT_TRUE(same(traced[0], other));
            EXPECT_EQ(traced[0].counts.photon_rays, other.counts.photon_rays);
        }
        EXPECT_FALSE(same(traced[0], trace(lit, settings(3'000, 3), 2, 4, importance)));
        EXPECT_FALSE(same(traced[0], trace(lit, settings(3'000, 3), 1, 5, importance)));
    }
}

// In a closed room of Lambert reflectors each path leaves a light at its first hit, and their powers are alike.
TEST(VplTracer, FirstLightsAreAllThereAndAlike) {
    const PhotonScene lit(make_builtin_scene("cornell-box"));
    for (const uint32_t bounces : {1u, 3u}) {
        const TracedReflections traced = trace(lit, settings(2'000, bounces));
        EXPECT_EQ(traced.paths, 2'000u);
        EXPECT_EQ(traced.counts.photons_emitted, 2'000u);
        EXPECT_EQ(traced.counts.photons_stored, traced.photons.size());
        size_t first = 0;
        float least = kInfinity, most = 0;
        for (const ReflectedPhoton& photon : traced.photons) {
            EXPECT_EQ(photon.spread(), Spread::Lambert);
            EXPECT_LE(photon.scatterings(), bounces);
            if (photon.scatterings() > 1) continue;
            ++first;
            least = std::min(least, max_component(photon.power_w));
            most = std::max(most, max_component(photon.power_w));
        }
        EXPECT_GE(first, 1'999u);  // the last bit of a hope
        EXPECT_LT(most, 1.0001f * least);
    }
}

// Pixels of a block share the lights out by their indices: each 16th light, from any, sees to all of the scene. Squares
// of how far such a subset's mean place is from that of all, against those of subsets by chance.
TEST(VplTracer, EveryNthLightIsSpreadAsAllAre) {
    const PhotonScene lit(make_builtin_scene("cornell-box"));
    for (const uint32_t stride : {4u, 9u, 16u, 25u}) {
        double squares = 0, by_chance = 0;
        for (uint32_t pass = 0; pass < 8; ++pass) {
            const std::vector<ReflectedPhoton> lights = trace(lit, settings(1'024), 1, pass).photons;
            dvec3 mean(0), variance(0);
            for (const ReflectedPhoton& p : lights) mean += dvec3(p.position) / double(lights.size());
            for (const ReflectedPhoton& p : lights)
                variance += (dvec3(p.position) - mean) * (dvec3(p.position) - mean) / double(lights.size());
            for (size_t first = 0; first < stride; ++first) {
                dvec3 sum(0);
                double count = 0;
                for (size_t i = first; i < lights.size(); i += stride) sum += dvec3(lights[i].position), ++count;
                const dvec3 off = sum / count - mean;
                squares += glm::dot(off, off);
                by_chance += (variance.x + variance.y + variance.z) / count;
            }
        }
        EXPECT_LT(squares, 0.5 * by_chance) << stride;
    }
}

// Fewer bounces: the same lights without the others.
TEST(VplTracer, BouncesAreLimited) {
    const PhotonScene lit(mixed_scene());
    VplTracing tracing = settings(1'500, 4);
    const TracedReflections all = trace(lit, tracing);
    std::vector<size_t> of(5);
    size_t ordered = 0;
    for (size_t i = 0; i < all.photons.size(); ++i) {
        const uint32_t s = all.photons[i].scatterings();
        ASSERT_GE(s, 1u);
        ASSERT_LE(s, 4u);
        EXPECT_NE(all.photons[i].spread(), Spread::Beam);
        ++of[s];
        ordered += i > 0 && s > all.photons[i - 1].scatterings();
    }
    for (const uint32_t s : {2u, 3u, 4u}) EXPECT_GT(of[s], 20u) << s;
    EXPECT_GT(ordered, 500u);  // a path's lights come one behind the other
    EXPECT_LE(all.photons.size(), 4u * 1'500u);
    EXPECT_TRUE(trace(lit, settings(1'500, 0)).photons.empty());
    // Among paths that go on from a mirror at once the choice of texels differs; in a Lambert room it is the same.
    const PhotonScene room(make_builtin_scene("cornell-box"));
    const TracedReflections two = trace(room, settings(1'500, 2)), one = trace(room, settings(1'500, 1));
    std::vector<vec3> firsts;
    for (const ReflectedPhoton& photon : two.photons)
        if (photon.scatterings() == 1) firsts.push_back(photon.position);
    ASSERT_EQ(firsts.size(), one.photons.size());
    for (size_t i = 0; i < firsts.size(); ++i) EXPECT_EQ(firsts[i], one.photons[i].position);
}

// A mirror leaves no light but sends paths on, where there may be a second scattering.
TEST(VplTracer, PathsGoOnThroughMirrors) {
    Scene scene = lit_floor(metal("mirror", Rgb(0.9f), 0));
    const uint32_t ceiling = add_material(scene, lambert("ceiling", Rgb(0.5f)));
    add_mesh(scene, MeshBuilder().quad({-9, 4, -9}, {9, 4, -9}, {9, 4, 9}, {-9, 4, 9}).build(ceiling));
    finish_scene(scene);
    const PhotonScene lit(std::move(scene));
    EXPECT_TRUE(trace(lit, settings(500, 1)).photons.empty());
    const TracedReflections traced = trace(lit, settings(500, 2));
    EXPECT_GT(traced.photons.size(), 200u);
    for (const ReflectedPhoton& photon : traced.photons) {
        EXPECT_EQ(photon.scatterings(), 2u);
        EXPECT_EQ(photon.spread(), Spread::Lambert);
        EXPECT_NEAR(photon.position.y, 4, 1e-4f);
    }
}

// Lobes narrower than the threshold leave no light.
TEST(VplTracer, NarrowLobesLeaveNoLight) {
    const PhotonScene narrow(lit_floor(metal("narrow", Rgb(0.8f), 0.4f))),
        wide(lit_floor(metal("wide", Rgb(0.8f), 0.5f)));
    EXPECT_TRUE(trace(narrow, settings(500)).photons.empty());    // alpha 0.16
    const TracedReflections lights = trace(wide, settings(500));  // 0.25
    EXPECT_GT(lights.photons.size(), 400u);
    EXPECT_EQ(lights.photons.size(), lights.surfaces.size());
    for (size_t i = 0; i < lights.photons.size(); ++i) {
        ASSERT_EQ(lights.photons[i].surface, i);
        const ReflectingSurface& surface = lights.surfaces[i];
        const ShadingPoint point = make_shading_point(wide.scene, surface.hit, -surface.wi_world);
        EXPECT_EQ(point.position, lights.photons[i].position);
        const Rgb albedo = make_bsdf(wide.scene, point, surface.outside_ior).rough_part(0.2f).albedo();
        EXPECT_EQ(lights.photons[i].power_w, surface.arriving_power_w * albedo);
    }
}

TEST(VplTracer, NoneWithoutLightOrReflectors) {
    const Scene lit = lit_floor(lambert("floor", Rgb(0.5f)));
    EXPECT_EQ(trace(PhotonScene(lit), settings(300)).photons.size(), 300u);
    Scene dark = lit, black = lit, unlit = lit, empty;
    dark.punctual_lights.clear();
    black.materials[0].base_color = Rgb(0);
    unlit.materials[0].unlit = true;
    for (Scene* scene : {&dark, &black, &unlit, &empty}) {
        finish_scene(*scene);
        const PhotonScene none(*scene);
        for (const uint32_t side : {1u, 64u}) {
            const TracedReflections traced = trace(none, settings(300, 2, side));
            EXPECT_TRUE(traced.photons.empty());
            EXPECT_EQ(traced.paths, 300u);
        }
        const VplTracer tracer(none.scene, *none.intersector, *none.intersector, none.emission, settings(300));
        EXPECT_EQ(tracer.lit_area_m2(1), 0);
    }
}

TEST(VplTracer, StopsWhenCancelledAndNamesItsStages) {
    const PhotonScene lit(make_builtin_scene("cornell-box"));
    const VplTracer tracer(lit.scene, *lit.intersector, *lit.intersector, lit.emission, settings(1000));
    CancelToken cancel;
    Stats stats;
    tracer.trace(1, 0, {}, stats, cancel);
    ASSERT_EQ(stats.stages.size(), 2u);
    EXPECT_EQ(stats.stages[0].name, "rsm");
    EXPECT_EQ(stats.stages[1].name, "vpl_generation");
    cancel.cancel();
    EXPECT_EQ(tracer.trace(1, 0, {}, stats, cancel).counts.photon_rays, 0u);
}

/// Counts what it is asked.
class CountingIntersector final : public Intersector {
public:
    explicit CountingIntersector(const Intersector& real) : real_(real) {}
    Hit closest_hit(const Ray& ray) const override { return ++rays, real_.closest_hit(ray); }
    bool occluded(const Ray& ray) const override { return real_.occluded(ray); }
    void closest_hits(std::span<const Ray> all, std::span<Hit> hits, Coherence coherence) const override {
        rays += all.size();
        real_.closest_hits(all, hits, coherence);
    }
    void occluded(std::span<const Ray> all, std::span<uint8_t> are, Coherence coherence) const override {
        real_.occluded(all, are, coherence);
    }
    uint64_t bytes() const override { return real_.bytes(); }

    mutable std::atomic<uint64_t> rays{0};

private:
    const Intersector& real_;
};

TEST(VplTracer, LaterHitsAreFoundByTheOther) {
    const PhotonScene lit(make_builtin_scene("cornell-box"));
    const CountingIntersector first(*lit.intersector), later(*lit.intersector);
    Stats stats;
    const TracedReflections traced =
        VplTracer(lit.scene, first, later, lit.emission, settings(700, 3, 32)).trace(1, 0, {}, stats, CancelToken{});
    EXPECT_EQ(first.rays, 32u * 32u + 700u);
    EXPECT_GT(later.rays, 500u);
    EXPECT_EQ(traced.counts.photon_rays, first.rays + later.rays);
}

// An importance moves lights but leaves a quarter to the flux; one that is nowhere leaves all of it.
TEST(VplTracer, AnImportanceMovesLights) {
    const PhotonScene lit(lit_floor(lambert("floor", Rgb(0.5f))));
    const auto on_the_left = [](const TracedReflections& traced) {
        return std::count_if(traced.photons.begin(), traced.photons.end(),
                             [](const ReflectedPhoton& p) { return p.position.x < 0; });
    };
    const VplTracing tracing = settings(2'000);
    EXPECT_NEAR(double(on_the_left(trace(lit, tracing))), 1'000, 30);
    EXPECT_NEAR(double(on_the_left(trace(lit, tracing, 1, 0, half_of_it))), 250, 20);
    const TracedReflections nowhere = trace(lit, tracing, 1, 0, [](const ReflectedPhoton&) { return 0.0f; });
    EXPECT_TRUE(same(nowhere, trace(lit, tracing)));
    for (const ReflectedPhoton& photon : trace(lit, tracing, 1, 0, half_of_it).photons)
        EXPECT_LE(max_component(photon.power_w), 4.01f * max_component(nowhere.photons[0].power_w));
}

TEST(VplTracer, LitAreaIsAboutWhatIsLit) {
    const auto area = [](const PhotonScene& lit, uint32_t side) {
        return VplTracer(lit.scene, *lit.intersector, *lit.intersector, lit.emission, settings(10, 1, side))
            .lit_area_m2(1);
    };
    const PhotonScene floor(lit_floor(lambert("floor", Rgb(0.5f))));
    const double disc = double{kPi} * sqr(2 * std::tan(std::acos(0.9f)));
    EXPECT_NEAR(area(floor, 128), disc, 0.15 * disc);
    EXPECT_NEAR(area(floor, 32), disc, 0.4 * disc);
    EXPECT_GT(area(floor, 1), 0);
    EXPECT_LE(area(floor, 1), 36.01);
    // A tilted square room with a light in it: all of its walls, however they lie to the axes.
    for (const float turn : {0.0f, 0.4f}) {
        Scene scene;
        MeshBuilder walls;
        const auto turned = [&](const vec3& p) {
            return vec3(p.x * std::cos(turn) - p.y * std::sin(turn), p.x * std::sin(turn) + p.y * std::cos(turn), p.z);
        };
        for (int axis = 0; axis < 3; ++axis)
            for (const float side : {-1.0f, 1.0f}) {
                vec3 n(0), a(0), b(0);
                n[axis] = side, a[(axis + 1) % 3] = side, b[(axis + 2) % 3] = 1;
                walls.quad(turned(n - a - b), turned(n - a + b), turned(n + a + b), turned(n + a - b));
            }
        add_mesh(scene, walls.build(add_material(scene, lambert("wall", Rgb(0.5f)))));
        scene.punctual_lights = {PunctualLight{}};
        finish_scene(scene);
        const PhotonScene room(std::move(scene));
        EXPECT_NEAR(area(room, 128), 24, 1.2) << turn;
        EXPECT_LE(area(room, 128), 24.001);
    }
}

}  // namespace
}  // namespace photond::vpl_tracer_test
