#include "renderer/bidirectional/eye_paths.h"

#include "renderer/bidirectional/bidirectional_shared.h"
#include "renderer/eye/eye_batch.h"
#include "renderer/eye/eye_vertex.h"
#include "renderer/photons/disc_photons.h"

namespace photond {

namespace {

constexpr size_t kPaths = size_t{EyePathTracer::kTileSide} * EyePathTracer::kTileSide;
constexpr size_t kShadowRays = 4 * kPaths;
constexpr size_t kExpectedVertices = 16;  // of the longest paths that are kept
constexpr size_t kPrefetchAhead = 4;      // vertices that are merged with

const Kernel kMergeKernel(KernelShape::Constant);

struct JoinedEyePath : EyePath {
    SubpathWeights weights;
    // Where vertices are kept:
    uint32_t kept = 0;         // the path's number in the tile
    float first_distance = 0;  // from the camera [m]
    float density = 0;         // of going on, [1/sr], an orthographic camera's [1/m^2]; infinite: by a delta lobe
};

/// A light sample or a connection that waits for its shadow ray.
struct WaitingJoin {
    Rgb radiance;
    uint32_t pixel;
    uint32_t scatterings;
    Join join;
    uint32_t pilot_sample;  // of a pilot
};

/// A sample of a pilot that waits likewise; its weights stand beside it.
struct PilotSample {
    TechniqueKind kind;
    uint32_t path;  // JoinedEyePath::kept
    Rgb value;
};

}  // namespace

struct EyePathTracer::State {
    void trace(const BidirectionalScene& scene, const JoinedPass& joined, const Tile& tile, PassImage& pass_image,
               Counts& pass_counts, EyeSeconds& seconds, PilotTile* pilot_tile) {
        shared = &scene, pass = &joined, image = &pass_image, counts = &pass_counts, pilot = pilot_tile;
        if (pilot) {
            pilot->counts.assign(tile.pixels(), {});
            pilot->paths.assign(tile.pixels() * joined.candidates.size(), {});
        }
        of_tile = joined.techniques.at(tile.x0, tile.y0);
        ThreadLaps laps;
        start(tile);
        for (uint32_t vertex = 0; batch.count > 0; ++vertex) {
            batch.find_hits(scene.intersector, vertex == 0 ? Coherence::Coherent : Coherence::Incoherent);
            (vertex == 0 ? counts->camera_rays : counts->bounce_rays) += batch.count;
            if (vertex == 0) laps.lap(seconds.camera);
            sort_hits(vertex);
            const std::span<const uint32_t> keys{batch.keys.data(), batch.count};
            light_point.draw(joined.sampler, sample_set(vertex, VertexSet::LightPoint), keys);
            choice.draw(joined.sampler, sample_set(vertex, VertexSet::LightChoiceAndRoulette), keys);
            direction.draw(joined.sampler, sample_set(vertex, VertexSet::Direction), keys);
            lobe.draw(joined.sampler, sample_set(vertex, VertexSet::Lobe), keys);
            for (size_t k = 0; k < order.size(); ++k) {
                prefetch_ahead(scene.scene, batch.hits, order, k);
                if (shade(vertex, order[k])) batch.keep_next(batch.keys[order[k]]);
            }
            batch.advance();
            trace_shadow_rays();
            if (vertex == 0) laps.lap(seconds.direct);
        }
        laps.lap(seconds.indirect);
    }

    void start(const Tile& tile) {
        batch.count = tile.pixels();
        starts.resize(batch.count);
        start_eye_paths(*shared, pass->sampler, tile, {batch.rays.data(), batch.count}, starts,
                        {batch.keys.data(), batch.count});
        for (size_t i = 0; i < batch.count; ++i) {
            static_cast<EyePath&>(batch.paths[i]) = starts[i];
            const CameraPdf camera = shared->camera.pdf(batch.rays[i].direction);
            batch.paths[i].weights = shared->mis.start_eye(camera.pdf);
            batch.paths[i].kept = static_cast<uint32_t>(i);
            batch.paths[i].density = camera.pdf;
        }
        for (uint32_t y = tile.y0; y < tile.y1; ++y) {
            const size_t first = size_t{y} * image->size.width + tile.x0;
            image->clear(first, tile.x1 - tile.x0);
            if (!image->layers.has(Layer::Techniques)) continue;
            const Rgb shown = shown_techniques(of_tile, image->size);
            for (size_t pixel = first; pixel < first + (tile.x1 - tile.x0); ++pixel)
                image->of<Layer::Techniques>()[pixel] = shown;
        }
    }

