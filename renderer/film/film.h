#pragma once
// The film: what passes add up to. Sums are 128-bit fixed point (multiples of 2^-64), so that addition is exactly
// associative: any order of passes and any cut into ranges gives the same bits.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "renderer/core/memory_budget.h"
#include "renderer/core/rgb.h"
#include "renderer/core/stats.h"
#include "renderer/film/fixed_sums.h"
#include "renderer/film/layers.h"
#include "renderer/film/pass_means.h"
#include "renderer/film/pass_ranges.h"

namespace photond {

/// What one pass contributes: for each pixel the mean of its samples in this pass. Row 0 is the top. Layers not asked
/// for are empty. Those whose mean is over hits (LayerMean::Hits) are read where hit[i] != 0 only.
class PassImage {
public:
    PassImage() = default;
    PassImage(Size2 image_size, LayerSet layer_set);
    static uint64_t bytes_for(Size2 size, LayerSet layers);

    /// A layer's pixels: a std::vector<Rgb>, or a std::vector<float> where it has one channel. What they mean, and in
    /// which unit, says its row in kLayers.
    template <Layer layer>
    auto& of() {
        return of<layer>(*this);
    }
    template <Layer layer>
    const auto& of() const {
        return of<layer>(*this);
    }
    /// Calls function(info, pixels) for each layer that is there.
    template <class Function>
    void each_layer(const Function& function) {
        each_layer_of(*this, function);
    }
    template <class Function>
    void each_layer(const Function& function) const {
        each_layer_of(*this, function);
    }
    /// Black, and met by nothing, in all layers: pixels of one row, or of several from one end to the other.
    void clear(size_t first_pixel, size_t pixels);

    Size2 size;
    LayerSet layers;
    std::vector<uint8_t> hit;  // 1 where the sample met a surface; only kept when an auxiliary layer is asked for

private:
    template <Layer layer, class Image>
    static auto& of(Image& image) {
        if constexpr (layer_info(layer).channel_count() == 1)
            return image.values_[static_cast<size_t>(layer)];
        else
            return image.colors_[static_cast<size_t>(layer)];
    }
    template <class Image, class Function>
    static void each_layer_of(Image& image, const Function& function) {
        for (const LayerInfo& info : kLayers) {
            const auto i = static_cast<size_t>(info.layer);
            if (!image.values_[i].empty()) function(info, image.values_[i]);
            if (!image.colors_[i].empty()) function(info, image.colors_[i]);
        }
    }

    // A layer's pixels are in one of the two, by its channels; in neither where the layer is not asked for.
    std::array<std::vector<Rgb>, kLayerCount> colors_;
    std::array<std::vector<float>, kLayerCount> values_;
};

/// Greatest magnitude a pass may contribute to a pixel; larger values are dropped and counted with the infinities.
inline constexpr float kFilmValueLimit = 0x1p29f;

class Film {
public:
    /// `first_pass`: index of the first pass to be added.
    Film(Size2 size, LayerSet layers, uint32_t first_pass = 0);

    /// Adds the pass of index next_pass(), which has the film's size and layers. A pixel that holds a NaN, an infinity
    /// or a value past kFilmValueLimit (any channel, any layer) contributes zero to that pass and is counted, once.
    void add_pass(const PassImage& pass);

    /// Adds all passes of another film of the same size and layers: the same bits as if they had been rendered here.
    /// Throws ErrorCode::Conflict when the size or the layers differ, or a pass is in both; nothing has changed then.
    void merge(const Film& other);

    /// Bytes the pixels of a film of that size and those layers take; for MemoryBudget::require() before it is made.
    static uint64_t bytes_for(Size2 size, LayerSet layers);

    Size2 size() const { return size_; }
    LayerSet layers() const { return layers_; }
    uint32_t passes() const { return passes_; }  // how many
    const PassRanges& pass_ranges() const { return pass_ranges_; }
    uint32_t next_pass() const { return next_pass_; }  // index of the pass that add_pass() takes
    uint64_t nan_count() const { return nan_count_; }
    uint64_t infinity_count() const { return infinity_count_; }  // out of range included
    uint64_t bytes() const { return bytes_for(size_, layers_); }

    /// Mean over the passes of a layer (or the beauty), as size().pixels() * channels floats; 0 before the first pass.
    /// Auxiliary layers: mean over the samples that hit, 0 where none did; for PhotonCount and Overlap a sample that
    /// met a surface and found no photon or splat counts, as 0. StandardError: of the beauty's mean, from the variance
    /// between passes; infinite before the second pass, when nothing is known of it.
    std::vector<float> resolve(Layer layer) const;
    std::vector<float> resolve_beauty() const;
    /// Unbiased variance between passes of one pass's value, per pixel and channel; empty for fewer than two passes.
    std::vector<float> pass_variance_beauty() const;
    std::vector<float> pass_variance(Layer layer) const;  // direct or indirect
    /// What each pass says of the whole image's mean, dropped pixels as the 0 they contribute.
    const PassMeans& pass_means() const { return pass_means_; }

    /// SHA-256 over every layer's pixels as float32 little-endian: beauty, then the layers in the order of kLayers.
    std::string pixel_hash() const;

    bool operator==(const Film&) const = default;  // bit for bit

private:
    FixedSum beauty_sum(size_t index) const;

    friend class FilmFile;  // film_file.h: saves and loads the sums themselves

    Size2 size_;
    LayerSet layers_;
    uint32_t passes_ = 0;
    uint32_t next_pass_ = 0;
    PassRanges pass_ranges_;
    uint64_t nan_count_ = 0;
    uint64_t infinity_count_ = 0;
    PassMeans pass_means_;
    // By channel, three (single-valued layers: one) a pixel; empty where the layer is not kept. The beauty is the sum
    // of its parts.
    std::vector<FixedSum> sums_[kLayerCount];
    std::vector<FixedSquares> squares_beauty_, squares_direct_, squares_indirect_;
    std::vector<uint32_t> hits_;  // samples that hit; only kept with an auxiliary layer
};

}  // namespace photond
