#include "renderer/bidirectional/light_paths.h"

#include "renderer/bidirectional/bidirectional_shared.h"
#include "renderer/core/parallel.h"
#include "renderer/core/thread_local.h"
#include "renderer/photons/photon_tracing_scene.h"
#include "renderer/transport/hit_prefetch.h"
#include "renderer/transport/path_batch.h"

namespace photond {

namespace {

constexpr uint32_t kPaths = SequenceSampler::kRun;  // traced together
/// Of a path, where they are kept.
constexpr uint32_t kExpectedPlaces = 6;

/// A surface that a path of a run met, in the order in which they were met.
struct MetPlace {
    PathVertex vertex;
    uint32_t path;    // of the run
    uint32_t before;  // place of the surface before; kFirst: it is the path's first
    static constexpr uint32_t kFirst = ~0u;
};

/// A light path between two of its vertices; how many surfaces it has met all paths of a batch share.
struct LightPathState {
    Rgb power_w{0};
    float reference_inverse = 0;  // [1/W] of the greatest component at emission: roulette keeps the power near that
    SubpathWeights weights;
    bool all_delta = true;
    MediumStack media;
    // Where places are kept:
    float density = 0;                  // of going on, [1/sr]; infinite: by a delta lobe
    uint32_t place = MetPlace::kFirst;  // the newest
};

/// A splat whose ray to the camera is still to be traced.
struct WaitingSplat {
    LightSplat splat;
    uint32_t sample;  // of a pilot: where its weights begin
};

/// What one run left.
struct RunPaths {
    std::vector<LightVertex> vertices;
    std::vector<PathVertex> places;
    std::vector<LightSplat> splats;
    std::vector<CandidateWeight> splat_weights;
    Counts counts;

    void clear() {
        vertices.clear();
        places.clear();
        splats.clear();
        splat_weights.clear();
        counts = {};
    }
};

/// Scratch of one thread.
class LightBatch {
public:
    static constexpr uint64_t bytes_per_thread() {
        return PathBatch<LightPathState>::bytes_for(kPaths) + ShadowBatch<WaitingSplat>::bytes_for(kPaths) +
               kPaths * (kExpectedPlaces * sizeof(MetPlace) + 2 * sizeof(EmissionSample) + sizeof(LightEnd) +
                         sizeof(uint32_t) + 6 * sizeof(float));
    }

    void trace(const BidirectionalScene& shared, const PassTechniques& techniques, const SequenceSampler& sampler,
               const SequenceRun& run, uint64_t first_of_pass, std::span<const WeighedCandidate> candidates,
               RunPaths& out) {
        candidates_ = candidates;
        shared_ = &shared, techniques_ = &techniques, sampler_ = &sampler, run_ = &run, out_ = &out;
        first_of_pass_ = first_of_pass;
        start();
        for (uint32_t surfaces = 1; batch_.count > 0; ++surfaces) {
            batch_.find_hits(shared.intersector, Coherence::Incoherent);
            out.counts.photon_rays += batch_.count;
            draw(sample_set(surfaces, ScatteringSet::Direction), direction_);
            draw(sample_set(surfaces, ScatteringSet::RouletteAndLobe), choice_);
            order_.clear();
            for (uint32_t i = 0; i < batch_.count; ++i) {
                if (!batch_.hits[i].valid()) continue;
                prefetch_index(shared.scene, batch_.hits[i]);
                order_.push_back(i);
            }
            for (size_t k = 0; k < order_.size(); ++k) {
                prefetch_ahead(shared.scene, batch_.hits, order_, k);
                meet(order_[k], surfaces);
            }
            batch_.advance();
            trace_splats();
        }
        if (techniques.correlated) put_places_in_rows();
    }

private:
    struct Numbers {
        std::vector<float> x = std::vector<float>(kPaths), y = std::vector<float>(kPaths);
    };

    void draw(uint32_t set, Numbers& numbers) {
        sampler_->sample_2d(run_->run, {batch_.keys.data(), batch_.count}, set, {numbers.x.data(), batch_.count},
                            {numbers.y.data(), batch_.count});
    }

