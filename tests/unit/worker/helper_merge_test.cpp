// The helper joins films: the same bits as the whole, what they took added up, and a film that does not belong named.

#include "server/worker/helper_merge.h"

#include <gtest/gtest.h>

#include <fstream>

#include "renderer/film/film_file.h"
#include "server/worker/film_history.h"
#include "server/worker/helper_tasks.h"
#include "tests/support/random_film.h"
#include "tests/support/temporary_folder.h"

namespace photond::helper_merge_test {
namespace {

using nlohmann::json;

constexpr Size2 kFilmSize{11, 7};
const FilmIdentity kIdentity{"S1", "settings", "cpu class"};

FilmHistory history_of(uint32_t passes) {
    FilmHistory history;
    history.seconds = 0.25 * passes;
    history.counts.camera_rays = 100 * passes;
    history.stages = {{"eye", 0.125 * passes, 0.25 * passes, 0}};
    history.skipped = {{"photons", "no lights", 10}};
    history.standard_error_scale = 0.5;
    return history;
}

class HelperMerge : public testing::Test {
    const TemporaryFolder folder_;

protected:
    std::string file(const std::string& name) const { return folder_.path() / name; }

    std::string part(uint32_t first, uint32_t end, const FilmIdentity& identity = kIdentity) const {
        const std::string path = file(std::to_string(first) + "_" + std::to_string(end));
        FilmFile::save(test::film_of_range(kFilmSize, LayerSet::all(), first, end), identity,
                       history_of(end - first).text(), path);
        return path;
    }
    json merge(const std::vector<std::string>& films, uint64_t memory_bytes = UINT64_MAX) const {
        SceneCache scenes(0);
        return run_helper_task({{"type", "merge_films"},
                                {"request", 1},
                                {"films", films},
                                {"job_request", json::parse(R"({"scene": "cornell-box", "seed": 5,
                                                                "image": {"width": 11, "height": 7},
                                                                "method": {"name": "path_tracing"},
                                                                "stop": {"passes": 16}})")},
                                {"scene_id", "S1"},
                                {"out", file("joined")}},
                               {memory_bytes, 2}, scenes);
    }
    /// What is wrong, and with which film.
    std::string failure(const std::vector<std::string>& films, uint64_t memory_bytes = UINT64_MAX) const {
        const json reply = merge(films, memory_bytes);
        EXPECT_TRUE(reply["result"].is_null()) << reply;
        EXPECT_FALSE(std::filesystem::exists(file("joined")));
        const json& failure = reply["failure"];
        return failure["code"].get<std::string>() + " " + failure["errors"][0]["pointer"].get<std::string>() + ": " +
               failure["detail"].get<std::string>();
    }
};

TEST_F(HelperMerge, PartsInAnyOrderAreTheWholeAndTheirCostsAddUp) {
    const Film whole = test::film_of_range(kFilmSize, LayerSet::all(), 0, 16);
    for (const std::vector<std::string>& films : {std::vector{part(0, 16)}, std::vector{part(9, 16), part(0, 9)},
                                                  std::vector{part(5, 6), part(6, 16), part(2, 5), part(0, 2)}}) {
        const json reply = merge(films);
        ASSERT_TRUE(reply["failure"].is_null()) << reply;
        const json& result = reply["result"];
        EXPECT_EQ(result["passes_done"], 16u);
        EXPECT_EQ(result["pixel_hash"], whole.pixel_hash());
        EXPECT_DOUBLE_EQ(result["seconds"].get<double>(), 4.0);
        const json& statistics = result["statistics"];
        EXPECT_EQ(statistics["pixel_hash"], whole.pixel_hash());
        EXPECT_EQ(statistics["counts"]["passes"], 16u);
        EXPECT_EQ(statistics["counts"]["rays"]["camera"], 1600u);
        EXPECT_EQ(statistics["seed"], 5u);
        EXPECT_EQ(statistics["pass_ranges"], json::array({json::array({0, 16})}));
        EXPECT_EQ(statistics["settings_hash"], "settings");
        ASSERT_EQ(statistics["stages"].size(), 1u);
        EXPECT_DOUBLE_EQ(statistics["stages"][0]["cpu_seconds"].get<double>(), 4.0);
        EXPECT_EQ(statistics["skipped"].size(), 1u);
        EXPECT_TRUE(statistics["memory"]["peak_resident_bytes"].is_null());
        EXPECT_TRUE(statistics["error"].is_null());
        const SavedFilm saved = FilmFile::load(file("joined"));
        EXPECT_TRUE(saved.film == whole);
        EXPECT_EQ(saved.identity, kIdentity);
        const FilmHistory history = FilmHistory::parse(saved.history);
        EXPECT_DOUBLE_EQ(history.seconds, 4.0);
        EXPECT_EQ(history.counts.camera_rays, 1600u);
        // The scale was found for a film of other passes, unless it is the one film there is.
        EXPECT_EQ(history.standard_error_scale.has_value(), films.size() == 1);
        std::filesystem::remove(file("joined"));
    }
}

TEST_F(HelperMerge, AFilmThatDoesNotBelongIsNamed) {
    const std::string first = part(0, 4);
    const auto other = [&](const char* scene, const char* settings, const char* device) {
        return failure({first, part(4, 8, {scene, settings, device})});
    };
    const auto expect = [](const std::string& said, const std::string& start, const std::string& named) {
        EXPECT_TRUE(said.starts_with(start)) << said;
        EXPECT_NE(said.find(named), std::string::npos) << said;
    };
    expect(other("S2", "settings", "cpu class"), "conflict /films/1: ", "scene");
    expect(other("S1", "other seed", "cpu class"), "conflict /films/1: ", "settings");
    expect(other("S1", "settings", "another class"), "conflict /films/1: ", "device");
    expect(other("", "", ""), "conflict /films/1: ", "older version");
    expect(failure({part(0, 4, {}), part(4, 8)}), "conflict /films/0: ", "older version");
    expect(failure({part(0, 4), part(8, 9), part(3, 5)}), "conflict /films/2: ", "pass 3 ");
    expect(failure({first, first}), "conflict /films/1: ", "pass 0 ");
    expect(failure({first, file("none")}), "result_lost /films/1: ", "cannot be opened");
    expect(failure({}), "missing_field /films: ", "films");
    const uint64_t one_film = Film::bytes_for(kFilmSize, LayerSet::all());
    expect(failure({first, part(4, 8)}, 2 * one_film - 1), "out_of_memory /films/1: ", "limit");
    EXPECT_TRUE(merge({first, part(4, 8)}, 2 * one_film)["failure"].is_null());
    std::filesystem::remove(file("joined"));

    const std::string damaged = part(4, 8);
    std::fstream bytes(damaged, std::ios::binary | std::ios::in | std::ios::out);
    bytes.seekp(2000).put('\xff').put('\x5a');
    bytes.close();
    expect(failure({first, damaged}), "result_damaged /films/1: ", "damaged");
}

}  // namespace
}  // namespace photond::helper_merge_test