    /// Ends the paths that met nothing; `order` has the others.
    void sort_hits(uint32_t vertex) {
        order.clear();
        for (uint32_t i = 0; i < batch.count; ++i) {
            JoinedEyePath& path = batch.paths[i];
            const Hit& hit = batch.hits[i];
            path.throughput *= shared->absorption.transmittance(path.media, hit.t);
            if (!hit.valid()) {
                meet_environment(vertex, path, batch.rays[i].direction);
                continue;
            }
            prefetch_index(shared->scene, hit);
            order.push_back(i);
        }
    }

    void meet_environment(uint32_t vertex, const JoinedEyePath& path, const vec3& towards) {
        if (!shared->scene.environment) return;
        const Rgb radiance = path.throughput * shared->lights.environment_radiance(towards);
        if (is_black(radiance)) return;
        if (correlated()) collect_eye_vertices(path, vertex);
        add_met(vertex, path, radiance,
                [&] { return shared->ends.of_environment(path.position, path.lit_normal, towards); });
    }

    void meet_light(uint32_t vertex, const JoinedEyePath& path, const Hit& hit, bool front, const vec3& towards) {
        const Rgb emitted = emitted_radiance(shared->scene, {hit.instance, hit.triangle, hit.u, hit.v}, front);
        if (is_black(emitted)) return;
        add_met(vertex, path, path.throughput * emitted, [&] {
            return shared->ends.on_triangle(path.position, path.lit_normal, hit.instance, hit.triangle, towards, hit.t);
        });
    }

    /// `end()`: of the light that was met.
    template <class End>
    void add_met(uint32_t vertex, const JoinedEyePath& path, const Rgb& radiance, const End& end) {
        if (vertex == 0) return add_radiance(*image, path, radiance);
        const LightEnd met = end();
        SubpathWeights weights = path.weights;
        if (correlated()) {
            const std::span<const PathVertex> before{eye_vertices.data(), vertex};
            const PathVertex first = first_of_light(met, before.back().per_area, 1.0f);
            const float inverse_cos = met.infinite ? 1.0f : eye_vertices[vertex].inverse_cos;
            weights.merges = correlation_of(path).light_met(before, inverse_cos, first, numbers().caustic_area()).eye;
            weights.newest_merge = 0;
        }
        const auto weigh = [&](const TechniqueNumbers& n) { return shared->mis.light_met(weights, met, n); };
        if (pilot) add_now(TechniqueKind::Alone, path, radiance, weigh);
        add_radiance(*image, path, weigh(numbers()).weight() * radiance);
    }

    /// All that path i does at the surface it met. False: it ends, and what stands in the place of the next does not
    /// count.
    bool shade(uint32_t vertex, uint32_t i) {
        JoinedEyePath& path = batch.next_path();
        path = batch.paths[i];
        const Hit& hit = batch.hits[i];
        const Ray& ray = batch.rays[i];
        EyeVertex met;
        if (!see_surface(*shared, path, vertex, hit, ray, *image, met.surface)) return false;
        arrive(vertex, path, hit, ray, met.surface);
        if (correlated()) collect_eye_vertices(path, vertex + 1);
        if (shared->scene.materials[met.surface.material].emissive())
            meet_light(vertex, path, hit, met.surface.front_side, ray.direction);
        if (!open_surface(*shared, path, ray, *image, met)) return false;
        const SurfaceVertex surface{met.surface, met.bsdf, -ray.direction};
        path.lit_normal = lit_normal(surface);
        const bool may_merge = numbers().merges && met.bsdf.has_non_delta();
        disc = may_merge ? pass->techniques.merge_disc_at(surface.point.position) : MergeDisc();
        if (correlated()) kept(path, vertex).acceptance = eye_vertices.back().acceptance = disc.acceptance_m2();
        if (pilot) ++counts_of(path).vertices, counts_of(path).open_vertices += met.bsdf.has_non_delta() ? 1 : 0;
        if (met.bsdf.has_non_delta()) {
            sample_light(vertex, path, surface, i);
            connect(vertex, path, surface, i);
            merge(vertex, path, surface, i);
        }
        return leave(vertex, path, surface, met.wo, i);
    }

