#include "renderer/photons/photon_wavefront.h"

#include "renderer/photons/projection_map.h"
#include "renderer/transport/hit_prefetch.h"
#include "renderer/transport/roulette_shared.h"

namespace photond {

namespace {

/// Whether some place of such a surface may scatter diffusely.
bool may_be_diffuse(const Material& m) {
    return !m.unlit && !is_black(m.base_color) && m.transmission < 1 &&
           (m.metallic < 1 || m.metallic_roughness_texture.used());
}

}  // namespace

bool stores_photons(const Scene& scene, uint32_t instance) {
    const Mesh& mesh = scene.meshes[scene.instances[instance].mesh];
    const Material& material = scene.materials[mesh.material];
    return (is_plain_lambert(material) || base_color_varies(scene, mesh)) && may_be_diffuse(material);
}

PhotonTracingScene::PhotonTracingScene(const Scene& s, const Intersector& first, const Intersector& later,
                                       const EmissionSampler& e, const PhotonTracing& t)
    : scene(s), intersector(first), later_intersector(later), emission(e), tracing(t), absorption(s) {
    shading.reserve(scene.instances.size());
    for (uint32_t index = 0; index < scene.instances.size(); ++index) {
        const Mesh& mesh = scene.meshes[scene.instances[index].mesh];
        shading.push_back({.lambert = is_plain_lambert(scene.materials[mesh.material]),
                           .stores = stores_photons(scene, index),
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
    const bool caustic = shared.tracing.kind == PhotonMapKind::Caustic;
    for (uint32_t scatterings = 0; count_ > 0; ++scatterings) {
        find_hits(shared, scatterings, counts.counts);
        if (scatterings < shared.tracing.most_scatterings)
            draw_numbers(sampler, batch.run, scatterings, caustic ? lambert_count_ : 0);
        // So that storing need not ask for room.
        if (photons_.size() < photon_count_ + order_.size()) photons_.resize(2 * (photon_count_ + order_.size()));
        shade_lambert(shared, scatterings, counts.counts);
        shade_general(shared, scatterings, counts);
        advance();
    }
    counts.counts.photons_emitted += batch.last - batch.first;
    counts.counts.photons_stored += photon_count_;
    return {photons_.data(), photon_count_};
}

void PhotonWavefront::start_paths(const PhotonTracingScene& shared, const SequenceSampler& sampler,
                                  const PhotonBatch& batch, Counts& counts) {
    const size_t emitted = batch.last - batch.first;
    const bool texels = batch.texels || batch.map;
    chosen_ = batch.chosen;
    for (uint32_t i = 0; i < emitted; ++i) drawn_elements_[i] = batch.first + i;
    const auto draw = [&](uint32_t set, Numbers& numbers) {
        sampler.sample_2d(batch.run, {drawn_elements_.data(), emitted}, set, {numbers.x.data(), emitted},
                          {numbers.y.data(), emitted});
    };
    if (!chosen_) {
        draw(texels ? kJitterSet : sample_set(EmissionSet::Light), choice_);
        draw(sample_set(EmissionSet::Position), position_);
        draw(sample_set(EmissionSet::Direction), direction_);
    }

    const ProjectionMap* guide = shared.tracing.guide;
    const uint64_t first = batch.run * kPaths + batch.first;
    const auto start_each = [&](const auto& sample) {
        for (uint32_t i = 0; i < emitted; ++i)
            if (!sample(i, vec2(position_.x[i], position_.y[i]), vec2(direction_.x[i], direction_.y[i]), starts_[i]))
                starts_[i].power_w = Rgb(0);
    };
    count_ = 0;
    if (chosen_) {
        for (uint32_t i = 0; i < emitted; ++i)
            starts_[i] = start_at_texel(*batch.chosen, batch.chosen->starts[first + i]);
    } else if (batch.map) {
        start_each([&](uint32_t i, const vec2& u_position, const vec2& u_direction, EmissionSample& start) {
            return batch.map->sample(static_cast<uint32_t>(first) + i, {choice_.x[i], choice_.y[i]}, u_position,
                                     u_direction, start);
        });
    } else if (batch.texels) {
        start_each([&](uint32_t i, const vec2& u_position, const vec2& u_direction, EmissionSample& start) {
            return batch.texels->sample(first + i, {choice_.x[i], choice_.y[i]}, u_position, u_direction, start);
        });
    } else if (guide) {
        start_each([&](uint32_t i, const vec2& u_position, const vec2& u_direction, EmissionSample& start) {
            return guide->sample(choice_.x[i], u_position, u_direction, start);
        });
    } else {
        shared.emission.sample({choice_.x, position_.x, position_.y, direction_.x, direction_.y},
                               {starts_.data(), emitted});
    }
    for (uint32_t i = 0; i < emitted; ++i) {
        const EmissionSample& start = starts_[i];
        if (is_black(start.power_w) || !is_sound(start.power_w, counts)) continue;
        Path& path = paths_[count_];
        if (chosen_) {
            const ChosenStart& mine = batch.chosen->starts[first + i];
            path.power_w = start.power_w * mine.share;
            path.reference_inverse = 1 / (mine.flux_w * mine.share);
        } else {
            path.power_w = texels ? start.power_w : start.power_w * (1 / static_cast<float>(shared.tracing.photons));
            path.reference_inverse = 1 / max_component(path.power_w);
        }
        path.rough = false;
        path.all_delta = true;
        path.media = {};
        rays_[count_] = start.ray;
        ranges_[count_] = start.range_m;
        elements_[count_++] = batch.first + i;
    }
}

EmissionSample PhotonWavefront::start_at_texel(const ChosenStarts& chosen, const ChosenStart& start) const {
    const auto numbers = [&](uint32_t set) { return chosen.texel_numbers.sample_2d(start.texel, set); };
    EmissionSample sample;
    if (!chosen.map.sample(start.texel, numbers(kJitterSet), numbers(sample_set(EmissionSet::Position)),
                           numbers(sample_set(EmissionSet::Direction)), sample))
        sample.power_w = Rgb(0);
    return sample;
}

void PhotonWavefront::find_hits(const PhotonTracingScene& shared, uint32_t scatterings, Counts& counts) {
    const Intersector& intersector = scatterings == 0 ? shared.intersector : shared.later_intersector;
    intersector.closest_hits({rays_.data(), count_}, {hits_.data(), count_}, Coherence::Incoherent);
    counts.photon_rays += count_;
    sort_hits(shared, scatterings);
    next_count_ = 0;
}

/// To the paths' next vertices.
void PhotonWavefront::advance() {
    next_paths_.swap(paths_);
    next_rays_.swap(rays_);
    next_elements_.swap(elements_);
    count_ = next_count_;
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

/// Of all that may scatter: those from place `first` on.
void PhotonWavefront::draw_numbers(const SequenceSampler& sampler, uint64_t run, uint32_t scatterings, size_t first) {
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
void PhotonWavefront::keep_some(const PhotonTracingScene& shared, uint32_t scatterings, Record record) {
    const bool arrivals = record == Record::Arrivals;
    const bool caustic = arrivals && shared.tracing.kind == PhotonMapKind::Caustic;
    const bool scatters = !caustic && scatterings < shared.tracing.most_scatterings;
    const bool textured = scatters && shared.scene.needs.base_color_textures;
    const float most = most_survival(scatterings);
    kept_.resize(lambert_count_);
    size_t count = 0;
    for (uint32_t place = 0; place < lambert_count_; ++place) {
        if (textured) ask_texels(shared, place);
        const uint32_t i = order_[place];
        const Path& path = paths_[i];
        const PhotonTracingScene::Shading& shading = shared.shading[hits_[i].instance];
        Kept kept{.place = place,
                  .stores = arrivals && (caustic || path.rough) && shading.stores,
                  .hope = 0,
                  .reflectance = Rgb(0)};
        bool may_survive = false;
        if (scatters) {
            kept.reflectance = shading.surface.varies()
                                   ? shading.surface.reflectance(hits_[i], lookups_[place % kLookups])
                                   : shading.surface.base_color;
            kept.hope = max_component(path.power_w * kept.reflectance) * path.reference_inverse;
            // Where the mesh is smooth its normals may raise the hope.
            may_survive = (arrivals && shading.surface.normals) || record == Record::Everything ||
                          !(choice_.x[place] >= std::min(kept.hope, most));
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
    keep_some(shared, scatterings, Record::Arrivals);
    scatter_lambert(shared, [&](const Kept& kept, const LambertGroup& group, size_t lane) {
        const uint32_t i = order_[kept.place];
        const Path& path = paths_[i];
        if (kept.stores)
            store(path, group.position.get(lane), group.geometric_normal.get(lane), -rays_[i].direction, scatterings);
        if (!scatters || group.scattered[lane] == 0) return;
        const float hope = kept.hope * group.correction[lane];
        const float survival = std::min(hope, ROULETTE_MOST_SURVIVAL);
        if (!(choice_.x[kept.place] < survival)) {
            if (std::isnan(hope)) ++counts.nan_samples;
            return;
        }
        const Rgb power_w = path.power_w * kept.reflectance * (group.correction[lane] * (1 / survival));
        if (is_sound(power_w, counts)) go_on_from_lambert(i, power_w, group, lane);
    });
}

void PhotonWavefront::go_on_from_lambert(uint32_t path, const Rgb& power_w, const LambertGroup& group, size_t lane) {
    Path& next = next_paths_[next_count_];
    next.power_w = power_w;
    next.reference_inverse = paths_[path].reference_inverse;
    next.rough = true;
    next.all_delta = false;
    next.media = paths_[path].media;
    next_rays_[next_count_] = {group.start.get(lane), group.next_direction.get(lane), kInfinity};
    next_elements_[next_count_++] = elements_[path];
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

/// False: nothing scatters there.
bool PhotonWavefront::part_hit(const PhotonTracingScene& shared, uint32_t path, PartedHit& parted) const {
    const Scene& scene = shared.scene;
    parted.wi_world = -rays_[path].direction;
    parted.point = make_shading_point(scene, hits_[path], rays_[path].direction);
    const ShadingPoint& point = parted.point;
    if (scene.materials[point.material].unlit) return false;
    parted.outside_ior = paths_[path].media.outside_ior(scene, point.material, !point.front_side);
    const Bsdf bsdf = make_bsdf(scene, point, parted.outside_ior);
    parted.specular = bsdf.specular_part(shared.tracing.glossy_threshold);
    parted.rough = bsdf.rough_part(shared.tracing.glossy_threshold);
    return true;
}

/// Stores the photon and draws the next ray. False: the path ends, and what stands in the place of the next path does
/// not count.
bool PhotonWavefront::scatter_general(const PhotonTracingScene& shared, size_t place, uint32_t scatterings,
                                      PhotonCounts& counts) {
    const PhotonTracing& tracing = shared.tracing;
    const uint32_t i = order_[place];
    const Path& path = paths_[i];
    PartedHit parted;
    if (!part_hit(shared, i, parted)) return false;
    const ShadingPoint& point = parted.point;
    const bool caustic = tracing.kind == PhotonMapKind::Caustic;
    if (scatterings == 0 && parted.specular.scatters()) ++counts.first_hits_specular;
    if ((caustic ? scatterings > 0 : path.rough) && (parted.rough.scatters() || shared.shading[point.instance].stores))
        store(path, point.position, point.geometric_normal, parted.wi_world, scatterings);
    if (scatterings >= tracing.most_scatterings) return false;
    return scatter_parted(parted, place, !caustic, counts.counts).goes_on;
}

/// Draws the next ray, by the rough part only if `by_rough`. Where the path ends, what stands in the place of the next
/// path does not count.
PhotonWavefront::PartedScattering PhotonWavefront::scatter_parted(const PartedHit& parted, size_t place, bool by_rough,
                                                                  Counts& counts) {
    const Path& path = paths_[order_[place]];
    const ShadingPoint& point = parted.point;
    // Each part is tried; one number then chooses between them and absorption, by what they leave of the power.
    const vec2 u(direction_.x[place], direction_.y[place]);
    const float u_lobe = choice_.y[place];
    PhotonScattering specular, rough;
    if (parted.specular.scatters()) specular = scatter_photon(point, parted.specular, parted.wi_world, u_lobe, u);
    if (by_rough && parted.rough.scatters()) rough = scatter_photon(point, parted.rough, parted.wi_world, u_lobe, u);
    const Rgb specular_w = path.power_w * specular.weight, rough_w = path.power_w * rough.weight;
    if (!is_sound(specular_w, counts) || !is_sound(rough_w, counts)) return {};
    const float specular_hope = max_component(specular_w) * path.reference_inverse;
    const float rough_hope = max_component(rough_w) * path.reference_inverse;
    const float hope = specular_hope + rough_hope;
    if (!(hope > 0)) return {};
    const float share = std::min(1.0f, ROULETTE_MOST_SURVIVAL / hope);  // of the hope that is granted
    const float roulette = choice_.x[place];
    if (roulette >= hope * share) return {};
    const bool is_rough = roulette >= specular_hope * share;
    const PhotonScattering& chosen = is_rough ? rough : specular;

    Path& next = next_paths_[next_count_];
    next = path;
    next.power_w = (is_rough ? rough_w : specular_w) / ((is_rough ? rough_hope : specular_hope) * share);
    if (!is_sound(next.power_w, counts)) return {};
    next.rough = path.rough || is_rough;
    next.all_delta = path.all_delta && chosen.delta;
    if (chosen.refraction) next.media.cross(point.material, point.front_side);
    next_rays_[next_count_] = {ray_origin(point, chosen.direction), chosen.direction, kInfinity};
    return {.goes_on = true, .is_rough = is_rough};
}

}  // namespace photond
