// What photonctl takes for the path of a file to upload, and what for a scene's name.

#include "clients/cli/upload.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/support/temporary_folder.h"

namespace photond::cli::upload_test {
namespace {

TEST(SceneArgument, IsAPathByItsSuffixOrByHowItIsWritten) {
    for (const char* path : {"room.glb", "ROOM.GLTF", "room.zip", "details/room.glb", "./room", "../room", "~/room",
                             "/room", "rooms/", "a/b/c", "/tmp/rooms/first"})
        EXPECT_TRUE(looks_like_scene_path(path)) << path;
}

TEST(SceneArgument, IsANameWithoutASlashOrWithOneInside) {
    for (const char* name : {"room", "S12", "cornell-box", "details/books", "hard-case/thin-wall-1e-3", "my room.v2"})
        EXPECT_FALSE(looks_like_scene_path(name)) << name;
}

TEST(SceneArgument, IsAPathWhereSomethingLiesThere) {
    const TemporaryFolder folder;
    const std::filesystem::path before = std::filesystem::current_path();
    std::filesystem::current_path(folder.path());
    std::filesystem::create_directories("details");
    std::ofstream("details/books").put('x');
    EXPECT_TRUE(looks_like_scene_path("details")) << "a folder";
    EXPECT_TRUE(looks_like_scene_path("details/books")) << "a file where a built-in scene has its name";
    EXPECT_FALSE(looks_like_scene_path("details/bar"));
    std::filesystem::current_path(before);
}

}  // namespace
}  // namespace photond::cli::upload_test
