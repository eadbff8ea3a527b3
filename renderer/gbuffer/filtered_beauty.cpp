#include "renderer/gbuffer/filtered_beauty.h"

#include <algorithm>
#include <cassert>

#include "renderer/core/copy_elements.h"
#include "renderer/gbuffer/edge_avoiding_filter.h"

namespace photond {

namespace {

constexpr Layer kGuides[] = {Layer::Albedo, Layer::Normal, Layer::Position, Layer::Depth};

template <class Value>
std::vector<Value> pixels_of(const Film& film, Layer layer) {
    const std::vector<float> numbers = film.resolve(layer);
    std::vector<Value> pixels(film.size().pixels());
    assert(numbers.size() * sizeof(float) == pixels.size() * sizeof(Value) && "a layer of as many channels");
    copy_elements(numbers.data(), std::span(pixels));
    return pixels;
}

}  // namespace

std::vector<std::string> guide_layers() {
    std::vector<std::string> names;
    for (const Layer layer : kGuides) names.emplace_back(layer_info(layer).name);
    return names;
}

std::vector<float> filtered_beauty(const Film& film) {
    assert(std::ranges::all_of(kGuides, [&](Layer layer) { return film.layers().has(layer); }) && "guide_layers()");
    std::vector<Rgb> light = pixels_of<Rgb>(film, Layer::Direct);
    const std::vector<Rgb> indirect = pixels_of<Rgb>(film, Layer::Indirect);
    for (size_t i = 0; i < light.size(); ++i) light[i] += indirect[i];
    const std::vector<Rgb> albedo = pixels_of<Rgb>(film, Layer::Albedo);
    const std::vector<vec3> normal = pixels_of<vec3>(film, Layer::Normal),
                            position = pixels_of<vec3>(film, Layer::Position);
    const std::vector<float> depth = film.resolve(Layer::Depth);
    filter_avoiding_edges(light, film.size(), {albedo, normal, position, depth});
    std::vector<float> beauty = film.resolve(Layer::Emitted);
    for (size_t i = 0; i < beauty.size(); ++i) beauty[i] += light[i / 3][int(i % 3)];
    return beauty;
}

}  // namespace photond
