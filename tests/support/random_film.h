#pragma once
// Films of random values, for tests of what a film keeps.

#include <cmath>
#include <vector>

#include "renderer/core/rng.h"
#include "renderer/film/film.h"

namespace photond::test {

/// Values over many magnitudes, negative ones among them, so that float addition in another order would show.
inline PassImage random_pass(Size2 size, LayerSet layers, uint32_t pass) {
    PassImage image(size, layers);
    for (size_t i = 0; i < size.pixels(); ++i) {
        RandomStream random(7, RandomDomain::Test, pass, i);
        const auto value = [&] {
            const float magnitude = std::exp2(60.0f * random.next() - 40.0f);
            return random.next() < 0.1f ? 0.0f : random.next() < 0.2f ? -magnitude : magnitude;
        };
        const auto rgb = [&] { return Rgb(value(), value(), value()); };
        image.emitted[i] = rgb(), image.direct[i] = rgb(), image.indirect[i] = rgb();
        if (layers.has(Layer::Caustic)) image.caustic[i] = rgb();
        if (layers.has(Layer::Clamped)) image.clamped[i] = rgb();
        if (layers.has(Layer::Voxels)) image.voxels[i] = rgb();
        if (layers.has(Layer::Vpls)) image.vpls[i] = std::abs(value());
        if (layers.has(Layer::SplitNormal)) image.split_normal[i] = rgb();
        if (layers.has(Layer::SplitIndirect)) image.split_indirect[i] = rgb();
        if (image.hit.empty()) continue;
        image.hit[i] = random.next() < 0.7f;
        if (!image.hit[i]) continue;
        if (layers.has(Layer::Albedo)) image.albedo[i] = rgb();
        if (layers.has(Layer::Normal)) image.normal[i] = rgb();
        if (layers.has(Layer::Position)) image.position[i] = rgb();
        if (layers.has(Layer::Depth)) image.depth[i] = value();
        if (layers.has(Layer::PhotonCount)) image.photon_count[i] = std::abs(value());
        if (layers.has(Layer::Overlap)) image.overlap[i] = std::abs(value());
    }
    return image;
}

/// Of the passes with those numbers, in that order; the first one has the index `first_pass`.
inline Film film_of(Size2 size, LayerSet layers, const std::vector<uint32_t>& passes, uint32_t first_pass = 0) {
    Film film(size, layers, first_pass);
    for (const uint32_t pass : passes) film.add_pass(random_pass(size, layers, pass));
    return film;
}

/// The part of a longer film: passes `first` to before `end`, each under its own number.
inline Film film_of_range(Size2 size, LayerSet layers, uint32_t first, uint32_t end) {
    Film film(size, layers, first);
    for (uint32_t pass = first; pass < end; ++pass) film.add_pass(random_pass(size, layers, pass));
    return film;
}

}  // namespace photond::test