    void start() {
        const size_t emitted = run_->last - run_->first;
        batch_.count = emitted;
        for (uint32_t i = 0; i < emitted; ++i) batch_.keys[i] = run_->first + i;
        draw(sample_set(EmissionSet::Light), choice_);
        draw(sample_set(EmissionSet::Position), position_);
        draw(sample_set(EmissionSet::Direction), direction_);
        shared_->emission.sample({choice_.x, position_.x, position_.y, direction_.x, direction_.y},
                                 {starts_.data(), emitted});
        out_->counts.photons_emitted += emitted;
        batch_.count = 0;
        for (uint32_t i = 0; i < emitted; ++i) {
            const EmissionSample& start = starts_[i];
            if (is_black(start.power_w)) continue;
            const LightEnd end = shared_->ends.of_emission(start);
            if (!(end.emission > 0)) continue;
            LightPathState& path = batch_.paths[batch_.count];
            path = {};
            path.power_w = start.power_w / static_cast<float>(techniques_->light_paths);
            path.reference_inverse = 1 / max_component(path.power_w);
            path.weights = shared_->mis.start_light(end);
            batch_.rays[batch_.count] = start.ray;
            starts_[batch_.count] = start;  // behind i, or i itself
            ends_[batch_.count] = end;
            batch_.keys[batch_.count++] = run_->first + i;
        }
    }

    /// Path i at its surface of that number.
    void meet(uint32_t i, uint32_t surfaces) {
        const Scene& scene = shared_->scene;
        LightPathState& path = batch_.paths[i];
        const Hit& hit = batch_.hits[i];
        const Ray& ray = batch_.rays[i];
        const bool first = surfaces == 1;
        SurfaceVertex vertex;
        vertex.point = make_shading_point(scene, hit, ray.direction);
        vertex.from = -ray.direction;
        const ShadingPoint& point = vertex.point;
        if (scene.materials[point.material].unlit) return;
        if (first && starts_[i].range_m < kInfinity) path.power_w *= range_window(hit.t, starts_[i].range_m);
        path.power_w *= shared_->absorption.transmittance(path.media, hit.t);
        const float cosine = glm::dot(point.geometric_normal, vertex.from);
        if (is_black(path.power_w) || !(cosine > 0)) return;
        const float outside_ior = path.media.outside_ior(scene, point.material, !point.front_side);
        vertex.bsdf = make_bsdf(scene, point, outside_ior);

        const Mis& mis = shared_->mis;
        if (first)
            mis.direct_at_first_hit(
                path.weights, shared_->ends.direct_at_first_hit(starts_[i], point.position, lit_normal(vertex), hit.t));
        mis.arrive(path.weights, first && ends_[i].infinite ? 1.0f : sqr(hit.t), cosine);
        const uint32_t key = batch_.keys[i];
        const float acceptance =
            vertex.bsdf.has_non_delta()
                ? techniques_->merge_disc_at(point.position, !first && path.all_delta).acceptance_m2()
                : 0.0f;
        if (techniques_->correlated) keep_place(i, path, first, hit.t, cosine, acceptance);
        if (vertex.bsdf.has_non_delta()) {
            out_->vertices.push_back({.position = point.position,
                                      .normal = point.geometric_normal,
                                      .from = vertex.from,
                                      .power_w = path.power_w,
                                      .weights = path.weights,
                                      .instance = hit.instance,
                                      .triangle = hit.triangle,
                                      .u = hit.u,
                                      .v = hit.v,
                                      .outside_ior = outside_ior,
                                      .acceptance = acceptance,
                                      .path = static_cast<uint32_t>(run_->run * kPaths + key - first_of_pass_),
                                      .place = path.place,
                                      .surfaces = surfaces,
                                      .all_delta = path.all_delta});
            show_camera(vertex, path, surfaces, key, acceptance);
        }
        if (surfaces >= shared_->max_scatterings) return;
        go_on(i, vertex, first, acceptance);
    }

