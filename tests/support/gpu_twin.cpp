#include "tests/support/gpu_twin.h"

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "renderer/backends/gpu/instance.h"
#include "renderer/backends/gpu/scene_bindings.h"

/// What the validation layers and lavapipe keep of an instance that lives as long as the process is theirs.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
    return "leak:libVkLayer_khronos_validation.so\nleak:libvulkan_lvp.so\n";
}

namespace photond {

namespace gpu {
std::span<const Shader> test_shaders();  // written by the build
}

namespace test {

namespace {

constexpr uint32_t kGroup = 64;  // TWIN_GROUP

/// Owns the device, so that it is gone before the layers' messages are counted: they also tell of what it left behind.
class GpuEnvironment final : public testing::Environment {
public:
    gpu::Device& device() {
        if (device_) return *device_;
        gpu::add_shaders(gpu::test_shaders());
        // Before the instance is made, which looks at it; what the caller says stands.
        setenv("PHOTOND_GPU_VALIDATION", "1", 0);
        // Unloaded, lavapipe's library leaves what LeakSanitizer then cannot trace to it. Absent where it is not used.
        dlopen("libvulkan_lvp.so", RTLD_NOW | RTLD_NODELETE);
        gpu::DeviceOptions options;
        if (const char* id = std::getenv("PHOTOND_TEST_DEVICE")) options.id = id;
        device_ = std::make_unique<gpu::Device>(options);
        return *device_;
    }

    void TearDown() override {
        device_.reset();
        EXPECT_EQ(gpu::Instance::validation_messages(), 0) << "the Vulkan validation layers had something to say";
    }

private:
    std::unique_ptr<gpu::Device> device_;
};

// gtest deletes it; registered when the program starts, as TearDown() must be, whichever test asks for the device.
GpuEnvironment* const g_environment = [] {
    auto* environment = new GpuEnvironment;
    testing::AddGlobalTestEnvironment(environment);
    return environment;
}();

}  // namespace

gpu::Device& gpu_device() { return g_environment->device(); }

PartOfScene::PartOfScene(std::span<const Part> parts) {
    gpu::Device& device = gpu_device();
    static constexpr std::byte kNothing[4] = {};
    std::vector<std::span<const std::byte>> all(SCENE_BINDINGS, kNothing);
    for (const Part& part : parts) all[part.binding] = part.bytes;
    std::vector<gpu::Buffer*> pointers;
    buffers_.reserve(all.size());
    for (const std::span<const std::byte> bytes : all)
        pointers.push_back(&buffers_.emplace_back(gpu::make_buffer(device, "test scene", bytes)));
    set_ = std::make_unique<gpu::BufferSet>(device, "test scene", pointers);
}

Twin::Twin(std::string_view source, const gpu::BufferSet* scene, std::span<const gpu::Specialization> constants)
    : pipeline_(gpu_device(), source, sizeof(uint32_t), scene, constants) {}

void Twin::run_bytes(size_t count, std::span<const TwinInput> inputs, std::span<std::byte> out) const {
    gpu::Device& device = gpu_device();
    std::vector<gpu::Buffer> buffers;
    std::vector<gpu::Binding> bindings;
    buffers.reserve(inputs.size() + 1);
    for (const TwinInput& input : inputs)
        bindings.push_back(
            gpu::read(input.name, buffers.emplace_back(gpu::make_buffer(device, "test input", input.bytes))));
    gpu::Buffer& output = buffers.emplace_back(device, "test output", std::max<size_t>(out.size(), 4));
    for (const gpu::ShaderBuffer& buffer : pipeline_.layout().buffers())
        if (!buffer.read_only) bindings.push_back(gpu::write(buffer.name, output));

    gpu::CommandList commands(device);
    commands.bind(pipeline_, bindings);
    commands.push(static_cast<uint32_t>(count));
    commands.dispatch_threads(count, kGroup);
    commands.submit();
    commands.wait();
    gpu::download(device, output, out);
}

}  // namespace test
}  // namespace photond