    void arrive(uint32_t vertex, JoinedEyePath& path, const Hit& hit, const Ray& ray, const ShadingPoint& point) {
        const bool across = vertex == 0 && shared->view.camera.orthographic;
        const float cosine = std::max(std::fabs(glm::dot(point.geometric_normal, ray.direction)), 1e-12f);
        const float distance_sq = across ? 1.0f : sqr(hit.t);
        shared->mis.arrive(path.weights, distance_sq, cosine);
        if (!correlated()) return;
        if (vertex == 0)
            path.first_distance = hit.t;
        else
            kept(path, vertex - 1).per_area /= distance_sq;
        kept(path, vertex) = {.density = path.density * cosine / distance_sq, .inverse_cos = 1 / cosine};
    }

    bool leave(uint32_t vertex, JoinedEyePath& path, const SurfaceVertex& surface, const vec3& wo, uint32_t i) {
        const BsdfSample next = surface.bsdf.sample(wo, lobe.x[i], {direction.x[i], direction.y[i]});
        if (!leave_surface(path, surface.point, next, vertex + 1 >= shared->roulette_start, choice.y[i], *image,
                           batch.next_ray()))
            return false;
        const vec3 towards = batch.next_ray().direction;
        const float cos_out = std::fabs(glm::dot(surface.point.geometric_normal, towards));
        const VertexSide here = side(vertex, next.delta ? 0 : light_pdf_back(surface, towards));
        if (next.delta)
            shared->mis.scatter_delta(path.weights, cos_out);
        else
            shared->mis.scatter(path.weights, here, next.pdf_sa, cos_out);
        if (correlated()) {
            path.density = next.delta ? kInfinity : next.pdf_sa;
            kept(path, vertex).go_on(cos_out, path.density, here.pdf_back);
        }
        return true;
    }

    void sample_light(uint32_t vertex, const JoinedEyePath& path, const SurfaceVertex& surface, uint32_t i) {
        LightSample light;
        if (!shared->lights.sample(path.position, path.lit_normal, choice.x[i], {light_point.x[i], light_point.y[i]},
                                   light))
            return;
        const EyeScattering scattering = scatter_to_light(surface, light.wi);
        if (is_black(scattering.f_cos)) return;
        float pdf_direct_sa;
        const LightEnd end = shared->ends.of_sample(light, pdf_direct_sa);
        const float cosine = std::fabs(glm::dot(surface.point.geometric_normal, light.wi));
        SubpathWeights weights = path.weights;
        VertexSide here = side(vertex, scattering.light_pdf);
        if (correlated()) {
            const PathVertex first = first_of_light(end, cosine, sqr(light.distance));
            const CorrelatedMerges merges = correlation_of(path).next_event(eye_vertices, here.pdf_back, first);
            weights.merges = merges.eye, here.acceptance *= merges.eye_share;
        }
        const auto weigh = [&](const TechniqueNumbers& n) {
            return shared->mis.next_event(weights, here, scattering.eye_pdf, pdf_direct_sa, cosine, end, n);
        };
        wait_for(light.shadow_ray(ray_origin(surface.point, light.wi)),
                 path.throughput * scattering.f_cos * light.radiance_over_pdf, path, path.scatterings + 1,
                 Join::LightSample, TechniqueKind::Alone, weigh);
    }

