// What the helper keeps between pictures of a scene: one scene, within its share, and never in another task's way.

#include <gtest/gtest.h>

#include <filesystem>

#include "server/worker/helper_tasks.h"
#include "tests/support/temporary_folder.h"

namespace photond::helper_warm_scene_test {
namespace {

using nlohmann::json;

class HelperWarmScene : public testing::Test {
protected:
    json ask(json message, uint64_t memory_bytes = uint64_t{1} << 30) {
        message["request"] = 1;
        return run_helper_task(message, {memory_bytes, 2}, scenes_);
    }
    json look(const std::string& scene, uint64_t memory_bytes = uint64_t{1} << 30) {
        return ask({{"type", "preview_scene"},
                    {"scene", {{"id", scene}, {"builtin", scene}, {"root", nullptr}, {"file", nullptr}}},
                    {"camera", nullptr},
                    {"look_at", nullptr},
                    {"width", 16},
                    {"height", 16},
                    {"passes", 1},
                    {"out", folder_.path() / "picture.png"}},
                   memory_bytes);
    }
    uint64_t bytes_of(const std::string& scene) {
        scenes_.clear();
        EXPECT_TRUE(look(scene)["failure"].is_null());
        return scenes_.bytes();
    }
    const TemporaryFolder folder_;
    SceneCache scenes_{0};
};

TEST_F(HelperWarmScene, IsTheLastOneAndCounted) {
    EXPECT_EQ(scenes_.bytes(), 0u);
    const uint64_t box = bytes_of("cornell-box"), ring = bytes_of("caustic-ring");
    EXPECT_GT(box, 0u);
    EXPECT_NE(box, ring);
    EXPECT_TRUE(look("cornell-box")["failure"].is_null());
    EXPECT_EQ(scenes_.bytes(), box) << "not both";
    EXPECT_TRUE(std::filesystem::exists(folder_.path() / "picture.png"));
}

TEST_F(HelperWarmScene, LeavesRoomForScenesThatAreJudged) {
    EXPECT_GT(bytes_of("cornell-box"), 0u);
    EXPECT_TRUE(ask({{"type", "judge_scene"}, {"builtin", "cornell-box"}})["failure"].is_null());
    EXPECT_EQ(scenes_.bytes(), 0u);
}

TEST_F(HelperWarmScene, IsNotKeptWhereItTakesMuchOfTheLimit) {
    const uint64_t interior = bytes_of("interior");
    EXPECT_TRUE(look("interior", 2 * interior)["failure"].is_null());
    EXPECT_EQ(scenes_.bytes(), 0u);
    EXPECT_TRUE(look("interior", 5 * interior)["failure"].is_null());
    EXPECT_EQ(scenes_.bytes(), interior);
    EXPECT_EQ(look("interior", interior / 2)["failure"]["code"], "out_of_memory");
    EXPECT_EQ(scenes_.bytes(), 0u);
}

}  // namespace
}  // namespace photond::helper_warm_scene_test
