// What previews of layers look like, and which layers have one.

#include "server/worker/preview_image.h"

#include <gtest/gtest.h>

#include "renderer/film/film_file.h"
#include "server/worker/helper_tasks.h"
#include "tests/support/temporary_folder.h"

namespace photond::preview_image_test {
namespace {

using Pixels = std::vector<uint8_t>;

/// Two pixels, every layer; two passes alike but for the numbers of virtual lights.
Film film_of_all_layers() {
    Film film({2, 1}, LayerSet::all());
    for (int pass = 0; pass < 2; ++pass) {
        PassImage image({2, 1}, LayerSet::all());
        image.hit = {1, 1};
        image.of<Layer::Clamped>() = {Rgb(0, 1, 0), Rgb(0.25f)};
        image.of<Layer::Voxels>() = {Rgb(1, 0, 0), Rgb(0.25f)};
        image.of<Layer::SplitIndirect>() = {Rgb(0, 0, 1), Rgb(0.25f)};
        image.of<Layer::SplitNormal>() = {Rgb(0.28f, 0.96f, 0), Rgb(-1, 0, 0)};
        image.of<Layer::Vpls>() = {pass == 0 ? 0.0f : 2.0f, 0.0f};
        image.of<Layer::Overlap>() = {200, 600};
        film.add_pass(image);
    }
    return film;
}

Pixels shown(Layer layer, float exposure = 0) {
    return preview_image(film_of_all_layers(), &layer_info(layer), exposure, ToneCurve::Srgb).rgb;
}

TEST(PreviewImage, LightIsToneMapped) {
    // 0.25 in sRGB is 0.53710 of 255.
    EXPECT_EQ(shown(Layer::Clamped), (Pixels{0, 255, 0, 137, 137, 137}));
    EXPECT_EQ(shown(Layer::Voxels), (Pixels{255, 0, 0, 137, 137, 137}));
    EXPECT_EQ(shown(Layer::SplitIndirect), (Pixels{0, 0, 255, 137, 137, 137}));
    EXPECT_EQ(shown(Layer::SplitIndirect, 2), (Pixels{0, 0, 255, 255, 255, 255}));
}

TEST(PreviewImage, NormalsAreColours) {
    EXPECT_EQ(shown(Layer::SplitNormal), (Pixels{163, 250, 128, 0, 128, 128}));
    EXPECT_EQ(shown(Layer::SplitNormal, 5), shown(Layer::SplitNormal));
}

TEST(PreviewImage, VirtualLightsAreWhiteDots) {
    EXPECT_EQ(shown(Layer::Vpls), (Pixels{255, 255, 255, 0, 0, 0}));
    EXPECT_EQ(shown(Layer::Vpls, -2), (Pixels{137, 137, 137, 0, 0, 0})) << "the mean over passes is 1";
}

TEST(PreviewImage, OverlapIsAHeatMap) { EXPECT_EQ(shown(Layer::Overlap), (Pixels{0, 255, 0, 255, 255, 255})); }

TEST(PreviewImage, SmallerOnesAreMeansOfLightNotOfColours) {
    Film film({4, 2}, LayerSet::all());
    PassImage image({4, 2}, LayerSet::all());
    for (size_t i = 0; i < 8; ++i) {
        image.hit[i] = 1;
        image.of<Layer::Direct>()[i] = Rgb(i % 2 == 0 ? 0.0f : 0.5f);
        image.of<Layer::Overlap>()[i] = i % 2 == 0 ? 0.0f : 400.0f;
    }
    film.add_pass(image);
    const PreviewImage beauty = preview_image(film, nullptr, 0, ToneCurve::Srgb, 2);
    EXPECT_EQ(beauty.size, (Size2{2, 1}));
    EXPECT_EQ(beauty.rgb, Pixels(6, 137)) << "0.25 in sRGB; the mean of 0 and of 0.5 in sRGB would be 94";
    EXPECT_EQ(preview_image(film, &layer_info(Layer::Overlap), 0, ToneCurve::Srgb, 2).rgb,
              (Pixels{0, 255, 0, 0, 255, 0}))
        << "200 splats";
    EXPECT_EQ(preview_image(film, nullptr, 0, ToneCurve::Srgb, 16).rgb,
              preview_image(film, nullptr, 0, ToneCurve::Srgb).rgb)
        << "never scaled up";
}

TEST(PreviewImage, ExposureIsOfWhatIsLight) {
    for (const LayerInfo& info : kLayers) {
        const LayerPreview preview = info.preview;
        EXPECT_EQ(has_exposure(preview), preview == LayerPreview::Light || preview == LayerPreview::Dots) << info.name;
        if (info.radiance() || info.mean == LayerMean::Passes) {
            EXPECT_NE(preview, LayerPreview::None) << info.name;
        }
    }
    EXPECT_EQ(layer_info(Layer::Depth).preview, LayerPreview::None);
    EXPECT_FALSE(has_exposure(LayerPreview::HeatMap) || has_exposure(LayerPreview::Directions));
}

TEST(PreviewImage, TheHelperEncodesEachThatThereIs) {
    const TemporaryFolder folder;
    const std::string film = folder.path() / "film", png = folder.path() / "preview.png";
    FilmFile::save(film_of_all_layers(), {"scene", "settings", "cpu"}, "", film);
    for (const LayerInfo& info : kLayers) {
        std::filesystem::remove(png);
        SceneCache scenes(0);
        const nlohmann::json reply = run_helper_task({{"type", "encode_preview"},
                                                      {"request", 1},
                                                      {"film", film},
                                                      {"layer", info.name},
                                                      {"exposure", 0},
                                                      {"curve", "srgb"},
                                                      {"out", png}},
                                                     {UINT64_MAX, 2}, scenes);
        const bool has_one = info.preview != LayerPreview::None;
        EXPECT_EQ(reply["failure"].is_null(), has_one) << info.name << ": " << reply;
        EXPECT_EQ(std::filesystem::exists(png), has_one) << info.name;
        if (!has_one) {
            EXPECT_EQ(reply["failure"]["code"], "unknown_name") << reply;
        }
    }
}

}  // namespace
}  // namespace photond::preview_image_test