    void connect(uint32_t vertex, const JoinedEyePath& path, const SurfaceVertex& surface, uint32_t i) {
        const PassTechniques& techniques = pass->techniques;
        const std::vector<LightVertex>& cache = pass->light.vertices;
        if (cache.empty()) return;
        if (techniques.own_path) {
            // Any of them: paths whose numbers lie in step with the image's pixels are alike.
            RandomStream random(pass->join_salt, RandomDomain::Connections, ~0u, batch.keys[i]);
            const auto own = static_cast<uint32_t>(uint64_t{random.next_bits()} * techniques.light_paths >> 32);
            const std::vector<uint32_t>& first = pass->light.first_of_path;
            for (uint32_t k = first[own]; k < first[own + 1]; ++k)
                connect_with(cache[pass->light.by_path[k]], static_cast<float>(techniques.light_paths), vertex, path,
                             surface);
            return;
        }
        const uint32_t tries = of_tile.connections_per_vertex;
        if (tries == 0) return;
        RandomStream random(pass->join_salt, RandomDomain::Connections, vertex, batch.keys[i]);
        const float inverse_pdf = static_cast<float>(cache.size()) / static_cast<float>(tries);
        for (uint32_t k = 0; k < tries; ++k) {
            // One of each of as many equal parts of the cache.
            const double place = (k + double{random.next()}) / tries * static_cast<double>(cache.size());
            connect_with(cache[std::min(static_cast<size_t>(place), cache.size() - 1)], inverse_pdf, vertex, path,
                         surface);
        }
    }

    void connect_with(const LightVertex& light, float inverse_pdf, uint32_t vertex, const JoinedEyePath& path,
                      const SurfaceVertex& surface) {
        const uint32_t scatterings = path.scatterings + 1 + light.surfaces;
        if (scatterings > shared->max_scatterings || scatterings < light.surfaces) return;
        const vec3 offset = light.position - surface.point.position;
        const float distance_sq = glm::dot(offset, offset);
        if (!(distance_sq > 0)) return;
        const float distance = std::sqrt(distance_sq);
        const vec3 towards = offset / distance;
        const EyeScattering eye = scatter_to_light(surface, towards);
        if (is_black(eye.f_cos)) return;
        const SurfaceVertex other = light.surface(shared->scene);
        const LightScattering back = scatter_to_eye(other, -towards);
        if (is_black(back.density)) return;
        const float cos_eye = std::fabs(glm::dot(surface.point.geometric_normal, towards));
        const float cos_light = std::fabs(glm::dot(other.point.geometric_normal, towards));
        const float per_area = 1 / distance_sq;
        VertexSide eye_side = side(vertex, eye.light_pdf),
                   light_side{light.first_surface(), back.eye_pdf, light.acceptance};
        const float to_light = eye.eye_pdf * cos_light * per_area, to_eye = back.light_pdf * cos_eye * per_area;
        SubpathWeights eye_weights = path.weights, light_weights = light.weights;
        if (correlated()) {
            const MergingCorrelation correlation = correlation_of(path);
            const CorrelatedMerges merges =
                correlation.connection(eye_vertices, eye_side.pdf_back, to_light, vertices_of(light, correlation),
                                       light_side.pdf_back, to_eye);
            eye_weights.merges = merges.eye, eye_side.acceptance *= merges.eye_share;
            light_weights.merges = merges.light, light_side.acceptance *= merges.light_share;
        }
        const auto weigh = [&](const TechniqueNumbers& n) {
            return shared->mis.connection(eye_weights, eye_side, to_light, light_weights, light_side, to_eye, n);
        };
        MediumStack media = path.media;
        if (glm::dot(surface.point.geometric_normal, towards) < 0 && surface.bsdf.refraction_eta() > 0)
            media.cross(surface.point.material, surface.point.front_side);
        const Rgb radiance = (inverse_pdf * per_area) * path.throughput * eye.f_cos * back.density * light.power_w *
                             shared->absorption.transmittance(media, distance);
        if (is_black(radiance)) return;
        const vec3 start = ray_origin(surface.point, towards);
        wait_for({start, ray_origin(other.point, -towards) - start, 1.0f}, radiance, path, scatterings,
                 Join::Connection, TechniqueKind::Connection, weigh);
    }