    void keep_place(uint32_t i, LightPathState& path, bool first, float distance_m, float cosine, float acceptance) {
        MetPlace place{.vertex = {.density = path.density * cosine / sqr(distance_m)},
                       .path = batch_.keys[i] - run_->first,
                       .before = path.place};
        if (first)
            place.vertex = first_of_light(ends_[i], cosine, sqr(distance_m));
        else
            met_[path.place].vertex.per_area /= sqr(distance_m);
        place.vertex.acceptance = acceptance;
        place.vertex.inverse_cos = 1 / cosine;
        path.place = static_cast<uint32_t>(met_.size());
        met_.push_back(place);
    }
    /// The path's vertices until that place, its surface of that number.
    std::span<PathVertex> vertices_to(uint32_t place, uint32_t surfaces) {
        if (vertices_.size() < surfaces) vertices_.resize(surfaces);
        for (uint32_t i = surfaces; i-- > 0; place = met_[place].before) vertices_[i] = met_[place].vertex;
        return {vertices_.data(), surfaces};
    }
    /// A path's places one behind the other: what is joined with it reads them all.
    void put_places_in_rows() {
        std::vector<uint32_t>& next = next_place_;
        next.assign(run_->last - run_->first + 1, 0);
        for (const MetPlace& place : met_) ++next[place.path + 1];
        for (size_t path = 1; path < next.size(); ++path) next[path] += next[path - 1];
        out_->places.resize(met_.size());
        for (MetPlace& place : met_) {
            const uint32_t row = next[place.path]++;
            out_->places[row] = place.vertex;
            place.before = row;  // nobody follows it any more
        }
        for (LightVertex& vertex : out_->vertices) vertex.place = met_[vertex.place].before;
        met_.clear();
    }

    void show_camera(const SurfaceVertex& vertex, const LightPathState& path, uint32_t surfaces, uint32_t key,
                     float acceptance) {
        const ShadingPoint& point = vertex.point;
        const vec2 lens = shared_->view.camera.aperture_radius_m > 0
                              ? sampler_->sample_2d(run_->run * kPaths + key, FIRST_LENS_SET + surfaces)
                              : vec2(0);
        const auto seen = shared_->camera.connect(point.position, lens);
        if (!seen || !shared_->filter.reaches_image(seen->film, shared_->view.film_size)) return;
        const LightScattering scattering = scatter_to_eye(vertex, seen->to_camera);
        if (is_black(scattering.density)) return;
        const float cosine = std::fabs(glm::dot(point.geometric_normal, seen->to_camera));
        const VertexSide side{surfaces == 1, scattering.eye_pdf, acceptance};
        SubpathWeights weights = path.weights;
        const float camera_pdf = seen->responsivity_per_m2 * cosine;
        if (techniques_->correlated) {
            const std::span<PathVertex> vertices = vertices_to(path.place, surfaces);
            const MergingCorrelation correlation = techniques_->correlation(shared_->mis, seen->distance);
            correlation.find_reach(vertices);
            weights.merges = correlation.seen_by_camera(vertices, side.pdf_back, camera_pdf).light;
        }
        const auto weigh = [&](const TechniqueNumbers& n) {
            return shared_->mis.seen_by_camera(weights, side, camera_pdf, n);
        };
        const Rgb radiance = seen->responsivity_per_m2 * path.power_w * scattering.density;
        if (is_black(radiance)) return;
        const vec3 start = ray_origin(point, seen->to_camera);
        const auto show = [&](float weight, uint32_t block) {
            if (is_black(weight * radiance)) return;
            if (!splats_.has_room_for(1)) trace_splats();
            splats_.add({start, seen->target - start, 1.0f}, {{.film = seen->film,
                                                               .radiance = weight * radiance,
                                                               .scatterings = surfaces,
                                                               .caustic = surfaces > 1 && path.all_delta,
                                                               .block = block},
                                                              static_cast<uint32_t>(weights_.size())});
        };
        const TechniqueBlocks* const blocks = techniques_->blocks;
        if (!candidates_.empty()) {
            show(1, TechniqueBlocks::kOfAll);
            const MisShare own = weigh(techniques_->everywhere.numbers);
            for (const WeighedCandidate& candidate : candidates_)
                weights_.push_back(weigh_candidate(own, weigh(candidate.numbers)));
        } else if (blocks == nullptr) {
            show(weigh(techniques_->everywhere.numbers), TechniqueBlocks::kOfAll);
        } else {
            for (const uint32_t block : blocks_at(seen->film, *blocks)) show(weigh((*blocks)[block].numbers), block);
        }
    }

    /// Of the pixels that a place of the film belongs to, each once.
    std::span<const uint32_t> blocks_at(vec2 film, const TechniqueBlocks& blocks) {
        blocks_.clear();
        const Size2 size = shared_->view.film_size;
        shared_->filter.visit_pixels(film, size, [&](uint32_t pixel, float) {
            const uint32_t block = blocks.index_at(pixel % size.width, pixel / size.width);
            if (std::ranges::find(blocks_, block) == blocks_.end()) blocks_.push_back(block);
        });
        return blocks_;
    }

