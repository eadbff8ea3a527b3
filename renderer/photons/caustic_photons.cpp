#include "renderer/photons/caustic_photons.h"

#include <algorithm>
#include <cstdio>

#include "renderer/core/rng.h"
#include "renderer/photons/pilot_radius.h"
#include "renderer/photons/projection_map.h"
#include "renderer/photons/radius_schedule.h"

namespace photond {

namespace {

// The pilot's photons share no numbers with a pass's, nor do they depend on its seed: nor does then the bias.
constexpr uint64_t kPilotSeed = reference_seed(0);
constexpr uint32_t kPilotPaths = 16'384;
constexpr uint32_t kPilotNearest = 8;    // photons among which the pilot's density is measured
constexpr double kPhotonsInRadius = 40;  // of a pass, where caustics are bright
constexpr double kBrightShare = 0.25;    // of the power is where they are brighter
constexpr float kMostRelative = 0.03f;   // of the radius of the scene's bounding sphere
constexpr float kLeastRelative = 1e-5f;

}  // namespace

bool has_specular_surface(const Scene& scene, float glossy_threshold) {
    if (scene.needs.delta) return true;
    for (const Instance& instance : scene.instances) {
        const Mesh& mesh = scene.meshes[instance.mesh];
        const Material& m = scene.materials[mesh.material];
        if (mesh.triangles.empty() || m.unlit) continue;
        if (m.metallic == 0 && m.specular == 0 && m.transmission == 0) continue;
        const float least_roughness = m.metallic_roughness_texture.used() ? 0.0f : m.roughness;
        if (sqr(least_roughness) < glossy_threshold) return true;
    }
    return false;
}

Rgb CausticMap::radiance(const ShadingPoint& point, const Bsdf& rough, const vec3& wo, uint32_t most_scatterings,
                         Neighbours& scratch) const {
    if (map.empty() || most_scatterings == 0) return Rgb(0);
    return estimate_radiance(map, estimate, point, rough, wo, most_scatterings, scratch).radiance;
}

Rgb CausticMap::irradiance(const vec3& position, const vec3& geometric_normal, const vec3& normal,
                           uint32_t most_scatterings, Neighbours& scratch) const {
    if (map.empty() || most_scatterings == 0) return Rgb(0);
    ShadingPoint point;
    point.position = position;
    point.geometric_normal = geometric_normal;
    point.smooth_normal = normal;
    point.shading = Frame(normal);
    const Bsdf white = Bsdf::lambert(point.shading.to_local(geometric_normal), Rgb(1));
    return kPi * radiance(point, white, vec3(0, 0, 1), most_scatterings, scratch);
}

struct CausticPhotons::Shared {
    Shared(const Scene& scene, const Intersector& intersector, const EmissionSampler& emission,
           const CausticSettings& asked, uint64_t of_seed)
        : settings(asked),
          seed(of_seed),
          guide(scene, intersector, emission, ProjectionTarget::SpecularSurfaces, asked.glossy_threshold, of_seed) {}

    PhotonTracing tracing(uint32_t paths) const {
        return {.kind = PhotonMapKind::Caustic,
                .photons = paths,
                .most_scatterings = settings.most_scatterings,
                .glossy_threshold = settings.glossy_threshold,
                .sampler = settings.sampler,
                .guide = guide.helps() ? &guide : nullptr};
    }

    const CausticSettings settings;
    const uint64_t seed;
    const ProjectionMap guide;
    std::optional<PhotonTracer> tracer;
    float radius_m = 0;  // of the first pass
    double photons_a_path = kExpectedCausticYield;
};

CausticPhotons::CausticPhotons(const Scene& scene, const Intersector& intersector, const EmissionSampler& emission,
                               const CausticSettings& settings, uint64_t seed, Stats& stats) {
    const StageTimer timer(stats, "photon_emission");
    auto shared = std::make_unique<Shared>(scene, intersector, emission, settings, seed);
    stats.counts.photon_rays += shared->guide.pilot_rays();
    if (!shared->guide.helps())
        stats.skipped.push_back({"projection map", shared->guide.text(), shared->guide.bytes()});
    shared->tracer.emplace(scene, intersector, emission, shared->tracing(settings.photons));
    // A scene without extent holds nothing to be found, but a search wants a radius.
    const float scene_radius_m = std::max(scene.bounds.radius(), 1e-16f);
    const float most_m = kMostRelative * scene_radius_m, least_m = kLeastRelative * scene_radius_m;
    if (settings.radius_m) {
        shared->radius_m = *settings.radius_m;
    } else {
        const uint32_t paths = std::min(settings.photons, kPilotPaths);
        TracedPhotons pilot =
            PhotonTracer(scene, intersector, emission, shared->tracing(paths)).trace(kPilotSeed, 0, CancelToken{});
        stats.counts.photon_rays += pilot.counts.photon_rays;
        shared->photons_a_path = static_cast<double>(pilot.photons.size()) / paths;
        const PhotonSearch search{PhotonSearch::Kind::Nearest, kPilotNearest, most_m};
        const float wanted_m =
            radius_of_pilot(PhotonMap(std::move(pilot.photons), search),
                            {.photons_in_radius = kPhotonsInRadius,
                             .bright_share = kBrightShare,
                             .paths_over_pilot = static_cast<double>(settings.photons) / static_cast<double>(paths)});
        shared->radius_m = std::clamp(wanted_m, least_m, most_m);
    }
    shared_ = std::move(shared);
}
CausticPhotons::~CausticPhotons() = default;

float CausticPhotons::radius_m(uint32_t pass) const { return shared_->radius_m * radius_share(pass); }

CausticMap CausticPhotons::trace(uint32_t pass, Stats& stats, const CancelToken& cancel) const {
    TracedPhotons traced;
    {
        const StageTimer timer(stats, "photon_tracing");
        traced = shared_->tracer->trace(shared_->seed, pass, cancel);
    }
    stats.counts += traced.counts;
    if (cancel.cancelled()) return {};
    const StageTimer timer(stats, "photon_map_build");
    return {.map = PhotonMap(std::move(traced.photons), {PhotonSearch::Kind::Radius, 2, radius_m(pass)}),
            .estimate = estimate(),
            .glossy_threshold = shared_->settings.glossy_threshold};
}

/// A kernel that falls to its rim: of the same noise it has less bias at edges of caustics than a constant one.
EstimateSettings CausticPhotons::estimate() {
    return {.kernel = Kernel(KernelShape::Epanechnikov), .disc_thickness_m = {}, .soft_disc = false};
}

PhotonTracing CausticPhotons::tracing() const { return shared_->tracing(shared_->settings.photons); }
double CausticPhotons::photons_a_path() const { return shared_->photons_a_path; }

uint64_t CausticPhotons::bytes() const { return shared_->guide.bytes(); }

uint64_t CausticPhotons::estimate_bytes(uint64_t lights, size_t threads) {
    return ProjectionMap::estimate_bytes(lights) + PhotonTracer::scratch_bytes(threads);
}

uint64_t CausticPhotons::map_bytes(const CausticSettings& settings, double yield) {
    return PhotonMap::bytes_for(static_cast<uint64_t>(yield * settings.photons) + 1);
}

}  // namespace photond
