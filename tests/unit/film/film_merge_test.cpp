// Parts of an image that were rendered apart are, joined, bit for bit the image rendered at once, however they were cut
// and in whatever order they come; what does not belong together is refused and leaves the film as it was.

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "protocol/error.h"
#include "renderer/film/film.h"
#include "renderer/methods/photon_mapping/photon_mapping.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/path_render.h"
#include "tests/support/random_film.h"
#include "tests/support/threads.h"

namespace photond::film_merge_test {
namespace {

using test::film_of_range;

constexpr uint32_t kPasses = 16;
constexpr uint32_t kCuts[] = {1, 2, 3, 7, 16};

template <class Action>
std::string conflict(const Action& action) {
    try {
        action();
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::Conflict) << error.what();
        return error.what();
    }
    return "";
}

// --- Which passes

TEST(PassRanges, JoinWhereTheyTouch) {
    PassRanges passes;
    EXPECT_EQ(passes.text(), "none");
    EXPECT_EQ(passes.count(), 0u);
    EXPECT_EQ(passes.end(), 0u);
    for (const uint32_t pass : {4u, 5u, 9u, 3u, 7u}) passes.add(pass);
    EXPECT_EQ(passes.text(), "3-5, 7, 9");
    EXPECT_EQ(passes.count(), 5u);
    EXPECT_EQ(passes.end(), 10u);
    passes.add(PassRanges({{0, 3}, {8, 9}, {20, 22}}));
    EXPECT_EQ(passes.ranges(), (std::vector<PassRanges::Range>{{0, 6}, {7, 10}, {20, 22}}));
    passes.add(6);
    EXPECT_EQ(passes.text(), "0-9, 20-21");
    EXPECT_EQ(passes, PassRanges({{0, 10}, {20, 22}}));
    passes.add(PassRanges());
    EXPECT_EQ(passes.count(), 12u);
}

TEST(PassRanges, APassInBothIsNamedAndNothingChanges) {
    const PassRanges before({{0, 4}, {10, 20}});
    PassRanges passes = before;
    const struct {
        PassRanges other;
        const char* named;
    } overlaps[] = {{before, "pass 0 "},
                    {PassRanges({{3, 5}}), "pass 3 "},
                    {PassRanges({{4, 6}, {12, 13}}), "pass 12 "},
                    {PassRanges({{5, 30}}), "pass 10 "},
                    {PassRanges({{19, 20}}), "pass 19 "}};
    for (const auto& [other, named] : overlaps) {
        const std::string said = conflict([&] { passes.add(other); });
        EXPECT_NE((said + " ").find(named), std::string::npos) << said;
        EXPECT_EQ(passes, before);
    }
}

TEST(PassRanges, MadeOnlyOfRisingRangesThatLieApart) {
    using Ranges = std::vector<PassRanges::Range>;
    for (const Ranges& wrong :
         {Ranges{{3, 3}}, Ranges{{4, 2}}, Ranges{{0, 2}, {2, 3}}, Ranges{{0, 5}, {4, 6}}, Ranges{{5, 6}, {0, 1}}})
        EXPECT_THROW(PassRanges{wrong}, Error);
}

// --- Real methods

/// The passes 0 to kPasses cut into `count` ranges of nearly equal length.
template <class Settings>
std::vector<Film> rendered_parts(const Scene& scene, Settings settings, uint32_t count) {
    std::vector<Film> parts;
    for (uint32_t i = 0; i < count; ++i) {
        settings.first_pass = kPasses * i / count;
        settings.passes = kPasses * (i + 1) / count - settings.first_pass;
        parts.push_back(test::render(scene, settings));
    }
    return parts;
}

/// The parts merged into the first of them, in several orders; each must give `whole`.
void expect_whole(std::vector<Film> parts, const Film& whole) {
    std::mt19937 shuffled(static_cast<uint32_t>(parts.size()));
    for (int order = 0; order < 4; ++order) {
        Film film = parts[0];
        for (size_t i = 1; i < parts.size(); ++i) film.merge(parts[i]);
        EXPECT_TRUE(film == whole) << parts.size() << " ranges, order " << order;
        EXPECT_EQ(film.pixel_hash(), whole.pixel_hash());
        EXPECT_EQ(film.pass_ranges().text(), "0-15");
        EXPECT_EQ(film.next_pass(), kPasses);
        if (order == 0)
            std::reverse(parts.begin(), parts.end());
        else
            std::shuffle(parts.begin(), parts.end(), shuffled);
    }
}

template <class Settings>
void expect_any_cut_gives_the_whole(const Scene& scene, Settings settings) {
    settings.passes = kPasses;
    const Film whole = test::render(scene, settings);
    for (const uint32_t cuts : kCuts) expect_whole(rendered_parts(scene, settings, cuts), whole);
}

TEST(FilmMerge, AnyCutOfPathTracingIsTheWholeRun) {
    test::RenderSettings settings;
    settings.size = {24, 20};
    settings.layers = LayerSet::all();
    settings.layers.remove(Layer::PhotonCount);
    settings.layers.remove(Layer::Overlap);
    expect_any_cut_gives_the_whole(make_builtin_scene("cornell-box-glass"), settings);
}

TEST(FilmMerge, AnyCutOfPhotonMappingIsTheWholeRun) {
    test::RenderSettingsOf<PhotonMapping> settings;
    settings.size = {24, 20};
    settings.layers = LayerSet::all();
    settings.params.photons = 2000;
    settings.params.gather_rays = 4;
    expect_any_cut_gives_the_whole(make_builtin_scene("cornell-box-glass"), settings);
}

// --- Any values

TEST(FilmMerge, PartsMayThemselvesBeMergedAndMayLieApart) {
    const Size2 size{37, 11};
    const LayerSet layers = LayerSet::all();
    const auto range = [&](uint32_t first, uint32_t end) { return film_of_range(size, layers, first, end); };
    Film evens = range(0, 1), odds = range(1, 2);
    for (uint32_t pass = 2; pass < 8; ++pass) (pass % 2 ? odds : evens).merge(range(pass, pass + 1));
    EXPECT_EQ(evens.pass_ranges().text(), "0, 2, 4, 6");
    odds.merge(evens);
    EXPECT_TRUE(odds == range(0, 8));
    Film gap = range(10, 12);
    gap.merge(range(2, 3));
    EXPECT_EQ(gap.passes(), 3u);
    EXPECT_EQ(gap.next_pass(), 12u);
}

TEST(FilmMerge, AnyNumberOfThreadsGivesTheSameBits) {
    const Size2 size{256, 64};
    const auto merged = [&](int threads) {
        return test::on_threads(threads, [&] {
            Film film = film_of_range(size, LayerSet::all(), 0, 2);
            film.merge(film_of_range(size, LayerSet::all(), 2, 4));
            return film;
        });
    };
    const Film one = merged(1);
    EXPECT_TRUE(one == merged(3));
    EXPECT_TRUE(one == film_of_range(size, LayerSet::all(), 0, 4));
}

TEST(FilmMerge, AnEmptyFilmAddsNothing) {
    const Film film = film_of_range({5, 3}, LayerSet::all(), 4, 7);
    Film before = film;
    before.merge(Film({5, 3}, LayerSet::all()));
    EXPECT_TRUE(before == film);
    Film empty({5, 3}, LayerSet::all(), 9);
    empty.merge(film);
    EXPECT_TRUE(empty == film);
    Film still_empty({5, 3}, LayerSet::all(), 9);
    still_empty.merge(Film({5, 3}, LayerSet::all()));
    EXPECT_EQ(still_empty.next_pass(), 9u);
}

TEST(FilmMerge, SaturatedSquaresAreTheSameForAnyCut) {
    const Size2 size{1, 1};
    constexpr uint32_t kMany = 210;  // squares of 2^57.9 each: 69 of them pass 2^64
    const auto part = [&](uint32_t first, uint32_t end) {
        Film film(size, LayerSet(), first);
        for (uint32_t pass = first; pass < end; ++pass) {
            PassImage image(size, LayerSet());
            image.of<Layer::Direct>()[0] = Rgb(0x1.fp28f, pass % 3 == 0 ? 1.0f : 0.0f, 0x1p-30f);
            film.add_pass(image);
        }
        return film;
    };
    const Film whole = part(0, kMany);
    ASSERT_TRUE(std::isinf(whole.pass_variance_beauty()[0]));
    for (const uint32_t cuts : {2u, 3u, 7u, 70u}) {  // parts that are saturated and parts that are not
        Film film(size, LayerSet());
        for (uint32_t i = cuts; i-- > 0;) film.merge(part(kMany * i / cuts, kMany * (i + 1) / cuts));
        EXPECT_TRUE(film == whole) << cuts;
        EXPECT_TRUE(std::isinf(film.pass_variance_beauty()[0])) << cuts;
        EXPECT_TRUE(std::isfinite(film.pass_variance_beauty()[1])) << cuts;
    }
}

TEST(FilmMerge, DroppedValuesAreCountedTogether) {
    const auto part = [](uint32_t pass, float value) {
        PassImage image({2, 1}, LayerSet());
        image.of<Layer::Direct>()[1].y = value;
        Film film({2, 1}, LayerSet(), pass);
        film.add_pass(image);
        return film;
    };
    Film film = part(0, std::nanf(""));
    film.merge(part(1, std::nanf("")));
    film.merge(part(2, kInfinity));
    EXPECT_EQ(film.nan_count(), 2u);
    EXPECT_EQ(film.infinity_count(), 1u);
}

TEST(FilmMerge, UnlikeFilmsAreRefusedAndNothingChanges) {
    const Film before = film_of_range({6, 4}, LayerSet(), 0, 3);
    LayerSet with_depth;
    with_depth.add(Layer::Depth);
    Film film = before;
    const auto said = [&](const Film& other) { return conflict([&] { film.merge(other); }); };
    const std::string size = said(film_of_range({4, 6}, LayerSet(), 3, 4));
    EXPECT_NE(size.find("6 x 4"), std::string::npos) << size;
    EXPECT_NE(size.find("4 x 6"), std::string::npos) << size;
    EXPECT_NE(said(film_of_range({6, 4}, with_depth, 3, 4)).find("layers"), std::string::npos);
    const std::string overlap = said(film_of_range({6, 4}, LayerSet(), 2, 5));
    EXPECT_NE(overlap.find("pass 2 "), std::string::npos) << overlap;
    EXPECT_NE(conflict([&] { film.merge(film); }).find("pass 0 "), std::string::npos);
    EXPECT_TRUE(film == before);
}

}  // namespace
}  // namespace photond::film_merge_test
