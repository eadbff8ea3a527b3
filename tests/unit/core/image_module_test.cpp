// The module with the image library: found beside the program, and a fault of it is named.

#include "renderer/core/image_module.h"

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "protocol/error.h"

namespace photond::image_module_test {
namespace {

// It is opened lazily: a function that the program does not have would end the process when it is first called.
TEST(ImageModule, FindsAllThatItNeedsInTheProgram) {
    const std::filesystem::path module =
        std::filesystem::read_symlink("/proc/self/exe").parent_path() / "photond-images.so";
    ASSERT_EQ(dlopen(module.c_str(), RTLD_LAZY | RTLD_NOLOAD), nullptr) << "bound lazily already: nothing to see";
    EXPECT_NE(dlopen(module.c_str(), RTLD_NOW | RTLD_LOCAL), nullptr) << dlerror();
}

TEST(ImageModule, HasWhatIsAskedForAndSaysWhatItHasNot) {
    void* const encode = find_image_function("photond_encode_png");
    EXPECT_NE(encode, nullptr);
    EXPECT_EQ(find_image_function("photond_encode_png"), encode);
    try {
        find_image_function("photond_encode_jpeg");
        FAIL() << "it has no such function";
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::Internal);
        EXPECT_NE(std::string(error.what()).find("photond_encode_jpeg"), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace photond::image_module_test
