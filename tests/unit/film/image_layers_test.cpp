// Names of channels, and the layers that they make.

#include "renderer/film/image_layers.h"

#include <gtest/gtest.h>

namespace photond::image_layers_test {
namespace {

using Names = std::vector<std::string>;

/// "NAME(channel,channel..)" of each layer.
Names layers_of(const Names& channels) {
    Names shown;
    for (const NamedLayer& layer : layers_of_channels(channels)) {
        std::string text = layer.name + "(";
        for (const size_t channel : layer.channels) text += channels[channel] + ",";
        text.back() = ')';
        shown.push_back(std::move(text));
    }
    return shown;
}

TEST(ImageLayers, ColoursWithoutANameAreTheBeauty) {
    EXPECT_EQ(layers_of({"R", "G", "B"}), Names{"beauty(R,G,B)"});
    EXPECT_EQ(layers_of({"A", "B", "G", "R"}), Names{"beauty(R,G,B)"}) << "in whatever order the file has them";
    EXPECT_EQ(layers_of({"Y"}), Names{"beauty(Y)"});
    EXPECT_EQ(layers_of({"X", "Y", "Z"}), Names{"beauty(Y)"}) << "the luminance of CIE XYZ";
}

TEST(ImageLayers, TheBeautyIsFirst) {
    EXPECT_EQ(layers_of({"direct.R", "direct.G", "direct.B", "B", "G", "R"}),
              (Names{"beauty(R,G,B)", "direct(direct.R,direct.G,direct.B)"}));
}

TEST(ImageLayers, VectorsAndSingleValuesAreLayersToo) {
    EXPECT_EQ(layers_of({"n.X", "n.Y", "n.Z", "depth.Z", "overlap.Y"}),
              (Names{"n(n.X,n.Y,n.Z)", "depth(depth.Z)", "overlap(overlap.Y)"}));
}

TEST(ImageLayers, NamesMayHaveDots) {
    EXPECT_EQ(layers_of({"View.Combined.B", "View.Combined.G", "View.Combined.R", "View.Combined.A"}),
              Names{"View.Combined(View.Combined.R,View.Combined.G,View.Combined.B)"});
}

TEST(ImageLayers, ColoursComeBeforeVectorsAndThoseBeforeSingleValues) {
    EXPECT_EQ(layers_of({"a.X", "a.Y", "a.Z", "a.R", "a.G", "a.B"}), Names{"a(a.R,a.G,a.B)"});
    EXPECT_EQ(layers_of({"a.Y", "a.Z"}), Names{"a(a.Y)"});
    EXPECT_EQ(layers_of({"R", "G", "B", "Y"}), Names{"beauty(R,G,B)"});
}

TEST(ImageLayers, WhatIsNoLayerIsLeftOut) {
    EXPECT_EQ(layers_of({"A", "Z", "id", "a.R", "a.G", "matte.red", "b.", ".R"}), Names{});
    EXPECT_EQ(layers_of({}), Names{});
}

TEST(ImageLayers, NoTwoHaveOneName) {
    EXPECT_EQ(layers_of({"beauty.Y", "R", "G", "B"}), Names{"beauty(R,G,B)"});
    EXPECT_EQ(layers_of({"beauty.Y"}), Names{"beauty(beauty.Y)"});
    EXPECT_EQ(layers_of({".R", ".G", ".B", "Y"}), Names{"beauty(Y)"});
}

}  // namespace
}  // namespace photond::image_layers_test
