// The helper's tasks on two images: figures that can be worked out by hand, what is undefined said so, pictures that
// show the numbers, and every fault put to the field that has it.

#include "server/worker/helper_errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "renderer/core/rng.h"
#include "renderer/error/color_map.h"
#include "renderer/error/error_meter.h"
#include "renderer/error/estimate.h"
#include "renderer/film/exr_file.h"
#include "renderer/film/film_file.h"
#include "renderer/scene/texture_decode.h"
#include "server/worker/helper_tasks.h"
#include "tests/support/random_film.h"
#include "tests/support/temporary_folder.h"

namespace photond::helper_errors_test {
namespace {

using nlohmann::json;

constexpr Size2 kPictureSize{13, 9};

class HelperErrors : public testing::Test {
    const TemporaryFolder folder_;

protected:
    std::string file(const std::string& name) const { return folder_.path() / name; }
    std::string bytes_of(const std::string& name) const {
        std::ifstream in(file(name), std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    static json ask(json message) {
        message["request"] = 1;
        SceneCache scenes(0);
        return run_helper_task(message, {uint64_t{1} << 30, 2}, scenes);
    }
    static json result(const json& message) {
        const json reply = ask(message);
        EXPECT_TRUE(reply["failure"].is_null()) << reply;
        return reply["result"];
    }
    /// CODE POINTER: detail
    static std::string failure(const json& message) {
        const json reply = ask(message);
        EXPECT_TRUE(reply["result"].is_null()) << reply;
        const json& failure = reply["failure"];
        if (!failure.is_object() || failure["errors"].empty()) return failure.dump();
        return failure["code"].get<std::string>() + " " + failure["errors"][0]["pointer"].get<std::string>() + ": " +
               failure["errors"][0]["detail"].get<std::string>();
    }

    /// An EXR of these layers, as a source.
    json image(const std::string& name, Size2 size, const std::map<std::string, std::vector<float>>& layers) const {
        std::vector<ImageLayer> all;
        for (const auto& [layer, pixels] : layers) all.push_back({channel_names(layer), pixels});
        write_exr(size, all, Precision::Float, {}, file(name));
        return {{"image", file(name)}};
    }
    json beauty(const std::string& name, Size2 size, const std::vector<float>& pixels) const {
        return image(name, size, {{"beauty", pixels}});
    }
    json film(const std::string& name, const Film& film) const {
        FilmFile::save(film, {}, "", file(name));
        return {{"film", file(name)}};
    }
    json measure(const json& image, const json& reference, const json& metrics) const {
        return result({{"type", "measure"}, {"image", image}, {"reference", reference}, {"metrics", metrics}});
    }
    std::vector<uint8_t> png(const std::string& name) const {
        const std::string bytes = bytes_of(name);
        const Texture texture =
            decode_texture(std::span(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()), {});
        std::vector<uint8_t> rgb;
        for (const u8vec4& texel : texture.texels) rgb.insert(rgb.end(), {texel.x, texel.y, texel.z});
        return rgb;
    }
};

std::vector<float> random_pixels(Size2 size, uint64_t seed) {
    std::vector<float> pixels(3 * size.pixels());
    for (size_t i = 0; i < pixels.size(); ++i) pixels[i] = RandomStream(seed, RandomDomain::Test, 0, i).next();
    return pixels;
}

json every_metric() {
    json names = json::array();
    for (const MetricInfo& info : kMetrics)
        if (info.needs_reference) names.push_back(std::string(info.name));
    return names;
}

bool mentions(const json& notes, const std::string& text) {
    for (const json& note : notes)
        if (note.get<std::string>().find(text) != std::string::npos) return true;
    return false;
}

TEST_F(HelperErrors, FiguresOfOneChangedValueAreThoseWorkedOutByHand) {
    std::vector<float> pixels(12, 2.0f);
    const json reference = beauty("r.exr", {2, 2}, pixels);
    pixels[0] = 3;
    const json found = measure(beauty("x.exr", {2, 2}, pixels), reference, every_metric());
    const json& values = found["metrics"];
    const double relative = 1 / (4 + 0.04);
    EXPECT_NEAR(values["relative_mse"].get<double>(), relative / 12, 1e-7);
    EXPECT_NEAR(values["rmse"].get<double>(), std::sqrt(1.0 / 12), 1e-7);
    EXPECT_NEAR(values["mae"].get<double>(), 1.0 / 12, 1e-7);
    EXPECT_NEAR(values["smape"].get<double>(), 2 / 5.2 / 12, 1e-7);
    EXPECT_EQ(values["rmse_8bit"], 0.0);  // both are white
    EXPECT_EQ(values["bias"], json({0.25, 0.0, 0.0}));
    EXPECT_EQ(values["relative_bias"], json({0.125, 0.0, 0.0}));
    EXPECT_EQ(values["firefly_count"], 0u);
    EXPECT_EQ(values["percentiles"]["50"], 0.0);
    for (const char* share : {"90", "99", "100"})
        EXPECT_NEAR(values["percentiles"][share].get<double>(), std::sqrt(relative / 3), 1e-7) << share;
    EXPECT_EQ(values["flip_ldr"], 0.0);
    EXPECT_GT(values["flip_hdr"].get<double>(), 0.0);
    EXPECT_EQ(values.size(), every_metric().size());
    EXPECT_TRUE(found["reference_error"].is_null());
    EXPECT_TRUE(mentions(found["notes"], "noise is not known for beauty")) << found["notes"];
}

TEST_F(HelperErrors, AnyMetricOfAnyLayerIsTheMeters) {
    const std::vector<float> x = random_pixels(kPictureSize, 1), r = random_pixels(kPictureSize, 2);
    const std::vector<float> x_indirect = random_pixels(kPictureSize, 3), r_indirect = random_pixels(kPictureSize, 4);
    json names = every_metric();
    for (const json& name : every_metric()) names.push_back("indirect:" + name.get<std::string>());
    const json values =
        measure(image("x.exr", kPictureSize, {{"beauty", x}, {"indirect", x_indirect}}),
                image("r.exr", kPictureSize, {{"beauty", r}, {"indirect", r_indirect}}), names)["metrics"];
    const ErrorMeter beauty_meter(kPictureSize, r), indirect_meter(kPictureSize, r_indirect);
    for (const MetricInfo& info : kMetrics) {
        if (!info.needs_reference) continue;
        for (const bool indirect : {false, true}) {
            const std::string name = (indirect ? "indirect:" : "") + std::string(info.name);
            const std::vector<double> expected =
                (indirect ? indirect_meter : beauty_meter).measure(info.metric, indirect ? x_indirect : x);
            const json& value = values[name];
            ASSERT_EQ(expected.size(), info.values);
            for (size_t i = 0; i < expected.size(); ++i)
                EXPECT_EQ(info.metric == Metric::Percentiles ? value[std::string(kPercentileNames[i])]
                          : value.is_array()                 ? value[i]
                                                             : value,
                          expected[i])
                    << name;
        }
    }
    const json cheap = result({{"type", "measure"},
                               {"image", {{"image", file("x.exr")}}},
                               {"reference", {{"image", file("r.exr")}}}})["metrics"];
    EXPECT_EQ(cheap["rmse"], values["rmse"]);
    EXPECT_FALSE(cheap.contains("flip_hdr"));
}

TEST_F(HelperErrors, WhatHasNoValueIsNullAndSaidWhy) {
    const json black = beauty("r.exr", {2, 1}, std::vector<float>(6, 0.0f));
    const json white = beauty("x.exr", {2, 1}, std::vector<float>(6, 1.0f));
    const json found = measure(white, black, {"relative_mse", "rmse", "percentiles", "estimated_relative_mse"});
    EXPECT_TRUE(found["metrics"]["relative_mse"].is_null());
    EXPECT_TRUE(found["metrics"]["percentiles"].is_null());
    EXPECT_TRUE(found["metrics"]["estimated_relative_mse"].is_null());
    EXPECT_EQ(found["metrics"]["rmse"], 1.0);
    EXPECT_TRUE(mentions(found["notes"], "relative_mse: the mean of the reference is 0")) << found["notes"];
    EXPECT_TRUE(mentions(found["notes"], "percentiles: ")) << found["notes"];
    EXPECT_TRUE(mentions(found["notes"], "estimated_relative_mse: the image's noise")) << found["notes"];

    const json no_green = beauty("g.exr", {2, 1}, {1, 0, 1, 1, 0, 1});
    const json by_channel = measure(white, no_green, {"relative_bias"});
    EXPECT_EQ(by_channel["metrics"]["relative_bias"], json({0.0, nullptr, 0.0}));
    EXPECT_TRUE(mentions(by_channel["notes"], "0 in channel G")) << by_channel["notes"];
}

TEST_F(HelperErrors, ValuesThatAreNotFiniteAreLeftOutAndCounted) {
    std::vector<float> x(12, 1.0f), r(12, 1.0f);
    x[0] = std::nanf(""), x[5] = INFINITY, r[7] = -INFINITY, x[11] = 2;
    const json found = measure(beauty("x.exr", {2, 2}, x), beauty("r.exr", {2, 2}, r), {"rmse"});
    EXPECT_NEAR(found["metrics"]["rmse"].get<double>(), std::sqrt(1.0 / 9), 1e-7);
    EXPECT_TRUE(mentions(found["notes"], "2 values of the image and 1 of the reference")) << found["notes"];
}

TEST_F(HelperErrors, TheNoiseOfAFilmIsStatedAndWarnedOf) {
    const Size2 size{16, 16};
    Film noisy(size, LayerSet());
    for (uint32_t pass = 0; pass < 8; ++pass) {
        PassImage image(size, LayerSet());
        for (size_t i = 0; i < size.pixels(); ++i)
            image.of<Layer::Direct>()[i] = Rgb(1 + RandomStream(1, RandomDomain::Test, pass, i).next());
        noisy.add_pass(image);
    }
    const json reference = film("r.film", noisy);
    std::vector<float> standard_error = noisy.pass_variance_beauty();
    for (float& value : standard_error) value = static_cast<float>(std::sqrt(double{value} / 8.0));
    const std::vector<float> r = noisy.resolve_beauty();
    const ErrorMeter meter(size, r);
    const double expected = meter.measure(Metric::Rmse, with_own_noise(r, standard_error, 1)).front();

    const std::vector<float> other = random_pixels(size, 9);
    const json far = measure(image("x.exr", size, {{"beauty", other}, {"emitted", other}}), reference,
                             {"rmse", "emitted:rmse", "firefly_count"});
    EXPECT_NEAR(far["reference_error"]["rmse"].get<double>(), expected, 1e-9);
    EXPECT_TRUE(far["reference_error"]["emitted:rmse"].is_null());
    EXPECT_TRUE(far["reference_error"]["firefly_count"].is_null());
    EXPECT_FALSE(mentions(far["notes"], "rmse is "));
    std::vector<float> near = r;
    for (float& value : near) value += static_cast<float>(expected);
    EXPECT_TRUE(mentions(measure(beauty("x.exr", size, near), reference, {"rmse"})["notes"], "rmse is "));

    const json own = measure(reference, reference, {"rmse", "estimated_relative_mse"})["metrics"];
    EXPECT_EQ(own["rmse"], 0.0);
    EXPECT_GT(own["estimated_relative_mse"].get<double>(), 0.0);
}

TEST_F(HelperErrors, ARadianceImageIsAReference) {
    std::ofstream(file("r.hdr"), std::ios::binary)
        << "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n"
        << "\x80\x40\x20\x81"
        << "\x80\x80\x80\x82";  // 1, 0.5, 0.25; 2, 2, 2 (mantissa / 256 x 2^(exponent - 128))
    const json found =
        measure(beauty("x.exr", {2, 1}, {1, 0.5f, 0.25f, 2, 2, 3}), {{"image", file("r.hdr")}}, {"rmse", "bias"});
    EXPECT_NEAR(found["metrics"]["rmse"].get<double>(), std::sqrt(1.0 / 6), 1e-7);
    EXPECT_EQ(found["metrics"]["bias"], json({0.0, 0.0, 0.5}));
}

TEST_F(HelperErrors, FaultsNameTheirFieldAndWhatThereIs) {
    const json x = beauty("x.exr", kPictureSize, random_pixels(kPictureSize, 1));
    const json r = image("r.exr", kPictureSize,
                         {{"beauty", random_pixels(kPictureSize, 2)}, {"indirect", random_pixels(kPictureSize, 2)}});
    const json small = beauty("s.exr", {2, 2}, std::vector<float>(12, 1.0f));
    std::ofstream(file("bad.exr")) << "no image";
    const auto said = [&](const json& image, const json& reference, const json& metrics) {
        return failure({{"type", "measure"}, {"image", image}, {"reference", reference}, {"metrics", metrics}});
    };
    const json bad{{"image", file("bad.exr")}}, none{{"film", file("none.film")}};
    EXPECT_EQ(said(small, r, {"rmse"}), "conflict /image: the image has 2 x 2 pixels, the reference 13 x 9");
    EXPECT_EQ(said(x, r, {"rmse", "indirect:rmse"}),
              "unknown_name /metrics/1: the image has no layer \"indirect\"; it has beauty");
    EXPECT_EQ(said(r, r, {"caustic:rmse"}),
              "unknown_name /metrics/0: the image has no layer \"caustic\"; it has beauty, indirect");
    EXPECT_EQ(said(r, x, {"indirect:rmse"}),
              "unknown_name /metrics/0: the reference has no layer \"indirect\"; it has beauty");
    EXPECT_EQ(said(x, r, {"rmsee"}), "unknown_name /metrics/0: there is no metric \"rmsee\"; did you mean \"rmse\"?");
    EXPECT_TRUE(said(x, r, {1}).starts_with("wrong_type /metrics/0: ")) << said(x, r, {1});
    EXPECT_TRUE(said(x, bad, {"rmse"}).starts_with("bad_image /reference: ")) << said(x, bad, {"rmse"});
    EXPECT_TRUE(said(none, r, {"rmse"}).starts_with("result_lost /image: ")) << said(none, r, {"rmse"});
    EXPECT_TRUE(said(x, nullptr, {"rmse"}).starts_with("missing_field /reference: "));
    const json out = file("out");
    for (const char* type : {"encode_flip", "encode_error_map"}) {
        const json wrong{{"type", type},   {"image", x},        {"reference", r},
                         {"range", "ldr"}, {"layer", "direct"}, {"out", out}};
        EXPECT_EQ(failure(wrong), "unknown_name /layer: the image has no layer \"direct\"; it has beauty");
    }
    EXPECT_TRUE(failure({{"type", "encode_flip"}, {"image", x}, {"reference", r}, {"range", "sdr"}, {"out", out}})
                    .starts_with("unknown_name /range: "));
    EXPECT_FALSE(std::filesystem::exists(file("out")));
    SceneCache scenes(0);
    const json reply =
        run_helper_task({{"type", "measure"}, {"image", x}, {"reference", r}, {"metrics", {"rmse"}}},
                        {3 * kPictureSize.pixels() * sizeof(float), 1}, scenes);  // the image fits, not both
    EXPECT_EQ(reply["failure"]["code"], "out_of_memory") << reply;
}

TEST_F(HelperErrors, TheDifferenceIsThatOfEveryLayerOfBothBitForBit) {
    const Film a = test::film_of(kPictureSize, LayerSet(), {0, 1});
    const std::vector<float> r = random_pixels(kPictureSize, 1), r_direct = random_pixels(kPictureSize, 2);
    json message{{"type", "encode_difference"},
                 {"image", film("a.film", a)},
                 {"reference", image("r.exr", kPictureSize, {{"beauty", r}, {"direct", r_direct}, {"caustic", r}})},
                 {"out", file("d.exr")}};
    EXPECT_EQ(result(message), json::object());
    const LayeredImage difference = read_exr(file("d.exr"));
    EXPECT_EQ(difference.size, kPictureSize);
    ASSERT_EQ(difference.layers.size(), 2u);
    const std::vector<float> x = a.resolve_beauty(), x_direct = a.resolve(Layer::Direct);
    for (size_t i = 0; i < r.size(); ++i) {
        EXPECT_EQ(difference.layers.at("beauty")[i], x[i] - r[i]);
        EXPECT_EQ(difference.layers.at("direct")[i], x_direct[i] - r_direct[i]);
    }
    message["out"] = file("e.exr");
    result(message);
    EXPECT_EQ(bytes_of("d.exr"), bytes_of("e.exr"));
}

TEST_F(HelperErrors, FlipMapsShowWhereImagesDiffer) {
    const Size2 size{40, 30};
    std::vector<float> x(3 * size.pixels(), 0.3f);
    const json reference = beauty("r.exr", size, x);
    json message{{"type", "encode_flip"}, {"image", reference}, {"reference", reference},
                 {"layer", "beauty"},     {"range", "ldr"},     {"out", file("flip.png")}};
    const std::vector<uint8_t> darkest = color_mapped(std::vector<float>(size.pixels(), 0.0f));
    EXPECT_EQ(result(message)["mean"], 0.0);
    EXPECT_EQ(png("flip.png"), darkest);
    for (size_t i = 0; i < 15; ++i) x[3 * (15 * size.width + 20) + i] = 1;
    message["image"] = beauty("x.exr", size, x);
    for (const FlipRange range : {FlipRange::Ldr, FlipRange::Hdr}) {
        message["range"] = range == FlipRange::Ldr ? "ldr" : "hdr";
        const FlipMap map = Flip(size, std::vector<float>(3 * size.pixels(), 0.3f), range).measure(x);
        EXPECT_EQ(result(message)["mean"], map.mean);
        EXPECT_EQ(png("flip.png"), color_mapped(map.values));
        EXPECT_NE(png("flip.png"), darkest);
    }
}

TEST_F(HelperErrors, TheErrorMapsScaleIsFixed) {
    const Size2 size{6, 1};
    const std::vector<float> r(18, 1.0f);
    const double denominator = std::sqrt(1.01);  // of each channel, the reference being 1 everywhere
    const double errors[] = {0, 1e-4, 1e-1, 1, 100};
    std::vector<float> x = r;
    for (size_t pixel = 0; pixel < 5; ++pixel)
        for (size_t k = 0; k < 3; ++k) x[3 * pixel + k] = static_cast<float>(1 + errors[pixel] * denominator);
    x[16] = std::nanf("");
    const json reference = beauty("r.exr", size, r);
    result({{"type", "encode_error_map"},
            {"image", beauty("x.exr", size, x)},
            {"reference", reference},
            {"layer", "beauty"},
            {"out", file("m.png")}});
    const std::vector<float> shown{0, 0, 0.5f, 0.75f, 1, std::nanf("")};  // 1e-3 to 10: four decades
    EXPECT_EQ(png("m.png"), color_mapped(shown));
    // Nothing is known against a black reference.
    result({{"type", "encode_error_map"},
            {"image", reference},
            {"reference", beauty("b.exr", size, std::vector<float>(18, 0.0f))},
            {"out", file("m.png")}});
    EXPECT_EQ(png("m.png"), color_mapped(std::vector<float>(6, std::nanf(""))));
}

}  // namespace
}  // namespace photond::helper_errors_test
