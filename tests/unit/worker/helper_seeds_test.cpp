// The helper's tasks on films that differ by their seed: the figures are those of the renderer, layer by layer, and
// every fault is put to the field that has it.

#include "server/worker/helper_seeds.h"

#include <gtest/gtest.h>

#include <array>
#include <fstream>

#include "renderer/core/rng.h"
#include "renderer/error/seed_errors.h"
#include "renderer/error/welch_map.h"
#include "renderer/film/film_file.h"
#include "renderer/scene/texture_decode.h"
#include "tests/support/temporary_folder.h"

namespace photond::helper_seeds_test {
namespace {

using nlohmann::json;

constexpr Size2 kSize{40, 33};
constexpr uint64_t kEnough = uint64_t{1} << 30;

class HelperSeeds : public testing::Test {
    const TemporaryFolder folder_;

protected:
    std::filesystem::path file(const std::string& name) const { return folder_.path() / name; }
    /// Saved; also of what it shows.
    std::vector<float> film(const std::string& name, Size2 size, uint64_t seed) {
        Film film(size, {});
        PassImage pass(size, {});
        RandomStream random(seed, RandomDomain::Test, 0, 0);
        for (size_t i = 0; i < size.pixels(); ++i) {
            const auto rgb = [&] { return Rgb(random.next(), random.next(), random.next()); };
            pass.of<Layer::Direct>()[i] = rgb(), pass.of<Layer::Indirect>()[i] = rgb();
        }
        film.add_pass(pass);
        FilmFile::save(film, {}, "", file(name));
        return film.resolve_beauty();
    }
    MeasureSeedsRequest request(std::vector<std::string> layers) {
        MeasureSeedsRequest request;
        request.layers = std::move(layers);
        for (int i = 0; i < 3; ++i) {
            const std::string name = "film-" + std::to_string(i);
            shown_.push_back(film(name, kSize, 1 + static_cast<uint64_t>(i)));
            request.films.push_back(file(name));
        }
        u_ = film("u", kSize, 11), v_ = film("v", kSize, 12);
        request.reference.first.film = file("u");
        request.reference.second.emplace().film = file("v");
        return request;
    }
    static std::string failure(const MeasureSeedsRequest& asked, uint64_t memory_bytes) {
        try {
            measure_seeds(asked, memory_bytes);
        } catch (const Error& error) {
            return std::string(error_kind(error.code).name) + " " +
                   (error.faults.empty() ? "" : error.faults.front().pointer);
        }
        return "none";
    }

    std::vector<std::vector<float>> shown_;
    std::vector<float> u_, v_;
};

TEST_F(HelperSeeds, FiguresAreTheRenderers) {
    const json layers = measure_seeds(request({"beauty", "direct", "caustic"}), kEnough).layers;
    EXPECT_EQ(layers.size(), 2u) << "no film has caustics of their own";
    const CrossMeter references(kSize, u_, v_);
    const SeedError error = seed_errors(references, shown_).relative_mse.value();
    const json& measured = layers["beauty"]["errors"]["relative_mse"];
    EXPECT_EQ(measured["squared_bias"], error.squared_bias);
    EXPECT_EQ(measured["low"], error.squared_bias_interval.least);
    EXPECT_EQ(measured["high"], error.squared_bias_interval.greatest);
    EXPECT_EQ(measured["variance"], error.variance);
    EXPECT_EQ(measured["variance_low"], error.variance_interval.value().least);
    const WelchMap map = welch_map(references, shown_);
    const json& blocks = layers["beauty"]["map"]["blocks"];
    ASSERT_EQ(blocks.size(), 4u);
    for (size_t i = 0; i < 4; ++i) {
        EXPECT_EQ(blocks[i]["difference"], map.blocks[i].difference);
        EXPECT_EQ(blocks[i]["p"], map.blocks[i].p);
    }
    EXPECT_EQ(layers["beauty"]["map"]["text"], map.text());
    EXPECT_NE(layers["direct"]["errors"], layers["beauty"]["errors"]);
}

TEST_F(HelperSeeds, FaultsAreThoseOfTheField) {
    MeasureSeedsRequest asked = request({"beauty"});
    // Nine images of three floats a pixel, less one byte.
    EXPECT_EQ(failure(asked, 9 * 12 * kSize.pixels() - 1), "out_of_memory ");
    asked.films.resize(1);
    EXPECT_EQ(failure(asked, kEnough), "conflict /films");
    film("other", {8, 8}, 20);
    asked.films.push_back(file("other"));
    EXPECT_EQ(failure(asked, kEnough), "conflict /films");
    asked.reference.second.reset();
    EXPECT_EQ(failure(asked, kEnough), "conflict /reference");
}

TEST_F(HelperSeeds, ThePictureHasAFrameRoundWhatIsFound) {
    const auto block = [](double difference, bool found) { return json{{"difference", difference}, {"found", found}}; };
    EncodeBiasMapRequest asked{{{"image_width", 40},
                                {"image_height", 33},
                                {"block", 32},
                                {"blocks", {block(0, false), block(0.2, true), block(-0.2, false), block(-1, true)}}},
                               file("map.png")};
    encode_bias_map(asked);
    std::ifstream in(file("map.png"), std::ios::binary);
    const std::string png{std::istreambuf_iterator<char>(in), {}};
    const Texture picture = decode_texture(std::span(reinterpret_cast<const uint8_t*>(png.data()), png.size()), {});
    const auto at = [&](size_t x, size_t y) {
        const u8vec4& texel = picture.texels[y * kSize.width + x];
        return std::array<int, 3>{texel.x, texel.y, texel.z};
    };
    const std::array<int, 3> none = at(0, 0), frame = at(32, 0), brighter = at(35, 10), paler = at(0, 32);
    EXPECT_EQ(none[0], none[2]);
    EXPECT_EQ(frame, (std::array<int, 3>{0, 0, 0}));
    EXPECT_EQ(at(39, 31), frame) << "where the block is cut as well";
    EXPECT_GT(brighter[0], brighter[2] + 100);
    EXPECT_GT(paler[2], paler[0]);
    EXPECT_GT(paler[0], 150) << "chance explains it";
    EXPECT_EQ(at(39, 32), frame);
    asked.map.erase("block");
    EXPECT_THROW(encode_bias_map(asked), Error);
}

}  // namespace
}  // namespace photond::helper_seeds_test
