// The filter of quick pictures: noise goes, and what surfaces draw stays.

#include "renderer/gbuffer/edge_avoiding_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/threads.h"

namespace photond::edge_avoiding_filter_test {
namespace {

constexpr Size2 kSize{96, 64};

/// A floor in the lower half that goes away from the eye, a wall in the upper, and a column of nothing at the right.
struct Room {
    std::vector<Rgb> albedo, light;
    std::vector<vec3> normal, position;
    std::vector<float> depth;

    Room()
        : albedo(kSize.pixels(), Rgb(0.5f)),
          light(kSize.pixels(), Rgb(0.25f)),
          normal(kSize.pixels()),
          position(kSize.pixels()),
          depth(kSize.pixels()) {
        for (uint32_t y = 0; y < kSize.height; ++y) {
            for (uint32_t x = 0; x < kSize.width - 1; ++x) {
                const size_t i = at(x, y);
                const float across = float(x) / float(kSize.width), down = float(y) / float(kSize.height);
                normal[i] = is_wall(y) ? vec3(0, 0, 1) : vec3(0, 1, 0);
                position[i] = is_wall(y) ? vec3(across, 0.5f - down, -2) : vec3(across, 0, -2 + 4 * (down - 0.5f));
                depth[i] = 3 - (is_wall(y) ? 0 : 2 * (down - 0.5f));
            }
        }
    }
    static size_t at(uint32_t x, uint32_t y) { return size_t{y} * kSize.width + x; }
    static bool is_wall(uint32_t y) { return y < kSize.height / 2; }
    std::vector<Rgb> filtered() const {
        std::vector<Rgb> result = light;
        filter_avoiding_edges(result, kSize, {albedo, normal, position, depth});
        return result;
    }
    /// As few paths give it: black for most pixels, bright for few, the mean as before.
    void make_noisy() {
        std::mt19937 numbers(7);
        std::uniform_real_distribution<float> uniform(0, 1);
        for (Rgb& one : light) one *= uniform(numbers) < 0.25f ? 4.0f : 0.0f;
    }
};

/// Mean of the green of a part of the wall or of the floor, and its standard deviation.
struct Spread {
    double mean = 0, deviation = 0;
    Spread(const std::vector<Rgb>& light, bool wall) {
        double sum = 0, squares = 0, count = 0;
        for (uint32_t y = 0; y < kSize.height; ++y) {
            if (Room::is_wall(y) != wall) continue;
            for (uint32_t x = 0; x < kSize.width - 1; ++x, ++count) {
                const double value = double{light[Room::at(x, y)].y};
                sum += value, squares += value * value;
            }
        }
        mean = sum / count, deviation = std::sqrt(std::max(0.0, squares / count - mean * mean));
    }
};

TEST(EdgeAvoidingFilter, EvenLightStaysWhateverTheSurfacesLookLike) {
    Room room;
    for (uint32_t y = 0; y < kSize.height; ++y)
        for (uint32_t x = 0; x < kSize.width - 1; ++x) {
            const size_t i = Room::at(x, y);
            room.albedo[i] = (x / 3 + y / 3) % 2 ? Rgb(0.8f, 0.1f, 0.3f) : Rgb(0.05f, 0.4f, 0.6f);
            room.light[i] = 0.7f * room.albedo[i];
        }
    const std::vector<Rgb> filtered = room.filtered();
    for (size_t i = 0; i < filtered.size(); ++i)
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(filtered[i][c], room.light[i][c], 1e-5f) << "pixel " << i;
}

TEST(EdgeAvoidingFilter, NoiseGoes) {
    Room room;
    room.make_noisy();
    const std::vector<Rgb> filtered = room.filtered();
    for (const bool wall : {false, true}) {
        const Spread before(room.light, wall), after(filtered, wall);
        EXPECT_GT(before.deviation, 1.5 * before.mean) << "as noisy as the test means it to be";
        EXPECT_LT(after.deviation, 0.1 * before.deviation) << (wall ? "wall" : "floor");
        // A quarter of pixels at 4 and the rest at 0 are of standard deviation 1.73: two of them above the mean
        // are 4.5, so that only chance makes some of them dots.
        // Bright pixels, being few, look different to more neighbours than dark ones do: some energy goes there too.
        EXPECT_LT(after.mean, 1.02 * before.mean) << (wall ? "wall" : "floor");
        EXPECT_GT(after.mean, 0.75 * before.mean) << (wall ? "wall" : "floor");
    }
}

TEST(EdgeAvoidingFilter, LightStaysOnItsSurface) {
    Room room;
    for (uint32_t y = 0; y < kSize.height; ++y)
        for (uint32_t x = 0; x < kSize.width; ++x)
            room.light[Room::at(x, y)] = Rgb(x == kSize.width - 1 ? 9.0f : Room::is_wall(y) ? 1.0f : 0.1f);
    const std::vector<Rgb> filtered = room.filtered();
    for (size_t i = 0; i < filtered.size(); ++i)
        ASSERT_NEAR(filtered[i].y, room.light[i].y, 1e-4f) << "pixel " << i % kSize.width << ' ' << i / kSize.width;
}

TEST(EdgeAvoidingFilter, ADotGoes) {
    Room room;
    room.light[Room::at(40, 20)] = Rgb(500);
    const std::vector<Rgb> filtered = room.filtered();
    EXPECT_LT(filtered[Room::at(40, 20)].y, 80) << "one of 49 pixels: the mean and two standard deviations are 153";
    EXPECT_LT(filtered[Room::at(46, 20)].y, 40);
    EXPECT_NEAR(filtered[Room::at(40, 50)].y, 0.25f, 1e-4f) << "the floor has none of it";
}

TEST(EdgeAvoidingFilter, APixelThatNothingIsLikeTakesTheLightOfThoseAboutIt) {
    Room room;
    room.make_noisy();
    const size_t alone = Room::at(30, 10);
    room.normal[alone] = glm::normalize(vec3(1, 1, 1));  // the mean over an edge
    for (const float light : {0.0f, 40.0f}) {
        room.light[alone] = Rgb(light);
        const std::vector<Rgb> filtered = room.filtered();
        EXPECT_GT(filtered[alone].y, 0.1f) << light;
        EXPECT_LT(filtered[alone].y, 0.3f) << light;
    }
}

TEST(EdgeAvoidingFilter, IsTheSameForAnyNumberOfThreads) {
    Room room;
    room.make_noisy();
    const std::vector<Rgb> once = test::on_threads(1, [&] { return room.filtered(); });
    const std::vector<Rgb> again = test::on_threads(3, [&] { return room.filtered(); });
    EXPECT_EQ(once, again);
}

}  // namespace
}  // namespace photond::edge_avoiding_filter_test