    void merge(uint32_t vertex, const JoinedEyePath& path, const SurfaceVertex& surface, uint32_t i) {
        if (pass->grid == nullptr || !(disc.radius_m > 0)) return;
        const ShadingPoint& point = surface.point;
        pass->grid->find_within(point.position, disc.radius_m, near);
        find_merged(path, surface);
        const uint32_t key = batch.keys[i];
        merge_within(disc, vertex, path, surface, key);
        if (caustics.empty()) return;
        std::swap(near.found, caustics);
        merge_within(disc.scaled(numbers().caustic_radius), vertex, path, surface, key);
    }

    /// With the vertices that are left on that disc.
    void merge_within(const MergeDisc& within, uint32_t vertex, const JoinedEyePath& path, const SurfaceVertex& surface,
                      uint32_t key) {
        const ShadingPoint& point = surface.point;
        const float per_m2 = one_over_area(within, path, surface, vertex, key);
        if (per_m2 == 0) return;
        const Frame& frame = point.shading;
        const vec3 wo = frame.to_local(surface.from);
        const Rgb scale = per_m2 * path.throughput;
        for (size_t k = 0; k < near.found.size(); ++k) {
            prefetch_merged(k);
            const LightVertex& light = merged(k);
            const uint32_t scatterings = path.scatterings + light.surfaces;
            const BsdfValue value = surface.bsdf.evaluate(wo, frame.to_local(light.from));
            if (is_black(value.f_cos)) continue;
            VertexSide eye_side{vertex == 0, light_pdf_back(surface, light.from), within.acceptance_m2()};
            const VertexSide light_side{light.first_surface(), value.pdf_sa, 0};
            SubpathWeights eye_weights = path.weights, light_weights = light.weights;
            if (correlated()) {
                const MergingCorrelation correlation = correlation_of(path);
                const CorrelatedMerges merges = correlation.merging(
                    eye_vertices, eye_side.pdf_back, vertices_of(light, correlation), light_side.pdf_back);
                eye_weights.merges = merges.eye, eye_side.acceptance *= merges.eye_share;
                light_weights.merges = merges.light;
            }
            const auto weigh = [&](const TechniqueNumbers& n) {
                return shared->mis.merging(eye_weights, eye_side, light_weights, light_side, n);
            };
            const float share = 1 / std::max(std::fabs(glm::dot(light.from, light.normal)), kLeastCosine);
            const Rgb radiance = share * scale * value.f_cos * light.power_w;
            if (pilot) ++counts_of(path).found, add_now(TechniqueKind::Merge, path, radiance, weigh);
            add_joined(*image, path.pixel, scatterings, path.scatterings == 0 && light.caustic(), Join::Merge,
                       weigh(numbers()).weight() * radiance);
        }
    }

    /// Leaves of the vertices that were found those that lie on the surface's disc; those of caustics in `caustics`,
    /// where they have a disc of their own.
    void find_merged(const JoinedEyePath& path, const SurfaceVertex& surface) {
        const bool caustics_differ = numbers().caustic_radius < 1;
        const MergeDisc of_caustics = disc.scaled(numbers().caustic_radius);
        caustics.clear();
        const ShadingPoint& point = surface.point;
        const bool both_sides = surface.bsdf.has_non_delta_transmission();
        std::vector<Neighbours::Found>& found = near.found;
        size_t left = 0;
        for (size_t k = 0; k < found.size(); ++k) {
            if (k + 2 * kPrefetchAhead < found.size()) __builtin_prefetch(&merged(k + 2 * kPrefetchAhead).surfaces);
            const LightVertex& light = merged(k);
            if (path.scatterings + light.surfaces > shared->max_scatterings) continue;
            const bool as_caustic = caustics_differ && light.caustic();
            const MergeDisc& within = as_caustic ? of_caustics : disc;
            if (as_caustic && !(found[k].distance_sq_m2 < sqr(within.radius_m))) continue;
            if (std::fabs(glm::dot(point.geometric_normal, light.position - point.position)) > within.most_height_m())
                continue;
            const float side_cosine = glm::dot(light.normal, point.geometric_normal);
            if ((side_cosine < 0 && !both_sides) || std::fabs(side_cosine) < kDiscCosine) continue;
            // A vertex of a curved surface's next facet may have been lit from below this one's horizon.
            if ((glm::dot(light.from, point.geometric_normal) > 0) != (side_cosine > 0)) continue;
            if (as_caustic)
                caustics.push_back(found[k]);
            else
                found[left++] = found[k];
        }
        found.resize(left);
    }

