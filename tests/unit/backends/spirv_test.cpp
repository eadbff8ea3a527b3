// What is read off a shader's words: the names of its buffers, by which they are bound.

#include "renderer/backends/gpu/spirv.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace photond {

namespace gpu {
std::span<const Shader> built_in_shaders();  // written by the build
std::span<const Shader> test_shaders();
}  // namespace gpu

namespace spirv_test {
namespace {

TEST(Spirv, EveryBufferOfEveryShaderHasANameOfItsOwn) {
    size_t buffers = 0;
    for (const std::span<const gpu::Shader> shaders : {gpu::built_in_shaders(), gpu::test_shaders()})
        for (const gpu::Shader& shader : shaders) {
            SCOPED_TRACE(shader.source);
            std::set<std::string_view> names;
            for (const gpu::ShaderBuffer& buffer : gpu::buffers_of(shader.words)) {
                EXPECT_NE(buffer.name, "") << "binding " << buffer.binding;
                EXPECT_TRUE(names.insert(buffer.name).second) << buffer.name;
                ++buffers;
            }
        }
    EXPECT_GT(buffers, 100);
}

TEST(Spirv, ABuffersNameIsThatOfItsBlocksOnlyMember) {
    const auto buffers = gpu::buffers_of(gpu::find_shader("renderer/backends/gpu/radix_sort_scatter.comp").words);
    std::vector<std::string> names;
    for (const gpu::ShaderBuffer& buffer : buffers) {
        EXPECT_EQ(buffer.binding, names.size());
        EXPECT_EQ(buffer.read_only, buffer.binding < 5) << buffer.name;
        names.emplace_back(buffer.name);
    }
    EXPECT_EQ(names, (std::vector<std::string>{"tiles_state", "keys", "values", "starts", "totals", "sorted_keys",
                                               "sorted_values"}));
}

/// A module of one buffer at binding 7 whose block has as many members; the first one's name ends with its word.
std::vector<uint32_t> module_with_members(uint32_t members) {
    constexpr uint32_t kBlock = 1, kPointer = 2, kVariable = 3, kUint = 4, kStorageBuffer = 12;
    std::vector<uint32_t> words = {0x07230203, 0x00010600, 0, 5, 0};
    const auto add = [&](uint32_t opcode, std::vector<uint32_t> operands) {
        words.push_back(static_cast<uint32_t>(operands.size() + 1) << 16 | opcode);
        words.insert(words.end(), operands.begin(), operands.end());
    };
    for (uint32_t member = 0; member < members; ++member)
        add(6, {kBlock, member, 'k' | 'e' << 8 | 'y' << 16 | uint32_t{'0' + member} << 24, 0});  // OpMemberName
    add(71, {kVariable, 33, 7});                                                                 // OpDecorate, Binding
    add(21, {kUint, 32, 0});                                                                     // OpTypeInt
    std::vector<uint32_t> block = {kBlock};
    block.resize(1 + members, kUint);
    add(30, block);                                  // OpTypeStruct
    add(32, {kPointer, kStorageBuffer, kBlock});     // OpTypePointer
    add(59, {kPointer, kVariable, kStorageBuffer});  // OpVariable
    return words;
}

TEST(Spirv, ABufferOfSeveralMembersHasNoName) {
    for (const uint32_t members : {1u, 2u, 3u}) {
        const std::vector<uint32_t> words = module_with_members(members);
        const std::vector<gpu::ShaderBuffer> buffers = gpu::buffers_of(words);
        ASSERT_EQ(buffers.size(), 1);
        EXPECT_EQ(buffers[0].binding, 7);
        EXPECT_EQ(buffers[0].name, members == 1 ? "key0" : "");
    }
}

}  // namespace
}  // namespace spirv_test
}  // namespace photond