    void trace_splats() {
        out_->counts.shadow_rays +=
            splats_.trace(shared_->intersector, Coherence::Incoherent, [&](const WaitingSplat& waiting) {
                out_->splats.push_back(waiting.splat);
                const auto first = weights_.begin() + waiting.sample;
                out_->splat_weights.insert(out_->splat_weights.end(), first,
                                           first + static_cast<std::ptrdiff_t>(candidates_.size()));
            });
        weights_.clear();
    }

    void go_on(uint32_t i, const SurfaceVertex& vertex, bool first, float acceptance) {
        const LightPathState& path = batch_.paths[i];
        const PhotonScattering next =
            scatter_photon(vertex.point, vertex.bsdf, vertex.from, choice_.y[i], {direction_.x[i], direction_.y[i]});
        if (!next.valid()) return;
        const Rgb power_w = path.power_w * next.weight;
        const float hope = max_component(power_w) * path.reference_inverse;
        const float survival = std::min(hope, ROULETTE_MOST_SURVIVAL);
        if (!(choice_.x[i] < survival)) return;
        LightPathState& onward = batch_.next_path();
        onward = path;
        onward.power_w = power_w / survival;
        onward.all_delta = path.all_delta && next.delta;
        const float cos_out = std::fabs(glm::dot(vertex.point.geometric_normal, next.direction));
        const VertexSide side{first, next.delta ? 0 : eye_pdf_back(vertex, next.direction), acceptance};
        if (next.delta)
            shared_->mis.scatter_delta(onward.weights, cos_out);
        else
            shared_->mis.scatter(onward.weights, side, next.pdf_sa, cos_out);
        if (techniques_->correlated) {
            onward.density = next.delta ? kInfinity : next.pdf_sa;
            met_[path.place].vertex.go_on(cos_out, onward.density, side.pdf_back);
        }
        if (next.refraction) onward.media.cross(vertex.point.material, vertex.point.front_side);
        batch_.next_ray() = {ray_origin(vertex.point, next.direction), next.direction, kInfinity};
        batch_.keep_next(batch_.keys[i]);
    }

    const BidirectionalScene* shared_ = nullptr;
    const PassTechniques* techniques_ = nullptr;
    const SequenceSampler* sampler_ = nullptr;
    const SequenceRun* run_ = nullptr;
    uint64_t first_of_pass_ = 0;
    RunPaths* out_ = nullptr;
    std::span<const WeighedCandidate> candidates_;
    std::vector<CandidateWeight> weights_;  // by them, of splats that wait
    std::vector<uint32_t> blocks_;          // of the splat at hand

