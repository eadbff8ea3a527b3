#include "server/worker/reference_image.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <nlohmann/json.hpp>

#include "protocol/error.h"
#include "renderer/film/exr_file.h"
#include "renderer/film/film_file.h"

namespace photond {

using nlohmann::json;

namespace {

/// The standard error of the mean, from the variance between passes.
std::vector<float> standard_error_of(std::vector<float> pass_variance, uint32_t passes, double scale) {
    for (float& value : pass_variance)
        value = static_cast<float>(scale * std::sqrt(double{value} / static_cast<double>(passes)));
    return pass_variance;
}

/// The scale that the job which rendered the film estimated; 1 where it says none.
double scale_in(const std::string& history) {
    const json saved = json::parse(history, nullptr, false);
    if (!saved.is_object() || !saved.contains("standard_error_scale")) return 1;
    const json& scale = saved["standard_error_scale"];
    return scale.is_number() && scale.get<double>() > 0 ? scale.get<double>() : 1;
}

ReferenceImage reference_of_file(const std::filesystem::path& path, uint64_t limit_bytes) {
    LayeredImage image = read_image(path, limit_bytes);
    ReferenceImage reference;
    reference.size = image.size;
    reference.layers["beauty"] = std::move(image.layers["beauty"]);
    for (const LayerInfo& info : kLayers)
        if (const auto layer = image.layers.find(std::string(info.name));
            info.radiance() && layer != image.layers.end())
            reference.layers[layer->first] = std::move(layer->second);
    const auto error = image.layers.find(std::string(layer_info(Layer::StandardError).name));
    if (error != image.layers.end() &&
        std::all_of(error->second.begin(), error->second.end(), [](float e) { return std::isfinite(e) && e >= 0; }))
        reference.standard_error["beauty"] = std::move(error->second);
    return reference;
}

}  // namespace

ReferenceImage reference_of_film(const Film& film, double standard_error_scale) {
    ReferenceImage reference;
    reference.size = film.size();
    reference.passes = film.passes();
    reference.layers["beauty"] = film.resolve_beauty();
    for (const LayerInfo& info : kLayers)
        if (info.radiance() && film.layers().has(info.layer))
            reference.layers[std::string(info.name)] = film.resolve(info.layer);
    if (film.passes() < 2) return reference;
    const auto keep = [&](std::string_view layer, std::vector<float> pass_variance) {
        reference.standard_error[std::string(layer)] =
            standard_error_of(std::move(pass_variance), film.passes(), standard_error_scale);
    };
    keep("beauty", film.pass_variance_beauty());
    for (const Layer layer : {Layer::Direct, Layer::Indirect}) keep(layer_info(layer).name, film.pass_variance(layer));
    return reference;
}

uint64_t ReferenceImage::bytes() const {
    uint64_t values = 0;
    for (const auto* images : {&layers, &standard_error})
        for (const auto& [name, pixels] : *images) values += pixels.size();
    return values * sizeof(float);
}

ReferenceImage mean_of(ReferenceImage one, const ReferenceImage& other) {
    assert(one.size == other.size);
    const auto joined = [](auto& images, const auto& others, const auto& join) {
        std::erase_if(images, [&](const auto& layer) { return !others.contains(layer.first); });
        for (auto& [layer, values] : images) {
            const std::vector<float>& second = others.at(layer);
            for (size_t i = 0; i < values.size(); ++i)
                values[i] = static_cast<float>(join(double{values[i]}, double{second[i]}) / 2);
        }
    };
    joined(one.layers, other.layers, [](double a, double b) { return a + b; });
    joined(one.standard_error, other.standard_error, [](double a, double b) { return std::hypot(a, b); });
    if (one.passes && other.passes)
        *one.passes += *other.passes;
    else
        one.passes.reset();
    return one;
}

LoadedReference load_reference(const ReferenceSource& source, const std::set<std::string>& layers,
                               uint64_t limit_bytes) {
    const auto load = [&](const ImageSource& of, uint64_t limit) {
        ReferenceImage image = load_image(of, limit);
        for (auto* images : {&image.layers, &image.standard_error})
            std::erase_if(*images, [&](const auto& layer) { return !layers.contains(layer.first); });
        return image;
    };
    LoadedReference loaded{load(source.first, limit_bytes), std::nullopt};
    if (!source.second) return loaded;
    loaded.second = load(*source.second, limit_bytes - std::min(limit_bytes, loaded.first.bytes()));
    if (loaded.second->size != loaded.first.size)
        throw Error(ErrorCode::Conflict, "/reference", "the two films of the reference differ in size");
    return loaded;
}

ReferenceImage load_image(const ImageSource& source, uint64_t limit_bytes) {
    if (source.film) {
        const SavedFilm saved = FilmFile::load(*source.film, limit_bytes);
        if (saved.film.passes() == 0) throw Error(ErrorCode::Internal, "the film of the reference has no pass yet");
        return reference_of_film(saved.film, scale_in(saved.history));
    }
    if (source.image) return reference_of_file(*source.image, limit_bytes);
    throw Error(ErrorCode::MissingField, "", "a source must name a film or an image");
}

}  // namespace photond
