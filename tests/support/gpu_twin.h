#pragma once
// Runs the GLSL twin of something over arrays, to be compared with the C++ of the same name.
//
// The tests' shaders are tests/gpu/*.comp. Each has its inputs (readonly) and one output (writeonly) in set 0, `uint
// count` as its push constant, and groups of TWIN_GROUP threads numbered by flat_index(); tests/gpu/twin.glsl says so
// once. Programs that use this fail when the validation layers said anything.

#include <memory>
#include <string_view>
#include <vector>

#include "renderer/backends/gpu/command_list.h"

namespace photond::test {

/// The device of this program's tests: PHOTOND_TEST_DEVICE (an id of DeviceOptions), else the first. Made when first
/// asked for, with validation layers unless PHOTOND_GPU_VALIDATION says 0; throws where there is no device: no test of
/// the GPU passes without one.
gpu::Device& gpu_device();

/// Descriptor set 1 for shaders that read only some of the scene's buffers (scene_bindings.h): those given, and next to
/// nothing at all other bindings.
class PartOfScene {
public:
    struct Part {
        uint32_t binding;
        std::span<const std::byte> bytes;
    };
    explicit PartOfScene(std::span<const Part> parts);
    PartOfScene(std::initializer_list<Part> parts) : PartOfScene(std::span(parts.begin(), parts.size())) {}

    const gpu::BufferSet& set() const { return *set_; }

private:
    std::vector<gpu::Buffer> buffers_;
    std::unique_ptr<gpu::BufferSet> set_;
};

/// An array of plain values as a shader's input: of a span, of a vector. By the name that the shader has for it.
struct TwinInput {
    template <class Array>
    TwinInput(std::string_view buffer, const Array& array) : name(buffer), bytes(std::as_bytes(std::span(array))) {}
    std::string_view name;
    std::span<const std::byte> bytes;
};

/// A shader of tests/gpu, ready to run.
class Twin {
public:
    /// `scene`: borrowed.
    explicit Twin(std::string_view source, const gpu::BufferSet* scene = nullptr,
                  std::initializer_list<gpu::Specialization> constants = {})
        : Twin(source, scene, std::span(constants.begin(), constants.size())) {}
    Twin(std::string_view source, const gpu::BufferSet* scene, std::span<const gpu::Specialization> constants);

    /// One Out for each of `count` threads. Inputs may have any length.
    template <class Out>
    std::vector<Out> run(size_t count, std::initializer_list<TwinInput> inputs) const {
        std::vector<Out> out(count);
        run_bytes(count, inputs, std::as_writable_bytes(std::span(out)));
        return out;
    }

private:
    void run_bytes(size_t count, std::span<const TwinInput> inputs, std::span<std::byte> out) const;
    void run_bytes(size_t count, std::initializer_list<TwinInput> inputs, std::span<std::byte> out) const {
        run_bytes(count, std::span(inputs.begin(), inputs.size()), out);
    }

    gpu::ComputePipeline pipeline_;
};

/// A shader that is run once.
template <class Out>
std::vector<Out> run_twin(std::string_view source, size_t count, std::initializer_list<TwinInput> inputs,
                          const gpu::BufferSet* scene = nullptr) {
    return Twin(source, scene).run<Out>(count, inputs);
}

}  // namespace photond::test
