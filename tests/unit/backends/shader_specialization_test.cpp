// Constants put into a shader before a driver sees it: they are constants no longer, what they switch off is gone, and
// the buffers are those that are bound.

#include "renderer/backends/gpu/shader_specialization.h"

#include <gtest/gtest.h>

#include "protocol/error.h"

namespace photond::shader_specialization_test {
namespace {

using gpu::buffers_of;
using gpu::constants_of;
using gpu::Specialization;

constexpr uint32_t kNeeds = 19;  // of scene.glsl
constexpr uint32_t kOnlyLambert = 7;

/// A scene of nothing but diffuse walls and a lamp, or one with all there is.
std::vector<Specialization> needs(bool all) {
    std::vector<Specialization> constants;
    for (uint32_t id = 0; id < kNeeds; ++id) constants.push_back(gpu::specialize(id, all != (id == kOnlyLambert)));
    return constants;
}

TEST(ShaderSpecialization, LeavesNoConstantAndNothingThatIsNotReached) {
    const gpu::Shader& shader = gpu::find_shader("renderer/methods/path_tracing/path_tracing.comp");
    ASSERT_GT(constants_of(shader.words).size(), kNeeds);
    const std::vector<uint32_t> all = specialized(shader, needs(true)), few = specialized(shader, needs(false));
    for (const std::vector<uint32_t>& words : {all, few}) {
        EXPECT_TRUE(constants_of(words).empty());
        EXPECT_TRUE(gpu::uses_scene(words));
        const auto now = buffers_of(words), before = buffers_of(shader.words);
        ASSERT_EQ(now.size(), before.size());
        for (size_t i = 0; i < now.size(); ++i) {
            EXPECT_EQ(now[i].binding, before[i].binding);
            EXPECT_EQ(now[i].read_only, before[i].read_only);
        }
    }
    EXPECT_LT(few.size(), 3 * all.size() / 4) << "the code for textures and glass";
}

TEST(ShaderSpecialization, IsTheSameEachTimeAndPassesOverForeignConstants) {
    const gpu::Shader& shader = gpu::find_shader("renderer/backends/gpu/prefix_sum_reduce.comp");
    const std::vector<Specialization> own = {gpu::specialize(constants_of(shader.words).front(), 64u)};
    std::vector<Specialization> more = own;
    more.push_back(gpu::specialize(1000, true));
    EXPECT_EQ(specialized(shader, own), specialized(shader, more));
    EXPECT_NE(specialized(shader, own), specialized(shader, {}));
}

// One capability and one mode of its entry point more; all that was there stands as it did.
TEST(ShaderSpecialization, KeepsInfinitiesByACapabilityAndAMode) {
    const std::vector<uint32_t> words =
        specialized(gpu::find_shader("renderer/methods/path_tracing/path_tracing.comp"), needs(true));
    const std::vector<uint32_t> kept = gpu::with_infinities(words);
    constexpr size_t kAdded = 2 + 4;
    ASSERT_EQ(kept.size(), words.size() + kAdded);
    const std::vector<uint32_t> capability = {2u << 16 | 17u, 4466};  // OpCapability SignedZeroInfNanPreserve
    EXPECT_TRUE(std::equal(capability.begin(), capability.end(), kept.begin() + 5)) << "first after the header";
    const std::vector<uint32_t> mode = {4461, 32};
    const auto at = std::search(kept.begin(), kept.end(), mode.begin(), mode.end());
    ASSERT_NE(at, kept.end());
    std::vector<uint32_t> rest(kept.begin(), at - 2);
    rest.insert(rest.end(), at + 2, kept.end());
    rest.erase(rest.begin() + 5, rest.begin() + 7);
    EXPECT_EQ(rest, words);
    EXPECT_EQ(*(at - 2), 4u << 16 | 16u) << "OpExecutionMode";
    EXPECT_THROW(gpu::with_infinities(std::vector<uint32_t>{1, 2, 3}), Error);
}

TEST(ShaderSpecialization, SaysWhichShaderIsNone) {
    const std::vector<uint32_t> words = {1, 2, 3};
    try {
        gpu::specialized({"torn.comp", words}, {});
        FAIL() << "that is no SPIR-V";
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::Internal);
        EXPECT_NE(std::string(error.what()).find("torn.comp"), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace photond::shader_specialization_test
