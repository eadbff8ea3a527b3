// What a film's file gives back, of this version and of older ones, and that no damage passes for a film.

#include "renderer/film/film_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <cstring>
#include <fstream>

#include "protocol/error.h"
#include "tests/support/film_versions.h"
#include "tests/support/random_film.h"
#include "tests/support/temporary_folder.h"

namespace photond::film_file_test {
namespace {

using test::film_of;
using test::film_of_range;
using test::raw;
using test::relabelled;
constexpr auto digest_of = test::film_digest;
constexpr auto of_version_4 = [](const std::string& now) { return test::film_of_version(now, 4); };
constexpr auto of_version_5 = [](const std::string& now) { return test::film_of_version(now, 5); };

const FilmIdentity kIdentity{"scene 1", "settings of path_tracing", "cpu, version 1"};
const std::string kHistory = R"({"seconds": 1.5})";

class FilmFileTest : public testing::Test {
    const TemporaryFolder folder_;

protected:
    const std::filesystem::path path = folder_.path() / "film";

    std::string bytes() const {
        std::ifstream in(path, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    void write(const std::string& content) const {
        std::ofstream(path, std::ios::binary | std::ios::trunc).write(content.data(), std::streamsize(content.size()));
    }
    /// What examining says.
    std::string examined() const {
        try {
            (void)FilmFile::examine(path);
        } catch (const Error& error) {
            return error.what();
        }
        return "";
    }
    /// What loading says, and examining says too; empty when it is content.
    std::string refusal(ErrorCode expected = ErrorCode::ResultDamaged) const {
        try {
            (void)FilmFile::load(path);
        } catch (const Error& error) {
            EXPECT_EQ(error.code, expected) << error.what();
            EXPECT_EQ(examined(), error.what());
            return error.what();
        }
        EXPECT_EQ(examined(), "");
        return "";
    }
};

TEST_F(FilmFileTest, GivesTheSameFilmBack) {
    const Size2 size{211, 97};  // more than one block an array, the last one cut
    const Film film = film_of(size, LayerSet::all(), {0, 1, 2, 3});
    FilmFile::save(film, kIdentity, kHistory, path);
    const SavedFilm loaded = FilmFile::load(path);
    EXPECT_TRUE(film == loaded.film);
    EXPECT_EQ(loaded.film.pixel_hash(), film.pixel_hash());
    EXPECT_EQ(loaded.identity, kIdentity);
    EXPECT_EQ(loaded.history, kHistory);
    EXPECT_FALSE(std::filesystem::exists(path.string() + ".part"));
    try {
        (void)FilmFile::load(path, film.bytes() - 1);
        ADD_FAILURE() << "loaded past its limit";
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::OutOfMemory);
    }
}

TEST_F(FilmFileTest, SaysWhoRenderedIt) {
    const Film film = film_of({211, 97}, LayerSet::all(), {0, 1, 2});
    FilmFile::save(film, kIdentity, kHistory, path, "the third attempt");
    const FilmFacts facts = FilmFile::examine(path);
    EXPECT_EQ(facts.passes, 3u);
    EXPECT_EQ(facts.history, kHistory);
    EXPECT_EQ(facts.origin, "the third attempt");
    EXPECT_TRUE(FilmFile::load(path).film == film);
}

TEST_F(FilmFileTest, KeepsWhichPassesItHoldsAndGoesOnBehindThem) {
    const Size2 size{7, 5};
    Film film = film_of_range(size, LayerSet(), 16, 19);
    film.merge(film_of_range(size, LayerSet(), 3, 5));
    FilmFile::save(film, kIdentity, kHistory, path);
    Film loaded = FilmFile::load(path).film;
    EXPECT_TRUE(loaded == film);
    EXPECT_EQ(loaded.pass_ranges().text(), "3-4, 16-18");
    EXPECT_EQ(loaded.next_pass(), 19u);
    loaded.add_pass(test::random_pass(size, LayerSet(), 19));
    EXPECT_EQ(loaded.pass_ranges().text(), "3-4, 16-19");
    EXPECT_EQ(loaded.passes(), 6u);
}

TEST_F(FilmFileTest, TextsMayBeEmptyOrHoldAnyBytes) {
    const Film film = film_of({3, 2}, LayerSet(), {0});
    for (const std::string& text : {std::string(), std::string("\0\n\xff", 3), std::string(100'000, 'x')}) {
        FilmFile::save(film, {text, "", text}, text, path);
        const SavedFilm loaded = FilmFile::load(path);
        EXPECT_EQ(loaded.identity, (FilmIdentity{text, "", text}));
        EXPECT_EQ(loaded.history, text);
        EXPECT_TRUE(loaded.film == film);
    }
}

// --- Older versions, by bytes put together here from their format

constexpr uint32_t kEmittedDirectIndirect = 0b111, kDepth = 1u << 7, kPhotonCount = 1u << 9;

std::string header(uint32_t version, uint32_t width, uint32_t height, uint32_t layers, uint32_t passes) {
    std::string text = "PHOTFILM" + raw(version) + raw(width) + raw(height) + raw(layers) + raw(passes) +
                       raw(uint32_t{0}) + raw(uint64_t{3}) + raw(uint64_t{2});
    return text + digest_of(text);
}

/// A block of whole numbers of that many bytes each, in two's complement.
std::string block(uint8_t width, const std::vector<FixedSum>& values) {
    std::string text(1, static_cast<char>(width));
    for (const FixedSum value : values) text += raw(value).substr(0, width);
    return text + digest_of(text);
}

constexpr FixedSum kOne = FixedSum{1} << 64;

/// Two pixels, two passes of emitted 1, 0, 0.5; direct -2 in the first pixel's red; indirect 0; depth 3 in the second.
std::string old_film(uint32_t version, uint32_t extra_layers = 0) {
    const std::vector<FixedSum> nothing(6, 0), squares_emitted{2 * kOne, 0, kOne / 2, 2 * kOne, 0, kOne / 2};
    std::vector<FixedSum> squares_beauty = squares_emitted;
    squares_beauty[0] = 2 * kOne;  // (1 - 2)^2
    return header(version, 2, 1, kEmittedDirectIndirect | kDepth | extra_layers, 2) +
           block(9, {2 * kOne, 0, kOne, 2 * kOne, 0, kOne}) + block(16, {-4 * kOne, 0, 0, 0, 0, 0}) +
           block(1, nothing) + block(16, {0, 6 * kOne}) + block(9, squares_beauty) +
           block(12, {8 * kOne, 0, 0, 0, 0, 0}) + block(1, nothing) + block(4, {0, 2});
}

TEST_F(FilmFileTest, ReadsTheVersionsBeforeIdentity) {
    LayerSet layers;
    layers.add(Layer::Depth);
    Film film({2, 1}, layers);
    PassImage pass({2, 1}, layers);
    pass.of<Layer::Emitted>() = {Rgb(1, 0, 0.5f), Rgb(1, 0, 0.5f)};
    pass.of<Layer::Direct>()[0].x = -2;
    pass.hit[1] = 1, pass.of<Layer::Depth>()[1] = 3;
    for (int p = 0; p < 2; ++p) film.add_pass(pass);
    for (const uint32_t version : {1u, 2u}) {
        write(old_film(version));
        const SavedFilm loaded = FilmFile::load(path);
        EXPECT_EQ(loaded.film.resolve_beauty(), film.resolve_beauty());
        EXPECT_EQ(loaded.film.resolve(Layer::Depth), (std::vector<float>{0, 3}));
        EXPECT_EQ(loaded.film.pass_variance_beauty(), std::vector<float>(6, 0.0f));
        EXPECT_EQ(loaded.film.pixel_hash(), film.pixel_hash());
        EXPECT_EQ(loaded.film.nan_count(), 3u);
        EXPECT_EQ(loaded.film.infinity_count(), 2u);
        EXPECT_EQ(loaded.film.pass_ranges().text(), "0-1");
        EXPECT_EQ(loaded.film.next_pass(), 2u);
        EXPECT_EQ(loaded.identity, FilmIdentity());
        EXPECT_EQ(loaded.history, "");
    }
    write(old_film(2).substr(0, 80 + 40));
    EXPECT_NE(refusal().find("cut short"), std::string::npos);
    write(old_film(1, kPhotonCount));  // a layer that version did not have
    EXPECT_NE(refusal().find("layers"), std::string::npos);
    write(old_film(10));
    EXPECT_NE(refusal(ErrorCode::Unsupported).find("reads 1 to 9"), std::string::npos);
    write(old_film(0));
    EXPECT_NE(refusal(ErrorCode::Unsupported).find("version 0"), std::string::npos);
}

// What came with version 4 are layers after the others: files without them are the same but for the number.
TEST_F(FilmFileTest, ReadsTheVersionBeforeTheLooksAtMethods) {
    constexpr auto kFirstNew = static_cast<size_t>(Layer::Clamped);
    const std::span<const LayerInfo> new_layers = std::span(kLayers).subspan(kFirstNew);
    LayerSet layers = LayerSet::all();
    for (const LayerInfo& info : new_layers) layers.remove(info.layer);
    const Film film = film_of_range({9, 5}, layers, 0, 3);
    FilmFile::save(film, kIdentity, kHistory, path);
    const std::string now = of_version_4(bytes());
    for (const uint32_t version : {4u, 3u}) {
        write(relabelled(now, version));
        const SavedFilm loaded = FilmFile::load(path);
        EXPECT_EQ(FilmFile::examine(path).origin, "");
        EXPECT_EQ(loaded.identity, kIdentity);
        EXPECT_EQ(loaded.history, kHistory);
        EXPECT_EQ(loaded.film.pixel_hash(), film.pixel_hash());
        FilmFile::save(loaded.film, kIdentity, kHistory, path);
        EXPECT_EQ(of_version_4(bytes()), now) << "the same sums, of version " << version;
    }
    for (const LayerInfo& info : new_layers) {
        write(relabelled(now, 3, uint64_t{1} << static_cast<unsigned>(info.layer)));
        EXPECT_NE(refusal().find("layers"), std::string::npos) << info.name;
    }
    write(relabelled(now, 4, uint64_t{1} << kLayerCount));
    EXPECT_NE(refusal(ErrorCode::Unsupported).find("layers that this program does not know"), std::string::npos);
}

// Programs of before refuse what has layers that they cannot name, and read what has none.
TEST_F(FilmFileTest, SaysByItsVersionWhetherItHasMoreLayersThanThirtyTwo) {
    const auto version_with = [&](LayerSet layers) {
        const Film film = film_of_range({3, 2}, layers, 0, 2);
        FilmFile::save(film, kIdentity, kHistory, path);
        EXPECT_TRUE(FilmFile::load(path).film == film);
        uint32_t version;
        std::memcpy(&version, &bytes()[8], sizeof version);
        return version;
    };
    LayerSet one_more;
    one_more.add(Layer::CacheSamples);
    ASSERT_GE(static_cast<size_t>(Layer::CacheSamples), 32u);
    EXPECT_EQ(version_with(LayerSet()), 7u);
    EXPECT_EQ(version_with(one_more), 8u);
}

// What came with version 6 are the passes' means: they are known of the passes that are added afterwards alone.
TEST_F(FilmFileTest, ReadsTheVersionBeforeTheMeansOfPassesAndClaimsNoneOfThem) {
    const Size2 size{9, 5};
    FilmFile::save(film_of_range(size, LayerSet::all(), 0, 3), kIdentity, kHistory, path, "the first attempt");
    const std::string now = bytes(), old = of_version_5(now);
    write(old);
    EXPECT_EQ(FilmFile::examine(path).passes, 3u);
    SavedFilm loaded = FilmFile::load(path);
    EXPECT_EQ(loaded.identity, kIdentity);
    EXPECT_EQ(loaded.film.passes(), 3u);
    EXPECT_EQ(loaded.film.pass_means(), PassMeans());
    FilmFile::save(loaded.film, kIdentity, kHistory, path, "the first attempt");
    EXPECT_NE(bytes(), now);
    EXPECT_EQ(of_version_5(bytes()), old) << "the same sums";
    // It goes on, and is joined with others, as if all had been rendered here but for the means.
    const Film whole = film_of_range(size, LayerSet::all(), 0, 9);
    for (uint32_t pass = 3; pass < 5; ++pass) loaded.film.add_pass(test::random_pass(size, LayerSet::all(), pass));
    loaded.film.merge(film_of_range(size, LayerSet::all(), 5, 9));
    EXPECT_EQ(loaded.film.pixel_hash(), whole.pixel_hash());
    EXPECT_EQ(loaded.film.pass_variance_beauty(), whole.pass_variance_beauty());
    EXPECT_EQ(loaded.film.passes(), 9u);
    EXPECT_EQ(loaded.film.pass_means(), film_of_range(size, LayerSet::all(), 3, 9).pass_means());
    Film known = film_of_range(size, LayerSet::all(), 3, 9);
    write(old);
    known.merge(FilmFile::load(path).film);
    EXPECT_TRUE(known == loaded.film);
    FilmFile::save(known, kIdentity, kHistory, path);
    EXPECT_TRUE(FilmFile::load(path).film == known);
}

TEST_F(FilmFileTest, KeepsAStateOfAnyLength) {
    const Film film = film_of_range({9, 5}, LayerSet(), 0, 2);
    for (const size_t length : {size_t{0}, size_t{1}, size_t{1} << 20, (size_t{5} << 19) + 3}) {
        std::string state(length, '\0');
        for (size_t i = 0; i < length; ++i) state[i] = static_cast<char>(hash32(static_cast<uint32_t>(i)));
        FilmFile::save(film, kIdentity, kHistory, path, "", state);
        const SavedFilm loaded = FilmFile::load(path);
        EXPECT_TRUE(loaded.state == state) << length;
        EXPECT_TRUE(loaded.film == film) << length;
        EXPECT_EQ(FilmFile::examine(path).passes, 2u);
    }
    EXPECT_THROW(FilmFile::load(path, Film::bytes_for({9, 5}, LayerSet()) + (1 << 20)), Error) << "more than allowed";
    EXPECT_NO_THROW(FilmFile::load(path, Film::bytes_for({9, 5}, LayerSet()) + (4 << 20)));
}

TEST_F(FilmFileTest, ReadsTheVersionBeforeStates) {
    const Film film = film_of_range({9, 5}, LayerSet::all(), 0, 3);
    FilmFile::save(film, kIdentity, kHistory, path);
    write(test::film_of_version(bytes(), 6));
    const SavedFilm loaded = FilmFile::load(path);
    EXPECT_TRUE(loaded.film == film);
    EXPECT_EQ(loaded.state, "");
    EXPECT_EQ(FilmFile::examine(path).passes, 3u);
}

// --- Damage

TEST_F(FilmFileTest, RefusesEveryDamage) {
    Film film = film_of_range({9, 5}, LayerSet::all(), 4, 6);
    film.merge(film_of_range({9, 5}, LayerSet::all(), 0, 1));
    const std::string state = "radii of passes";
    FilmFile::save(film, kIdentity, kHistory, path, "", state);
    const std::string good = bytes();
    ASSERT_EQ(refusal(), "");
    const size_t texts = kIdentity.scene.size() + kIdentity.settings.size() + kIdentity.device.size() +
                         kHistory.size() + sizeof(uint64_t) + state.size();
    const size_t sums_at =
        80 + texts + 2 * sizeof(PassRanges::Range) + PassMeans().bytes().size() + 9 * (sizeof(uint64_t) + 32);
    for (size_t at = 0; at < good.size(); at += at < sums_at ? 1 : 61)  // every byte of what comes before the sums
        for (const char bit : {'\x01', '\x10'}) {
            std::string changed = good;
            changed[at] = static_cast<char>(changed[at] ^ bit);
            write(changed);
            EXPECT_NE(refusal(), "") << "byte " << at;
        }
    for (size_t length = 0; length < good.size(); length += length < sums_at ? 7 : 173) {
        write(good.substr(0, length));
        EXPECT_NE(refusal(), "") << "cut to " << length;
    }
    write(good + "x");
    EXPECT_NE(refusal(), "");
}

/// One of the parts of version 3 between header and sums.
std::string part(const std::string& content) {
    const std::string text = raw(uint64_t{content.size()}) + content;
    return text + digest_of(text);
}

TEST_F(FilmFileTest, RefusesRangesThatAreNotOfItsPasses) {
    const std::string texts = part("scene") + part("settings") + part("device") + part("{}");
    const std::string sums = old_film(2).substr(80), start = header(3, 2, 1, kEmittedDirectIndirect | kDepth, 2);
    const auto range = [](uint32_t first, uint32_t end) { return raw(first) + raw(end); };
    write(start + texts + part(range(5, 6) + range(9, 10)) + sums);
    EXPECT_EQ(FilmFile::load(path).film.pass_ranges().text(), "5, 9");
    for (const std::string& wrong :
         {range(0, 1), range(0, 3), range(1, 1) + range(4, 6), range(5, 6) + range(5, 6), range(9, 10) + range(5, 6),
          range(5, 6) + range(6, 7), range(5, 6) + range(9, 10) + "abc", range(0, 2).substr(0, 4), std::string()}) {
        write(start + texts + part(wrong) + sums);
        EXPECT_NE(refusal(), "") << testing::PrintToString(wrong);
    }
    std::string endless = start + raw(uint64_t{1} << 62);  // a length that no memory holds
    write(endless + texts + sums);
    EXPECT_NE(refusal(), "");
}

TEST_F(FilmFileTest, RefusesMeansThatAreNotOfItsPasses) {
    FilmFile::save(film_of_range({9, 5}, LayerSet(), 0, 3), kIdentity, kHistory, path);
    const std::string good = bytes();
    const auto [at, length] = test::place_of_part(good, test::kMeansPart);
    const auto with_means = [&, at = at, length = length](const std::string& means) {
        return good.substr(0, at) + part(means) + good.substr(at + length);
    };
    for (const uint32_t passes : {0u, 2u, 3u}) {
        const PassMeans means = film_of_range({9, 5}, LayerSet(), 0, passes).pass_means();
        write(with_means(means.bytes()));
        EXPECT_EQ(FilmFile::load(path).film.pass_means(), means);
    }
    const std::string four = film_of_range({9, 5}, LayerSet(), 0, 4).pass_means().bytes();
    for (const std::string& wrong : {four, PassMeans().bytes().substr(1), PassMeans().bytes() + "x", std::string()}) {
        write(with_means(wrong));
        EXPECT_NE(refusal().find("its means are not of its passes"), std::string::npos);
    }
}

TEST_F(FilmFileTest, AFullDiskIsNamedAndLeavesNothing) {
    const Film film = film_of({128, 128}, LayerSet(), {0});
    signal(SIGXFSZ, SIG_IGN);
    rlimit before{};
    getrlimit(RLIMIT_FSIZE, &before);
    rlimit small = before;
    small.rlim_cur = 100'000;
    setrlimit(RLIMIT_FSIZE, &small);
    try {
        FilmFile::save(film, kIdentity, kHistory, path);
        ADD_FAILURE() << "saved past the limit";
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::NoSpace) << error.what();
    }
    setrlimit(RLIMIT_FSIZE, &before);
    EXPECT_FALSE(std::filesystem::exists(path));
    EXPECT_FALSE(std::filesystem::exists(path.string() + ".part"));
}

// --- What belongs together

std::string difference(const FilmIdentity& a, const FilmIdentity& b) {
    try {
        require_alike(a, b);
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::Conflict);
        return error.what();
    }
    return "";
}

TEST(FilmIdentity, NamesWhatDiffersAndShowsBoth) {
    EXPECT_EQ(difference(kIdentity, kIdentity), "");
    FilmIdentity other = kIdentity;
    other.scene = "scene 2";
    const std::string scene = difference(kIdentity, other);
    for (const char* named : {"scene", "scene 1", "scene 2"}) EXPECT_NE(scene.find(named), std::string::npos) << scene;
    other = kIdentity, other.settings = "settings of photon_mapping";
    EXPECT_NE(difference(kIdentity, other).find("settings"), std::string::npos);
    EXPECT_EQ(difference(kIdentity, other).find("scene"), std::string::npos);
    other = kIdentity, other.device = "cpu, version 2";
    const std::string device = difference(kIdentity, other);
    for (const char* named : {"device", "version 1", "version 2"})
        EXPECT_NE(device.find(named), std::string::npos) << device;
}

TEST(FilmIdentity, AnEmptyOneIsLikeNothing) {
    EXPECT_NE(difference({}, kIdentity), "");
    EXPECT_NE(difference(kIdentity, {}), "");
    EXPECT_NE(difference({}, {}), "");
}

}  // namespace
}  // namespace photond::film_file_test
