#include "renderer/photons/photon_wavefront.h"

#include "renderer/photons/projection_map.h"
#include "renderer/transport/hit_prefetch.h"
#include "renderer/transport/lambert_lanes.h"
#include "renderer/transport/photon_scattering.h"

namespace photond {

namespace {

/// No path outlives roulette for ever, however white the scene.
constexpr float kMostSurvival = 0.98f;

/// Whether some place of such a surface may scatter diffusely.
bool may_be_diffuse(const Material& m) {
    return !m.unlit && !is_black(m.base_color) && m.transmission < 1 &&
           (m.metallic < 1 || m.metallic_roughness_texture.used());
}

/// Whether power is fit to go on; counted where it is not finite.
bool is_sound(const Rgb& power_w, Counts& counts) {
    if (is_finite(power_w)) return true;
    const bool nan = std::isnan(power_w.x) || std::isnan(power_w.y) || std::isnan(power_w.z);
    ++(nan ? counts.nan_samples : counts.infinite_samples);
    return false;
}

}  // namespace

PhotonTracingScene::PhotonTracingScene(const Scene& s, const Intersector& i, const EmissionSampler& e,
                                       const PhotonTracing& t)
    : scene(s), intersector(i), emission(e), tracing(t), absorption(s) {
    shading.reserve(scene.instances.size());
    for (uint32_t index = 0; index < scene.instances.size(); ++index) {
        const Mesh& mesh = scene.meshes[scene.instances[index].mesh];
        const Material& material = scene.materials[mesh.material];
        const bool lambert = is_plain_lambert(material), varies = base_color_varies(scene, mesh);
        shading.push_back({.lambert = lambert,
                           .stores = (lambert || varies) && may_be_diffuse(material),
                           .surface = LambertSurface(scene, index)});
    }
}

PhotonWavefront::PhotonWavefront()
    : rays_(kPaths),
      next_rays_(kPaths),
      paths_(kPaths),
      next_paths_(kPaths),
      elements_(kPaths),
      next_elements_(kPaths),
      starts_(kPaths),
      ranges_(kPaths),
      hits_(kPaths),
      drawn_elements_(kPaths) {
    order_.reserve(kPaths);
    general_.reserve(kPaths);
    kept_.reserve(kPaths);
    for (Numbers* numbers : {&direction_, &position_, &choice_}) numbers->x.resize(kPaths), numbers->y.resize(kPaths);
}

uint64_t PhotonWavefront::bytes_per_thread() {
    // As many photons as paths come at each vertex; a bright closed room has some
    // ten vertices that matter.
    constexpr uint64_t kPhotonsPerPath = 10;
    return kPaths * (2 * sizeof(Ray) + sizeof(EmissionSample) + sizeof(Hit) + sizeof(Kept) + 2 * sizeof(Path) +
                     5 * sizeof(uint32_t) + 7 * sizeof(float) + kPhotonsPerPath * sizeof(Photon));
}

std::span<const Photon> PhotonWavefront::trace(const PhotonTracingScene& shared, const SequenceSampler& sampler,
                                               const PhotonBatch& batch, PhotonCounts& counts) {
    photon_count_ = 0;
    start_paths(shared, sampler, batch, counts.counts);
    for (uint32_t scatterings = 0; count_ > 0; ++scatterings) {
        shared.intersector.closest_hits({rays_.data(), count_}, {hits_.data(), count_}, Coherence::Incoherent);
        counts.counts.photon_rays += count_;
        sort_hits(shared, scatterings);
        draw_numbers(shared, sampler, batch.run, scatterings);
        // So that storing need not ask for room.
        if (photons_.size() < photon_count_ + order_.size()) photons_.resize(2 * (photon_count_ + order_.size()));
        next_count_ = 0;
        shade_lambert(shared, scatterings, counts.counts);
        shade_general(shared, scatterings, counts);
        next_paths_.swap(paths_);
        next_rays_.swap(rays_);
        next_elements_.swap(elements_);
        count_ = next_count_;
    }
    counts.counts.photons_emitted += batch.last - batch.first;
    counts.counts.photons_stored += photon_count_;
    return {photons_.data(), photon_count_};
}

void PhotonWavefront::start_paths(const PhotonTracingScene& shared, const SequenceSampler& sampler,
                                  const PhotonBatch& batch, Counts& counts) {
    const size_t emitted = batch.last - batch.first;
    for (uint32_t i = 0; i < emitted; ++i) drawn_elements_[i] = batch.first + i;
    const auto draw = [&](EmissionSet set, Numbers& numbers) {
        sampler.sample_2d(batch.run, {drawn_elements_.data(), emitted}, sample_set(set), {numbers.x.data(), emitted},
                          {numbers.y.data(), emitted});
    };
    draw(EmissionSet::Light, choice_);
    draw(EmissionSet::Position, position_);
    draw(EmissionSet::Direction, direction_);

    const ProjectionMap* guide = shared.tracing.guide;
    const float share = 1 / static_cast<float>(shared.tracing.photons);
    count_ = 0;
    if (guide) {
        for (uint32_t i = 0; i < emitted; ++i)
            if (!guide->sample(choice_.x[i], {position_.x[i], position_.y[i]}, {direction_.x[i], direction_.y[i]},
                               starts_[i]))
                starts_[i].power_w = Rgb(0);
    } else {
        shared.emission.sample({choice_.x, position_.x, position_.y, direction_.x, direction_.y},
                               {starts_.data(), emitted});
    }
    for (uint32_t i = 0; i < emitted; ++i) {
        const EmissionSample& start = starts_[i];
        if (is_black(start.power_w) || !is_sound(start.power_w, counts)) continue;
        Path& path = paths_[count_];
        path.power_w = start.power_w * share;
        path.reference_inverse = 1 / max_component(path.power_w);
        path.rough = false;
        path.all_delta = true;
        path.media = {};
        rays_[count_] = start.ray;
        ranges_[count_] = start.range_m;
        elements_[count_++] = batch.first + i;
    }
}

/// Drops the paths that met nothing, takes what the way took from the others,
/// and tells them apart.
void PhotonWavefront::sort_hits(const PhotonTracingScene& shared, uint32_t scatterings) {
    const bool absorbs = shared.scene.needs.solid_glass;
    order_.clear();
    general_.clear();
    for (uint32_t i = 0; i < count_; ++i) {
        const Hit& hit = hits_[i];
        if (!hit.valid()) continue;
        Path& path = paths_[i];
        if (scatterings == 0 && ranges_[i] < kInfinity) path.power_w *= range_window(hit.t, ranges_[i]);
        if (absorbs) path.power_w *= shared.absorption.transmittance(path.media, hit.t);
        if (is_black(path.power_w)) continue;
        prefetch_index(shared.scene, hit);
        (shared.shading[hit.instance].lambert ? order_ : general_).push_back(i);
    }
    lambert_count_ = order_.size();
    order_.insert(order_.end(), general_.begin(), general_.end());
}

/// Of all that may scatter.
void PhotonWavefront::draw_numbers(const PhotonTracingScene& shared, const SequenceSampler& sampler, uint64_t run,
                                   uint32_t scatterings) {
    if (scatterings >= shared.tracing.most_scatterings) return;
    const size_t first = shared.tracing.kind == PhotonMapKind::Caustic ? lambert_count_ : 0;
    const size_t count = order_.size() - first;
    if (count == 0) return;
    for (size_t k = 0; k < count; ++k) drawn_elements_[k] = elements_[order_[first + k]];
    const auto draw = [&](ScatteringSet set, Numbers& numbers) {
        sampler.sample_2d(run, {drawn_elements_.data(), count}, sample_set(scatterings + 1, set),
                          {numbers.x.data() + first, count}, {numbers.y.data() + first, count});
    };
    draw(ScatteringSet::Direction, direction_);
    draw(ScatteringSet::RouletteAndLobe, choice_);
}

void PhotonWavefront::store(const Path& path, const vec3& position, const vec3& normal, const vec3& wi_world,
                            uint32_t scatterings) {
    photons_[photon_count_++] = {position,
                                 PhotonPayload::make(path.power_w, wi_world, normal, scatterings, path.all_delta)};
}

/// Asks for texture coordinates some hits ahead of their use, and for the texels, whose place they say, some fewer.
void PhotonWavefront::ask_texels(const PhotonTracingScene& shared, size_t place) {
    constexpr size_t kCoordinates = 48, kTexels = 24;
    static_assert(kTexels < kLookups);
    const auto coordinates = [&](size_t k) {
        if (k >= lambert_count_) return;
        const Hit& hit = hits_[order_[k]];
        shared.shading[hit.instance].surface.prefetch_coordinates(hit);
    };
    const auto texels = [&](size_t k) {
        if (k >= lambert_count_) return;
        const Hit& hit = hits_[order_[k]];
        const LambertSurface& surface = shared.shading[hit.instance].surface;
        if (!surface.texture) return;
        TextureLookup& lookup = lookups_[k % kLookups];
        lookup = surface.lookup(hit);
        prefetch(lookup);
    };
    if (place == 0) {
        for (size_t k = 0; k < kCoordinates; ++k) coordinates(k);
        for (size_t k = 0; k < kTexels; ++k) texels(k);
    }
    coordinates(place + kCoordinates);
    texels(place + kTexels);
}

/// Keeps the paths that may survive at plain Lambert reflectors or leave a photon. Of the others the triangle's corners
/// need not be fetched.
void PhotonWavefront::keep_some(const PhotonTracingScene& shared, uint32_t scatterings) {
    const bool caustic = shared.tracing.kind == PhotonMapKind::Caustic;
    const bool scatters = !caustic && scatterings < shared.tracing.most_scatterings;
    const bool textured = scatters && shared.scene.needs.base_color_textures;
    kept_.resize(lambert_count_);
    size_t count = 0;
    for (uint32_t place = 0; place < lambert_count_; ++place) {
        if (textured) ask_texels(shared, place);
        const uint32_t i = order_[place];
        const Path& path = paths_[i];
        const PhotonTracingScene::Shading& shading = shared.shading[hits_[i].instance];
        Kept kept{
            .place = place, .stores = (caustic || path.rough) && shading.stores, .hope = 0, .reflectance = Rgb(0)};
        bool may_survive = false;
        if (scatters) {
            kept.reflectance = shading.surface.varies()
                                   ? shading.surface.reflectance(hits_[i], lookups_[place % kLookups])
                                   : shading.surface.base_color;
            kept.hope = max_component(path.power_w * kept.reflectance) * path.reference_inverse;
            // Where the mesh is smooth its normals may raise the hope.
            may_survive = shading.surface.normals || !(choice_.x[place] >= std::min(kept.hope, kMostSurvival));
        }
        kept_[count] = kept;  // without a branch, which nobody could foresee
        count += static_cast<size_t>(kept.stores | may_survive);
    }
    kept_.resize(count);
}

/// Hits on plain Lambert reflectors: always rough, so that caustic paths end there.
void PhotonWavefront::shade_lambert(const PhotonTracingScene& shared, uint32_t scatterings, Counts& counts) {
    const bool caustic = shared.tracing.kind == PhotonMapKind::Caustic;
    const bool scatters = !caustic && scatterings < shared.tracing.most_scatterings;
    if (caustic && scatterings == 0) return;
    keep_some(shared, scatterings);
    const auto ask_corners = [&](size_t k) {
        if (k >= kept_.size()) return;
        const Hit& hit = hits_[order_[kept_[k].place]];
        shared.shading[hit.instance].surface.prefetch_corners(hit);
    };
    constexpr size_t kAhead = 24;
    for (size_t k = 0; k < kAhead; ++k) ask_corners(k);

    LambertGroup group;
    for (size_t first = 0; first < kept_.size(); first += kLanes) {
        const size_t lanes = std::min(kLanes, kept_.size() - first);
        for (size_t lane = 0; lane < kLanes; ++lane) {  // lanes past the end repeat the last path and are not read
            ask_corners(first + lane + kAhead);
            const uint32_t place = kept_[std::min(first + lane, kept_.size() - 1)].place;
            const uint32_t i = order_[place];
            group.gather(lane, shared.shading[hits_[i].instance].surface, hits_[i], rays_[i]);
            group.sample_x[lane] = direction_.x[place];
            group.sample_y[lane] = direction_.y[place];
        }
        group.find_surface();
        group.scatter_photons();

        for (size_t lane = 0; lane < lanes; ++lane) {
            const Kept& kept = kept_[first + lane];
            const uint32_t i = order_[kept.place];
            const Path& path = paths_[i];
            if (kept.stores)
                store(path, group.position.get(lane), group.geometric_normal.get(lane), -rays_[i].direction,
                      scatterings);
            if (!scatters || group.scattered[lane] == 0) continue;
            const float hope = kept.hope * group.correction[lane];
            const float survival = std::min(hope, kMostSurvival);
            if (!(choice_.x[kept.place] < survival)) {
                if (std::isnan(hope)) ++counts.nan_samples;
                continue;
            }
            Path& next = next_paths_[next_count_];
            next.power_w = path.power_w * kept.reflectance * (group.correction[lane] * (1 / survival));
            if (!is_sound(next.power_w, counts)) continue;
            next.reference_inverse = path.reference_inverse;
            next.rough = true;
            next.all_delta = false;
            next.media = path.media;
            next_rays_[next_count_] = {group.start.get(lane), group.next_direction.get(lane), kInfinity};
            next_elements_[next_count_++] = elements_[i];
        }
    }
}

/// Any other hits, one by one.
void PhotonWavefront::shade_general(const PhotonTracingScene& shared, uint32_t scatterings, PhotonCounts& counts) {
    const std::span<const uint32_t> order = std::span<const uint32_t>(order_).subspan(lambert_count_);
    for (size_t k = 0; k < order.size(); ++k) {
        prefetch_ahead(shared.scene, hits_, order, k);
        if (scatter_general(shared, lambert_count_ + k, scatterings, counts))
            next_elements_[next_count_++] = elements_[order[k]];
    }
}

/// Stores the photon and draws the next ray. False: the path ends, and what stands in the place of the next path does
/// not count.
bool PhotonWavefront::scatter_general(const PhotonTracingScene& shared, size_t place, uint32_t scatterings,
                                      PhotonCounts& counts) {
    const Scene& scene = shared.scene;
    const PhotonTracing& tracing = shared.tracing;
    const uint32_t i = order_[place];
    const Path& path = paths_[i];
    const vec3 wi_world = -rays_[i].direction;
    const ShadingPoint point = make_shading_point(scene, hits_[i], rays_[i].direction);
    if (scene.materials[point.material].unlit) return false;

    const float threshold = tracing.glossy_threshold;
    const float outside_ior = path.media.outside_ior(scene, point.material, !point.front_side);
    const Bsdf bsdf = make_bsdf(scene, point, outside_ior);
    const Bsdf specular = bsdf.specular_part(threshold), rough = bsdf.rough_part(threshold);
    const bool caustic = tracing.kind == PhotonMapKind::Caustic;
    if (scatterings == 0 && specular.scatters()) ++counts.first_hits_specular;
    if ((caustic ? scatterings > 0 : path.rough) && (rough.scatters() || shared.shading[point.instance].stores))
        store(path, point.position, point.geometric_normal, wi_world, scatterings);
    if (scatterings >= tracing.most_scatterings) return false;

    // Each part is tried; one number then chooses between them and absorption, by what they leave of the power.
    const vec2 u(direction_.x[place], direction_.y[place]);
    const float u_lobe = choice_.y[place];
    PhotonScattering by_specular, by_rough;
    if (specular.scatters()) by_specular = scatter_photon(point, specular, wi_world, u_lobe, u);
    if (!caustic && rough.scatters()) by_rough = scatter_photon(point, rough, wi_world, u_lobe, u);
    const Rgb specular_w = path.power_w * by_specular.weight, rough_w = path.power_w * by_rough.weight;
    if (!is_sound(specular_w, counts.counts) || !is_sound(rough_w, counts.counts)) return false;
    const float specular_hope = max_component(specular_w) * path.reference_inverse;
    const float rough_hope = max_component(rough_w) * path.reference_inverse;
    const float hope = specular_hope + rough_hope;
    if (!(hope > 0)) return false;
    const float share = std::min(1.0f, kMostSurvival / hope);  // of the hope that is granted
    const float roulette = choice_.x[place];
    if (roulette >= hope * share) return false;
    const bool is_rough = roulette >= specular_hope * share;
    const PhotonScattering& chosen = is_rough ? by_rough : by_specular;

    Path& next = next_paths_[next_count_];
    next = path;
    next.power_w = (is_rough ? rough_w : specular_w) / ((is_rough ? rough_hope : specular_hope) * share);
    if (!is_sound(next.power_w, counts.counts)) return false;
    next.rough = path.rough || is_rough;
    next.all_delta = path.all_delta && chosen.delta;
    if (chosen.refraction) next.media.cross(point.material, point.front_side);
    next_rays_[next_count_] = {ray_origin(point, chosen.direction), chosen.direction, kInfinity};
    return true;
}

}  // namespace photond
