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
        image.of<Layer::Emitted>()[i] = rgb(), image.of<Layer::Direct>()[i] = rgb(),
        image.of<Layer::Indirect>()[i] = rgb();
        if (layers.has(Layer::Caustic)) image.of<Layer::Caustic>()[i] = rgb();
        if (layers.has(Layer::Clamped)) image.of<Layer::Clamped>()[i] = rgb();
        if (layers.has(Layer::Voxels)) image.of<Layer::Voxels>()[i] = rgb();
        if (layers.has(Layer::Vpls)) image.of<Layer::Vpls>()[i] = std::abs(value());
        if (layers.has(Layer::SplitNormal)) image.of<Layer::SplitNormal>()[i] = rgb();
        if (layers.has(Layer::SplitIndirect)) image.of<Layer::SplitIndirect>()[i] = rgb();
        if (image.hit.empty()) continue;
        image.hit[i] = random.next() < 0.7f;
        if (!image.hit[i]) continue;
        if (layers.has(Layer::Albedo)) image.of<Layer::Albedo>()[i] = rgb();
        if (layers.has(Layer::GeometricNormal)) image.of<Layer::GeometricNormal>()[i] = rgb();
        if (layers.has(Layer::Normal)) image.of<Layer::Normal>()[i] = rgb();
        if (layers.has(Layer::Position)) image.of<Layer::Position>()[i] = rgb();
        if (layers.has(Layer::Depth)) image.of<Layer::Depth>()[i] = value();
        if (layers.has(Layer::PhotonCount)) image.of<Layer::PhotonCount>()[i] = std::abs(value());
        if (layers.has(Layer::Overlap)) image.of<Layer::Overlap>()[i] = std::abs(value());
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