    PathBatch<LightPathState> batch_{kPaths};
    ShadowBatch<WaitingSplat> splats_{kPaths};
    std::vector<EmissionSample> starts_ = std::vector<EmissionSample>(kPaths);
    std::vector<LightEnd> ends_ = std::vector<LightEnd>(kPaths);
    std::vector<MetPlace> met_;
    std::vector<PathVertex> vertices_;  // of the path at hand
    std::vector<uint32_t> next_place_;  // of a path's row
    std::vector<uint32_t> order_;
    Numbers direction_, position_, choice_;
};

}  // namespace

SurfaceVertex LightVertex::surface(const Scene& scene) const {
    SurfaceVertex vertex;
    vertex.from = from;
    vertex.point =
        make_shading_point(scene, {.t = 0, .instance = instance, .triangle = triangle, .u = u, .v = v}, -from);
    vertex.bsdf = make_bsdf(scene, vertex.point, outside_ior);
    return vertex;
}

void LightPaths::sort_by_path(uint32_t paths) {
    first_of_path.assign(size_t{paths} + 1, 0);
    for (const LightVertex& vertex : vertices) ++first_of_path[vertex.path + 1];
    for (size_t i = 0; i < paths; ++i) first_of_path[i + 1] += first_of_path[i];
    std::vector<uint32_t> next(first_of_path.begin(), first_of_path.end() - 1);
    by_path.resize(vertices.size());
    for (uint32_t i = 0; i < vertices.size(); ++i) by_path[next[vertices[i].path]++] = i;
}

HashGrid LightPaths::grid(float radius_m, std::span<uint32_t> order) const {
    std::vector<vec3> positions(vertices.size());
    for (size_t i = 0; i < positions.size(); ++i) positions[i] = vertices[i].position;
    return HashGrid(positions, radius_m, order);
}

void LightPaths::add_splats(const PixelFilterSampler& filter, const TechniqueBlocks* blocks, PassImage& image) const {
    // Rows of the image for each call: every pixel's sum is in the splats' order.
    constexpr uint32_t kRows = 32;
    parallel_for((image.size.height + kRows - 1) / kRows, 1, [&](size_t band) {
        const auto first = static_cast<uint32_t>(band) * kRows, end = std::min(first + kRows, image.size.height);
        const float margin = PixelFilterSampler::kRadius;
        for (const LightSplat& splat : splats) {
            if (splat.film.y < static_cast<float>(first) - margin || splat.film.y > static_cast<float>(end) + margin)
                continue;
            filter.visit_pixels(splat.film, image.size, [&](uint32_t pixel, float density) {
                const uint32_t y = pixel / image.size.width;
                const bool weighed = splat.block == TechniqueBlocks::kOfAll ||
                                     splat.block == blocks->index_at(pixel % image.size.width, y);
                if (y >= first && y < end && weighed)
                    add_joined(image, pixel, splat.scatterings, splat.caustic, Join::LightImage,
                               density * splat.radiance);
            });
        }
    });
}

uint64_t LightPaths::bytes() const {
    return vertices.capacity() * sizeof(LightVertex) + places.capacity() * sizeof(PathVertex) +
           splats.capacity() * sizeof(LightSplat) + (first_of_path.capacity() + by_path.capacity()) * sizeof(uint32_t);
}

struct LightPathTracer::Shared {
    const BidirectionalScene& scene;
    ThreadLocal<LightBatch> threads;
    // Kept from pass to pass, for their room: pages that come and go cost as much as half of what is written there.
    std::vector<RunPaths> runs;
    LightPaths paths;
};

LightPathTracer::LightPathTracer(const BidirectionalScene& shared) : shared_(new Shared{shared, {}, {}, {}}) {}
LightPathTracer::~LightPathTracer() = default;

uint64_t LightPathTracer::bytes() const {
    uint64_t bytes = shared_->paths.bytes();
    for (const RunPaths& run : shared_->runs)
        bytes += run.vertices.capacity() * sizeof(LightVertex) + run.places.capacity() * sizeof(PathVertex) +
                 run.splats.capacity() * sizeof(LightSplat);
    return bytes;
}

uint64_t LightPathTracer::scratch_bytes(size_t threads) { return threads * LightBatch::bytes_per_thread(); }

LightPaths& LightPathTracer::trace(uint64_t seed, uint32_t pass, const PassTechniques& techniques, Counts& counts,
                                   const CancelToken& cancel, std::span<const WeighedCandidate> candidates) {
    LightPaths& paths = shared_->paths;
    paths.vertices.clear();
    paths.places.clear();
    paths.splats.clear();
    paths.splat_weights.clear();
    if (techniques.light_paths == 0 || !(shared_->scene.emission.total_power_w() > 0)) return paths;
    const SequenceSampler sampler(shared_->scene.sampler, seed, RandomDomain::LightPaths, 0);
    const uint64_t first = uint64_t{pass} * techniques.light_paths;
    const SequenceRuns runs{first, first + techniques.light_paths};
    std::vector<RunPaths>& found = shared_->runs;
    found.resize(runs.count());
    parallel_for(found.size(), 1, [&](size_t i) {
        found[i].clear();
        if (cancel.cancelled()) return;
        shared_->threads.local().trace(shared_->scene, techniques, sampler, runs[i], first, candidates, found[i]);
    });
    size_t vertices = 0, places = 0, splats = 0;
    for (const RunPaths& run : found)
        vertices += run.vertices.size(), places += run.places.size(), splats += run.splats.size();
    paths.vertices.reserve(vertices);
    paths.places.reserve(places);
    paths.splats.reserve(splats);
    for (RunPaths& run : found) {
        const auto first_place = static_cast<uint32_t>(paths.places.size());
        if (techniques.correlated) {
            for (LightVertex& vertex : run.vertices) vertex.place += first_place;
            paths.places.insert(paths.places.end(), run.places.begin(), run.places.end());
        }
        paths.vertices.insert(paths.vertices.end(), run.vertices.begin(), run.vertices.end());
        paths.splats.insert(paths.splats.end(), run.splats.begin(), run.splats.end());
        paths.splat_weights.insert(paths.splat_weights.end(), run.splat_weights.begin(), run.splat_weights.end());
        counts += run.counts;
    }
    return paths;
}

}  // namespace photond
