#include "renderer/photons/photon_wavefront.h"

#include "renderer/photons/projection_map.h"

namespace photond {

PhotonWavefront::PhotonWavefront() : starts_(kPaths), ranges_(kPaths), drawn_elements_(kPaths) {
    order.reserve(kPaths);
    general_.reserve(kPaths);
    kept_.reserve(kPaths);
    for (Numbers* numbers : {&direction, &position, &choice}) numbers->x.resize(kPaths), numbers->y.resize(kPaths);
}

uint64_t PhotonWavefront::bytes_per_thread() {
    return PathBatch<LightPath>::bytes_for(kPaths) +
           kPaths * (sizeof(EmissionSample) + sizeof(KeptPath) + 3 * sizeof(uint32_t) + 7 * sizeof(float));
}

void PhotonWavefront::start_paths(const PhotonTracingScene& shared, const SequenceSampler& sampler,
                                  const PhotonBatch& photons, Counts& counts) {
    const size_t emitted = photons.last - photons.first;
    const bool texels = photons.texels || photons.map;
    chosen_ = photons.chosen;
    for (uint32_t i = 0; i < emitted; ++i) drawn_elements_[i] = photons.first + i;
    const auto draw = [&](uint32_t set, Numbers& numbers) {
        sampler.sample_2d(photons.run, {drawn_elements_.data(), emitted}, set, {numbers.x.data(), emitted},
                          {numbers.y.data(), emitted});
    };
    if (!chosen_) {
        draw(texels ? kJitterSet : sample_set(EmissionSet::Light), choice);
        draw(sample_set(EmissionSet::Position), position);
        draw(sample_set(EmissionSet::Direction), direction);
    }

    const ProjectionMap* guide = shared.tracing.guide;
    const uint64_t first = photons.run * kPaths + photons.first;
    const auto start_each = [&](const auto& sample) {
        for (uint32_t i = 0; i < emitted; ++i)
            if (!sample(i, vec2(position.x[i], position.y[i]), vec2(direction.x[i], direction.y[i]), starts_[i]))
                starts_[i].power_w = Rgb(0);
    };
    batch.count = 0;
    if (chosen_) {
        for (uint32_t i = 0; i < emitted; ++i) starts_[i] = chosen_->starts[first + i].first;
    } else if (photons.map) {
        start_each([&](uint32_t i, const vec2& u_position, const vec2& u_direction, EmissionSample& start) {
            return photons.map->sample(static_cast<uint32_t>(first) + i, {choice.x[i], choice.y[i]}, u_position,
                                       u_direction, start);
        });
    } else if (photons.texels) {
        start_each([&](uint32_t i, const vec2& u_position, const vec2& u_direction, EmissionSample& start) {
            return photons.texels->sample(first + i, {choice.x[i], choice.y[i]}, u_position, u_direction, start);
        });
    } else if (guide) {
        start_each([&](uint32_t i, const vec2& u_position, const vec2& u_direction, EmissionSample& start) {
            return guide->sample(choice.x[i], u_position, u_direction, start);
        });
    } else {
        shared.emission.sample({choice.x, position.x, position.y, direction.x, direction.y}, {starts_.data(), emitted});
    }
    for (uint32_t i = 0; i < emitted; ++i) {
        const EmissionSample& start = starts_[i];
        if (is_black(start.power_w) || !is_sound(start.power_w, counts)) continue;
        LightPath& path = batch.paths[batch.count];
        if (chosen_) {
            path.power_w = start.power_w;
            path.reference_inverse = 1 / chosen_->starts[first + i].reflected_w;
        } else {
            path.power_w = texels ? start.power_w : start.power_w * (1 / static_cast<float>(shared.tracing.photons));
            path.reference_inverse = 1 / max_component(path.power_w);
        }
        path.rough = false;
        path.all_delta = true;
        path.media = {};
        batch.rays[batch.count] = start.ray;
        ranges_[batch.count] = start.range_m;
        batch.keys[batch.count++] = photons.first + i;
    }
}

void PhotonWavefront::find_hits(const PhotonTracingScene& shared, uint32_t scatterings, Counts& counts) {
    batch.find_hits(scatterings == 0 ? shared.intersector : shared.later_intersector, Coherence::Incoherent);
    counts.photon_rays += batch.count;
    sort_hits(shared, scatterings);
}

/// Drops the paths that met nothing, takes what the way took from the others, and tells them apart.
void PhotonWavefront::sort_hits(const PhotonTracingScene& shared, uint32_t scatterings) {
    const bool absorbs = shared.scene.needs.solid_glass;
    order.clear();
    general_.clear();
    for (uint32_t i = 0; i < batch.count; ++i) {
        const Hit& hit = batch.hits[i];
        if (!hit.valid()) continue;
        LightPath& path = batch.paths[i];
        if (scatterings == 0 && ranges_[i] < kInfinity) path.power_w *= range_window(hit.t, ranges_[i]);
        if (absorbs) path.power_w *= shared.absorption.transmittance(path.media, hit.t);
        if (is_black(path.power_w)) continue;
        prefetch_index(shared.scene, hit);
        (shared.shading[hit.instance].lambert ? order : general_).push_back(i);
    }
    lambert_count = order.size();
    order.insert(order.end(), general_.begin(), general_.end());
}

void PhotonWavefront::draw_numbers(const SequenceSampler& sampler, uint64_t run, uint32_t scatterings, size_t first) {
    const size_t count = order.size() - first;
    if (count == 0) return;
    if (chosen_ && chosen_->elements_apart) {
        for (size_t k = first; k < order.size(); ++k) {
            const uint64_t start = run * kPaths + batch.keys[order[k]];
            const uint32_t element = chosen_->starts[start].element;
            const auto point = [&](ScatteringSet set) {
                return sampler.sample_2d(element, sample_set(scatterings + 1, set));
            };
            const vec2 to = point(ScatteringSet::Direction), by = point(ScatteringSet::RouletteAndLobe);
            direction.x[k] = to.x, direction.y[k] = to.y;
            choice.x[k] = by.x, choice.y[k] = by.y;
        }
        return;
    }
    for (size_t k = 0; k < count; ++k) drawn_elements_[k] = batch.keys[order[first + k]];
    const auto draw = [&](ScatteringSet set, Numbers& numbers) {
        sampler.sample_2d(run, {drawn_elements_.data(), count}, sample_set(scatterings + 1, set),
                          {numbers.x.data() + first, count}, {numbers.y.data() + first, count});
    };
    draw(ScatteringSet::Direction, direction);
    draw(ScatteringSet::RouletteAndLobe, choice);
}

/// Asks for texture coordinates some hits ahead of their use, and for the texels, whose place they say, some fewer.
void PhotonWavefront::ask_texels(const PhotonTracingScene& shared, size_t place) {
    constexpr size_t kCoordinates = 48, kTexels = 24;
    static_assert(kTexels < kLookups);
    const auto coordinates = [&](size_t k) {
        if (k >= lambert_count) return;
        const Hit& hit = batch.hits[order[k]];
        shared.shading[hit.instance].surface.prefetch_coordinates(hit);
    };
    const auto texels = [&](size_t k) {
        if (k >= lambert_count) return;
        const Hit& hit = batch.hits[order[k]];
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

void PhotonWavefront::keep_some(const PhotonTracingScene& shared, uint32_t scatterings, PhotonRecord record) {
    const bool arrivals = record == PhotonRecord::Arrivals;
    const bool caustic = arrivals && shared.tracing.kind == PhotonMapKind::Caustic;
    const bool scatters = !caustic && scatterings < shared.tracing.most_scatterings;
    const bool textured = scatters && shared.scene.needs.base_color_textures;
    const float most = most_survival(scatterings);
    kept_.resize(lambert_count);
    size_t count = 0;
    for (uint32_t place = 0; place < lambert_count; ++place) {
        if (textured) ask_texels(shared, place);
        const uint32_t i = order[place];
        const LightPath& path = batch.paths[i];
        const PhotonTracingScene::Shading& shading = shared.shading[batch.hits[i].instance];
        KeptPath kept{.place = place,
                      .stores = arrivals && (caustic || path.rough) && shading.stores,
                      .hope = 0,
                      .reflectance = Rgb(0)};
        bool may_survive = false;
        if (scatters) {
            kept.reflectance = shading.surface.varies()
                                   ? shading.surface.reflectance(batch.hits[i], lookups_[place % kLookups])
                                   : shading.surface.base_color;
            kept.hope = max_component(path.power_w * kept.reflectance) * path.reference_inverse;
            // Where the mesh is smooth its normals may raise the hope.
            may_survive = (arrivals && shading.surface.normals) || record == PhotonRecord::Everything ||
                          !(choice.x[place] >= std::min(kept.hope, most));
        }
        kept_[count] = kept;  // without a branch, which nobody could foresee
        count += static_cast<size_t>(kept.stores | may_survive);
    }
    kept_.resize(count);
}

void PhotonWavefront::go_on_from_lambert(uint32_t path, const Rgb& power_w, const LambertGroup& group, size_t lane) {
    LightPath& next = batch.next_path();
    next.power_w = power_w;
    next.reference_inverse = batch.paths[path].reference_inverse;
    next.rough = true;
    next.all_delta = false;
    next.media = batch.paths[path].media;
    batch.next_ray() = {group.start.get(lane), group.next_direction.get(lane), kInfinity};
    batch.keep_next(batch.keys[path]);
}

bool PhotonWavefront::part_hit(const PhotonTracingScene& shared, uint32_t path, PartedHit& parted) const {
    const Scene& scene = shared.scene;
    parted.wi_world = -batch.rays[path].direction;
    parted.point = make_shading_point(scene, batch.hits[path], batch.rays[path].direction);
    const ShadingPoint& point = parted.point;
    if (scene.materials[point.material].unlit) return false;
    parted.outside_ior = batch.paths[path].media.outside_ior(scene, point.material, !point.front_side);
    const Bsdf bsdf = make_bsdf(scene, point, parted.outside_ior);
    parted.specular = bsdf.specular_part(shared.tracing.glossy_threshold);
    parted.rough = bsdf.rough_part(shared.tracing.glossy_threshold);
    return true;
}

PartedScattering PhotonWavefront::scatter_parted(const PartedHit& parted, size_t place, bool by_rough, Counts& counts) {
    const LightPath& path = batch.paths[order[place]];
    const ShadingPoint& point = parted.point;
    // Each part is tried; one number then chooses between them and absorption, by what they leave of the power.
    const vec2 u(direction.x[place], direction.y[place]);
    const float u_lobe = choice.y[place];
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
    const float roulette = choice.x[place];
    if (roulette >= hope * share) return {};
    const bool is_rough = roulette >= specular_hope * share;
    const PhotonScattering& chosen = is_rough ? rough : specular;

    LightPath& next = batch.next_path();
    next = path;
    next.power_w = (is_rough ? rough_w : specular_w) / ((is_rough ? rough_hope : specular_hope) * share);
    if (!is_sound(next.power_w, counts)) return {};
    next.rough = path.rough || is_rough;
    next.all_delta = path.all_delta && chosen.delta;
    if (chosen.refraction) next.media.cross(point.material, point.front_side);
    batch.next_ray() = {ray_origin(point, chosen.direction), chosen.direction, kInfinity};
    return {.goes_on = true, .is_rough = is_rough};
}

}  // namespace photond
