#include "renderer/methods/radiance_cache/cached_paths.h"

#include <algorithm>

#include "renderer/eye/eye_contributions.h"
#include "renderer/transport/hit_prefetch.h"
#include "renderer/transport/roulette_shared.h"

namespace photond {

namespace {

Rgb inverse_of(const Rgb& albedo) {
    Rgb inverse;
    for (int c = 0; c < 3; ++c) inverse[c] = albedo[c] > 0 ? 1 / albedo[c] : 0.0f;
    return inverse;
}

/// Calls visit(level) for the levels that a sample belongs to, the finest first, until that says false.
template <class Visit>
void for_each_level(const CellGrid& grid, uint32_t finest, float spread_m, const Visit& visit) {
    for (uint32_t coarser = 0; coarser <= CellGrid::kCoarserLevels && coarser <= finest; ++coarser)
        if (grid.side_m(finest - coarser) > spread_m || !visit(finest - coarser)) return;
}

}  // namespace

uint32_t cell_direction(const Bsdf& rough, const vec3& to_eye, uint32_t direction_bins) {
    return rough.is_lambert() || rough.is_diffuse() ? 0 : 1 + direction_bin(to_eye, direction_bins);
}

/// Of the finest cell that knows enough; no samples: none does.
RadianceCells::Mean CachedPaths::ask(const Pass& pass, const Place& place, uint32_t direction, uint32_t finest,
                                     float spread_m, const vec2& u) {
    RadianceCells::Mean known;
    for_each_level(pass.grid, finest, spread_m, [&](uint32_t level) {
        // Cells are asked about the place, not at it: what they know is blurred as by a tent, and has no edges.
        const vec3 beside = Frame(place.geometric_normal).to_world(vec3(pass.grid.side_m(level) * (u - 0.5f), 0));
        known = pass.cells->find(pass.grid.key(place.position + beside, place.normal, direction, level));
        return known.samples < pass.params.least_samples;
    });
    return known.samples >= pass.params.least_samples ? known : RadianceCells::Mean{};
}

CachedPaths::CachedPaths() : records_(size_t{kRays} * kMostRecords), record_count_(kRays) {}

uint64_t CachedPaths::bytes_per_thread() {
    return PathBatch<Path>::bytes_for(kRays) + ShadowBatch<WaitingLight>::bytes_for(kRays) +
           ShadowBatch<WaitingSample>::bytes_for(kRays) + kRays * (kMostRecords * sizeof(Record) + sizeof(uint32_t));
}

void CachedPaths::gather(const Pass& pass, std::span<const GatherPoint> points, const CancelToken& cancel) {
    training_ = false;
    while (!points.empty() && !cancel.cancelled()) {
        size_t batch = 0;
        for (uint32_t rays = 0; batch < points.size() && rays + points[batch].rays <= kRays; ++batch)
            rays += points[batch].rays;
        run(pass, points.first(batch));
        points = points.subspan(batch);
    }
}

void CachedPaths::train(const Pass& pass, std::span<const GatherPoint> points, std::vector<CellSample>& samples,
                        const CancelToken& cancel) {
    training_ = true;
    for (; !points.empty() && !cancel.cancelled(); points = points.subspan(std::min<size_t>(kRays, points.size()))) {
        const std::span<const GatherPoint> batch = points.first(std::min<size_t>(kRays, points.size()));
        std::fill(record_count_.begin(), record_count_.end(), 0u);
        run(pass, batch);
        for (size_t trail = 0; trail < batch.size(); ++trail)
            for (size_t k = 0; k < record_count_[trail]; ++k) {
                const Record& record = records_[trail * kMostRecords + k];
                const Rgb radiance = record.radiance * record.inverse_albedo;
                if (!is_finite(radiance)) {
                    ++pass.counts.nan_samples;
                    continue;
                }
                for_each_level(pass.grid, record.level, record.spread_m, [&](uint32_t level) {
                    samples.push_back(
                        {pass.grid.key(record.place.position, record.place.normal, record.direction, level), radiance,
                         record.random + level});
                    return true;
                });
            }
    }
}

void CachedPaths::run(const Pass& pass, std::span<const GatherPoint> points) {
    start(pass, points);
    for (uint32_t vertex = 1; batch_.count > 0; ++vertex) {
        batch_.find_hits(pass.shared.intersector, Coherence::Incoherent);
        pass.counts.bounce_rays += batch_.count;
        met_.clear();
        for (uint32_t i = 0; i < batch_.count; ++i) {
            arrive(pass, points[batch_.paths[i].point], i);
            if (batch_.hits[i].valid()) met_.push_back(i);
        }
        for (size_t k = 0; k < met_.size(); ++k) {
            prefetch_ahead(pass.shared.scene, batch_.hits, met_, k);
            shade(pass, points[batch_.paths[met_[k]].point], vertex, met_[k]);
        }
        batch_.advance();
        pass.counts.shadow_rays += shadows_.trace(
            pass.shared.intersector, Coherence::Incoherent,
            [&](const WaitingLight& light) { pass.image.of<Layer::Indirect>()[light.pixel] += light.radiance; });
        pass.counts.shadow_rays +=
            trail_shadows_.trace(pass.shared.intersector, Coherence::Incoherent, [&](const WaitingSample& light) {
                Record* const records = &records_[size_t{light.path_trail} * kMostRecords];
                const uint32_t before = light.own ? light.records - 1 : light.records;
                for (uint32_t k = 0; k < before; ++k) records[k].radiance += records[k].through_before * light.radiance;
                if (light.own) records[before].radiance += light.rough;
            });
    }
}

void CachedPaths::start(const Pass& pass, std::span<const GatherPoint> points) {
    batch_.count = 0;
    for (uint32_t p = 0; p < points.size(); ++p) {
        const GatherPoint& point = points[p];
        for (uint32_t ray = 0; ray < point.rays; ++ray) {
            const PassSampler& sampler = pass.samplers[ray];
            const BsdfSample next =
                point.rough.sample(point.wo, sampler.sample_2d(point.key, sample_set(0, VertexSet::Lobe)).x,
                                   sampler.sample_2d(point.key, sample_set(0, VertexSet::Direction)));
            if (!next.valid() || is_black(next.weight)) continue;
            Path& path = batch_.paths[batch_.count];
            path.throughput = next.weight;
            path.eta_scale = next.refraction ? sqr(next.eta) : 1.0f;
            path.point = p;
            path.scatterings = point.scatterings + 1;
            path.trail = p;
            path.spread_m = 0;
            path.bsdf_pdf_sa = next.pdf_sa;
            path.caustic = point.scatterings == 0;
            path.position = point.surface.position;
            path.lit_normal = point.lit_normal;
            path.weight_pdf_sa = next.pdf_sa * static_cast<float>(point.rays) / static_cast<float>(point.light_samples);
            path.media = point.media;
            if (next.refraction) path.media.cross(point.surface.material, point.surface.front_side);
            const vec3 wi = point.surface.shading.to_world(next.wi);
            batch_.keys[batch_.count] = ray;
            batch_.rays[batch_.count++] = {ray_origin(point.surface, wi), wi, kInfinity};
        }
    }
}

void CachedPaths::add_to_trail(uint32_t trail, const Rgb& radiance) {
    Record* const records = &records_[size_t{trail} * kMostRecords];
    for (uint32_t k = 0; k < record_count_[trail]; ++k) records[k].radiance += records[k].through * radiance;
}

void CachedPaths::scale_trail(uint32_t trail, const Rgb& weight) {
    Record* const records = &records_[size_t{trail} * kMostRecords];
    for (uint32_t k = 0; k < record_count_[trail]; ++k) records[k].through *= weight;
}

/// Adds radiance that arrives along the path's ray, over its throughput.
void CachedPaths::add(const Pass& pass, const GatherPoint& origin, const Path& path, const Rgb& radiance) {
    if (training_) return add_to_trail(path.trail, radiance);
    const Rgb seen = origin.throughput * path.throughput * radiance * (1 / static_cast<float>(origin.rays));
    PassImage& image = pass.image;
    (path.scatterings == 1 ? image.of<Layer::Direct>() : image.of<Layer::Indirect>())[origin.pixel] += seen;
    if (path.scatterings > 1 && path.caustic && image.layers.has(Layer::Caustic))
        image.of<Layer::Caustic>()[origin.pixel] += seen;
}

/// Whether the cell of the vertex that the path has come to is one that is asked and filled. Where bounces are limited
/// cells hold as many as are left to the first vertex past the first bounce, and no other one may ask them.
bool CachedPaths::keeps_samples_at(const Pass& pass, const GatherPoint& origin, const Path& path) const {
    return !pass.params.indirect_bounces || (origin.scatterings == 0 && path.scatterings == 1);
}

/// Multiplies the path's weight, and its trail's.
void CachedPaths::scale(Path& path, const Rgb& weight) {
    path.throughput *= weight;
    if (training_) scale_trail(path.trail, weight);
}

/// Adds what a light sends along the path's ray, which light samples at the last vertex find with that density.
void CachedPaths::add_emitted(const Pass& pass, const GatherPoint& origin, const Path& path, const Rgb& radiance,
                              float light_pdf_sa) {
    add(pass, origin, path,
        path.weight_pdf_sa > 0 ? power_heuristic(path.weight_pdf_sa, light_pdf_sa) * radiance : radiance);
}

/// What the path's ray has gone through; the environment, where it met nothing.
void CachedPaths::arrive(const Pass& pass, const GatherPoint& origin, uint32_t i) {
    const EyeScene& shared = pass.shared;
    const Hit& hit = batch_.hits[i];
    Path& path = batch_.paths[i];
    const vec3& direction = batch_.rays[i].direction;
    scale(path, shared.absorption.transmittance(path.media, hit.t));
    if (hit.valid())
        prefetch_index(shared.scene, hit);
    else if (shared.scene.environment)
        add_emitted(
            pass, origin, path, shared.lights.environment_radiance(direction),
            path.weight_pdf_sa > 0 ? shared.lights.pdf_environment(path.position, path.lit_normal, direction) : 0.0f);
}

void CachedPaths::shade(const Pass& pass, const GatherPoint& origin, uint32_t vertex, uint32_t i) {
    const EyeScene& shared = pass.shared;
    const Scene& scene = shared.scene;
    Path path = batch_.paths[i];
    const Hit& hit = batch_.hits[i];
    const Ray& ray = batch_.rays[i];
    const ShadingPoint surface = make_shading_point(scene, hit, ray.direction);
    const Material& material = scene.materials[surface.material];
    if (material.unlit) return;
    if (material.emissive())
        add_emitted(pass, origin, path,
                    emitted_radiance(scene, {hit.instance, hit.triangle, hit.u, hit.v}, surface.front_side),
                    path.weight_pdf_sa > 0 ? shared.lights.pdf_triangle(path.position, path.lit_normal, hit.instance,
                                                                        hit.triangle, ray.direction, hit.t)
                                           : 0.0f);
    if (path.scatterings >= shared.max_scatterings) return;

    Bsdf bsdf = make_bsdf(scene, surface, path.media.outside_ior(scene, surface.material, !surface.front_side));
    const Bsdf rough = bsdf.is_lambert() ? bsdf : bsdf.rough_part(pass.params.glossy_threshold);
    const vec3 wo = surface.shading.to_local(-ray.direction);
    path.spread_m += ray_spread_m(hit.t, path.bsdf_pdf_sa);
    const uint32_t random = hash32(origin.key ^ hash32(pass.key ^ (vertex << 8 | batch_.keys[i])));

    bool keeps_sample = false;
    if (rough.scatters() && keeps_samples_at(pass, origin, path)) {
        const std::optional<uint32_t> level =
            pass.grid.level(glm::distance(surface.position, pass.grid.eye), path.spread_m);
        const uint32_t direction = cell_direction(rough, -ray.direction, pass.params.direction_bins);
        RadianceCells::Mean known;
        if (level && pass.cells) {
            const vec2 u(to_unit_float(random), to_unit_float(hash32(random)));
            known = ask(pass, {surface.position, surface.geometric_normal, surface.shading.normal}, direction, *level,
                        path.spread_m, u);
            ++(known.samples > 0 ? pass.counts.cache_hits : pass.counts.cache_misses);
        }
        if (known.samples > 0) {
            Path ended = path;
            ++ended.scatterings;
            ended.caustic = false;
            add(pass, origin, ended, rough.albedo() * known.radiance);
            if (bsdf.is_lambert()) return;
            bsdf = bsdf.specular_part(pass.params.glossy_threshold);
        } else if (level && training_ && record_count_[path.trail] < kMostRecords) {
            keeps_sample = true;
            records_[size_t{path.trail} * kMostRecords + record_count_[path.trail]++] = {
                .place = {surface.position, surface.geometric_normal, surface.shading.normal},
                .direction = direction,
                .level = *level,
                .spread_m = path.spread_m,
                .inverse_albedo = inverse_of(rough.albedo()),
                .through = Rgb(0),
                .through_before = Rgb(0),
                .radiance = Rgb(0),
                .random = hash32(random ^ 0x68bc21ebu)};
        }
    }
    if (!bsdf.scatters()) return;

    const PassSampler& sampler = pass.samplers[batch_.keys[i]];
    const vec2 choice = sampler.sample_2d(origin.key, sample_set(vertex, VertexSet::LightChoiceAndRoulette));
    const vec3 lit_normal = bsdf.has_non_delta_transmission() ? vec3(0) : surface.shading.normal;
    LightSample light;
    if (bsdf.has_non_delta() &&
        shared.lights.sample(surface.position, lit_normal, choice.x,
                             sampler.sample_2d(origin.key, sample_set(vertex, VertexSet::LightPoint)), light)) {
        const vec3 wi = surface.shading.to_local(light.wi);
        const BsdfValue f = bsdf.evaluate(wo, wi);
        if (!is_black(f.f_cos)) {
            const float weight = light.delta ? 1.0f : power_heuristic(light.pdf_sa, f.pdf_sa);
            const Rgb arrives = weight * light.radiance_over_pdf;
            const Ray shadow_ray = light.shadow_ray(ray_origin(surface, light.wi));
            if (training_)
                trail_shadows_.add(shadow_ray, {.radiance = arrives * f.f_cos,
                                                .rough = keeps_sample ? arrives * rough.f_cos(wo, wi) : Rgb(0),
                                                .path_trail = path.trail,
                                                .records = record_count_[path.trail],
                                                .own = keeps_sample});
            else
                shadows_.add(shadow_ray, {origin.throughput * path.throughput * arrives * f.f_cos *
                                              (1 / static_cast<float>(origin.rays)),
                                          origin.pixel, true});
        }
    }

    if (training_) {
        Record* const records = &records_[size_t{path.trail} * kMostRecords];
        for (uint32_t k = 0; k < record_count_[path.trail]; ++k) records[k].through_before = records[k].through;
    }
    const BsdfSample next =
        bsdf.sample(wo, bsdf.is_lambert() ? 0.0f : sampler.sample_2d(origin.key, sample_set(vertex, VertexSet::Lobe)).x,
                    sampler.sample_2d(origin.key, sample_set(vertex, VertexSet::Direction)));
    if (!next.valid()) return;
    scale(path, next.weight);
    if (keeps_sample)
        records_[size_t{path.trail} * kMostRecords + record_count_[path.trail] - 1].through =
            next.delta ? Rgb(0) : rough.f_cos(wo, next.wi) / next.pdf_sa;
    if (next.refraction) {
        path.eta_scale *= sqr(next.eta);
        path.media.cross(surface.material, surface.front_side);
    }
    const float hope = max_component(path.throughput) * path.eta_scale;
    if (!is_finite(path.throughput)) {  // shown, not hidden: film and samples drop and count it
        add(pass, origin, path, path.throughput);
        return;
    }
    if (!(hope > 0)) return;
    if (vertex + 1 >= ROULETTE_START) {
        const float survival = std::min(hope, ROULETTE_MOST_SURVIVAL);
        if (!(choice.y < survival)) return;
        scale(path, Rgb(1 / survival));
    }
    ++path.scatterings;
    path.caustic = path.caustic && next.delta;
    path.bsdf_pdf_sa = next.delta ? kInfinity : next.pdf_sa;
    path.weight_pdf_sa = next.delta ? 0.0f : next.pdf_sa;
    path.position = surface.position;
    path.lit_normal = lit_normal;
    const vec3 wi = surface.shading.to_world(next.wi);
    batch_.next_path() = path;
    batch_.next_ray() = {ray_origin(surface, wi), wi, kInfinity};
    batch_.keep_next(batch_.keys[i]);
}

}  // namespace photond