    /// One over the area of a disc that light can reach [1/m^2], 0 where none of the vertices in `near` is left.
    float one_over_area(const MergeDisc& within, const JoinedEyePath& path, const SurfaceVertex& surface,
                        uint32_t vertex, uint32_t key) {
        const ShadingPoint& point = surface.point;
        std::vector<Neighbours::Found>& found = near.found;
        if (found.empty()) return 0;
        const float per_m2 = 1 / (kPi * sqr(within.radius_m));
        if (!within.may_be_cut) return per_m2;
        if (pilot) ++counts_of(path).clipped;
        const CoverageDisc surface_disc{point.position, point.geometric_normal, within.radius_m,
                                        within.most_height_m()};
        RandomStream random(pass->join_salt, RandomDomain::MergingDiscs, vertex, key);
        const DiscProbe probe(*pass->techniques.coverage, kMergeKernel, surface_disc, random.next_bits(),
                              vertex == 0 ? DiscCare::Fine : DiscCare::Coarse);
        return per_m2 * probe.clip(found, [&](const Neighbours::Found& f) { return merged(f).position; });
    }

    const LightVertex& merged(const Neighbours::Found& found) const {
        return pass->light.vertices[pass->in_grid_order[found.index]];
    }
    const LightVertex& merged(size_t k) const { return merged(near.found[k]); }
    /// Vertices that lie together come from paths that lie anywhere.
    void prefetch_merged(size_t k) const {
        if (correlated() && k + kPrefetchAhead < near.found.size())
            __builtin_prefetch(&pass->light.places[merged(k + kPrefetchAhead).place]);
    }

    // What merging_correlation.h asks for.

    bool correlated() const { return pass->techniques.correlated && numbers().merges; }
    MergingCorrelation correlation_of(const JoinedEyePath& path) const {
        return pass->techniques.correlation(shared->mis, path.first_distance);
    }
    PathVertex& kept(const JoinedEyePath& path, uint32_t vertex) {
        const size_t end = (size_t{vertex} + 1) * kPaths;
        if (kept_vertices.size() < end) kept_vertices.resize(end);
        return kept_vertices[size_t{vertex} * kPaths + path.kept];
    }
    /// The path's first so many, with their reach.
    void collect_eye_vertices(const JoinedEyePath& path, uint32_t count) {
        eye_vertices.clear();
        for (uint32_t v = 0; v < count; ++v) eye_vertices.push_back(kept(path, v));
        correlation_of(path).find_reach(eye_vertices);
    }
    std::span<const PathVertex> vertices_of(const LightVertex& light, const MergingCorrelation& correlation) {
        const std::span<const PathVertex> path = pass->light.path_to(light);
        light_vertices.assign(path.begin(), path.end());
        correlation.find_reach(light_vertices);
        return light_vertices;
    }

    VertexSide side(uint32_t vertex, float pdf_back) const { return {vertex == 0, pdf_back, disc.acceptance_m2()}; }
    const TechniqueNumbers& numbers() const { return of_tile.numbers; }

