#include "renderer/backends/gpu/shader_specialization.h"

#include <spirv-tools/optimizer.hpp>

#include <string>
#include <unordered_map>

#include "protocol/error.h"

namespace photond::gpu {

std::vector<uint32_t> specialized(const Shader& shader, std::span<const Specialization> constants) {
    std::unordered_map<uint32_t, std::vector<uint32_t>> values;
    for (const Specialization& constant : constants) values[constant.id] = {constant.value};
    spvtools::Optimizer optimizer(SPV_ENV_VULKAN_1_3);
    std::string said;
    optimizer.SetMessageConsumer(
        [&](spv_message_level_t, const char*, const spv_position_t&, const char* text) { said += text; });
    optimizer.RegisterPass(spvtools::CreateSetSpecConstantDefaultValuePass(values))
        .RegisterPass(spvtools::CreateFreezeSpecConstantValuePass())
        .RegisterPass(spvtools::CreateFoldSpecConstantOpAndCompositePass())
        .RegisterPass(spvtools::CreateDeadBranchElimPass())
        .RegisterPass(spvtools::CreateEliminateDeadFunctionsPass())
        // "NEEDS_A && b" is a branch whose outcome is stored and read again.
        .RegisterPass(spvtools::CreateLocalSingleBlockLoadStoreElimPass())
        .RegisterPass(spvtools::CreateLocalSingleStoreElimPass())
        .RegisterPass(spvtools::CreateCCPPass())
        .RegisterPass(spvtools::CreateDeadBranchElimPass())
        .RegisterPass(spvtools::CreateEliminateDeadFunctionsPass());
    spvtools::OptimizerOptions options;
    options.set_run_validator(false);  // the build's compiler wrote them; the validation layers look at what comes out
    std::vector<uint32_t> words;
    if (!optimizer.Run(shader.words.data(), shader.words.size(), &words, options))
        throw Error(ErrorCode::Internal, std::string(shader.source) + " cannot be specialised: " + said);
    return words;
}

std::vector<uint32_t> with_infinities(std::span<const uint32_t> words) {
    enum : uint32_t { kOpEntryPoint = 15, kOpExecutionMode = 16, kOpCapability = 17 };  // SPIR-V 1.6, section 3.42
    enum : uint32_t { kCapability = 4466, kExecutionMode = 4461 };                      // SignedZeroInfNanPreserve
    constexpr size_t kHeader = 5;
    if (words.size() < kHeader) throw Error(ErrorCode::Internal, "a shader's SPIR-V is cut off");
    std::vector<uint32_t> kept(words.begin(), words.begin() + kHeader);
    kept.insert(kept.end(), {2u << 16 | kOpCapability, kCapability});
    for (size_t i = kHeader; i < words.size();) {
        const uint32_t length = words[i] >> 16;
        if (length == 0 || i + length > words.size()) throw Error(ErrorCode::Internal, "a shader's SPIR-V is cut off");
        const std::span<const uint32_t> op = words.subspan(i, length);
        kept.insert(kept.end(), op.begin(), op.end());
        if ((op[0] & 0xffffu) == kOpEntryPoint)
            kept.insert(kept.end(), {4u << 16 | kOpExecutionMode, op[2], kExecutionMode, 32});
        i += length;
    }
    return kept;
}

}  // namespace photond::gpu