    /// `weigh(numbers)`: of the light that arrives where the ray is free.
    template <class Weigh>
    void wait_for(const Ray& ray, const Rgb& radiance, const JoinedEyePath& path, uint32_t scatterings, Join join,
                  TechniqueKind kind, const Weigh& weigh) {
        const Rgb weighed = weigh(numbers()).weight() * radiance;
        if (is_black(weighed) && !pilot) return;
        if (!shadows.has_room_for(1)) trace_shadow_rays();
        shadows.add(ray, {weighed, path.pixel, scatterings, join, static_cast<uint32_t>(samples.size())});
        if (!pilot) return;
        weigh_by_all(weigh, sample_weights);
        samples.push_back({kind, path.kept, radiance});
    }
    void trace_shadow_rays() {
        counts->shadow_rays +=
            shadows.trace(shared->intersector, Coherence::Incoherent, [&](const WaitingJoin& waiting) {
                add_joined(*image, waiting.pixel, waiting.scatterings, false, waiting.join, waiting.radiance);
                if (pilot) add_sample(waiting.pilot_sample);
            });
        samples.clear();
        sample_weights.clear();
    }

    // Of pilots.

    EyePathCounts& counts_of(const JoinedEyePath& path) { return pilot->counts[path.kept]; }

    /// Appends what each candidate would weigh.
    template <class Weigh>
    void weigh_by_all(const Weigh& weigh, std::vector<CandidateWeight>& weights) {
        const MisShare own = weigh(numbers());
        for (const WeighedCandidate& candidate : pass->candidates)
            weights.push_back(weigh_candidate(own, weigh(candidate.numbers)));
    }
    void add_sample(size_t sample) {
        const size_t candidates = pass->candidates.size();
        add_to_path(samples[sample], std::span(sample_weights).subspan(sample * candidates, candidates));
    }
    template <class Weigh>
    void add_now(TechniqueKind kind, const JoinedEyePath& path, const Rgb& value, const Weigh& weigh) {
        weights_now.clear();
        weigh_by_all(weigh, weights_now);
        add_to_path({kind, path.kept, value}, weights_now);
    }
    void add_to_path(const PilotSample& sample, std::span<const CandidateWeight> weights) {
        EyePathSum* sums = &pilot->paths[sample.path * weights.size()];
        for (size_t c = 0; c < weights.size(); ++c) sums[c].add(sample.kind, sample.value, weights[c]);
    }

    const BidirectionalScene* shared = nullptr;
    const JoinedPass* pass = nullptr;
    PassImage* image = nullptr;
    Counts* counts = nullptr;
    PilotTile* pilot = nullptr;
    BlockTechniques of_tile;
    MergeDisc disc;  // of the vertex at hand, but for caustics

    PathBatch<JoinedEyePath> batch{kPaths};
    ShadowBatch<WaitingJoin> shadows{kShadowRays};
    PathNumbers light_point{kPaths}, choice{kPaths}, direction{kPaths}, lobe{kPaths};
    std::vector<EyePath> starts;
    std::vector<uint32_t> order;
    Neighbours near;
    std::vector<Neighbours::Found> caustics;               // of these, on their own disc
    std::vector<PathVertex> kept_vertices;                 // of all paths of the tile, vertex by vertex
    std::vector<PathVertex> eye_vertices, light_vertices;  // of the paths at hand
    std::vector<PilotSample> samples;                      // that wait
    std::vector<CandidateWeight> sample_weights, weights_now;
};

EyePathTracer::EyePathTracer() : state_(std::make_unique<State>()) {}
EyePathTracer::~EyePathTracer() = default;
EyePathTracer::EyePathTracer(EyePathTracer&&) noexcept = default;

uint64_t EyePathTracer::bytes_per_thread() {
    return PathBatch<JoinedEyePath>::bytes_for(kPaths) + ShadowBatch<WaitingJoin>::bytes_for(kShadowRays) +
           kPaths * (kExpectedVertices * sizeof(PathVertex) + sizeof(EyePath) + sizeof(uint32_t) + 8 * sizeof(float));
}

void EyePathTracer::trace_tile(const BidirectionalScene& shared, const JoinedPass& pass, const Tile& tile,
                               PassImage& image, Counts& counts, EyeSeconds& seconds, PilotTile* pilot) {
    state_->trace(shared, pass, tile, image, counts, seconds, pilot);
}

}  // namespace photond
