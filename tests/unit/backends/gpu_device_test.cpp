// What all GPU code stands on: memory and its accounts, barriers that follow from declared accesses, refusals that say
// why, times, and the pipeline cache.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <functional>
#include <numeric>

#include "renderer/backends/gpu/command_list.h"
#include "renderer/backends/gpu/group_sum.h"

#include "tests/support/gpu_twin.h"
#include "tests/support/temporary_folder.h"

namespace photond::gpu_device_test {
namespace {

using gpu::Buffer;
using gpu::read;
using gpu::read_write;
using gpu::write;

constexpr const char* kShift = "tests/gpu/shift.comp";
constexpr uint32_t kGroup = 64;

gpu::DeviceOptions options() { return {.id = test::gpu_device().report().id}; }

/// What an Error of that code says; empty where there is none.
std::string error_of(ErrorCode code, const std::function<void()>& run) {
    try {
        run();
    } catch (const Error& error) {
        EXPECT_EQ(error.code, code) << error.what();
        return error.what();
    }
    return "";
}
bool says(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(GpuDevice, UnknownIdsAreRefused) {
    const std::string text =
        error_of(ErrorCode::DeviceUnavailable, [] { const gpu::Device device(gpu::DeviceOptions{.id = "gpu:99"}); });
    EXPECT_TRUE(says(text, "gpu:99")) << text;
    EXPECT_TRUE(says(text, gpu::list_devices().back().id)) << text;
}

TEST(GpuDevice, MemoryIsAccountedByStructure) {
    gpu::Device device(options());
    gpu::Memory& memory = device.memory();
    EXPECT_EQ(memory.used_bytes(), 0);
    {
        const Buffer photons(device, "photons", 1000), more(device, "photons", 5000), grid(device, "grid", 64);
        const uint64_t photon_bytes = photons.memory_bytes() + more.memory_bytes();
        EXPECT_GE(photon_bytes, 6000);
        EXPECT_LT(photon_bytes, 6000 + 2 * 256) << "rounded up to the device's alignment";
        const std::map<std::string, uint64_t> expected{{"photons", photon_bytes}, {"grid", grid.memory_bytes()}};
        EXPECT_EQ(memory.structures(), expected);
        EXPECT_EQ(memory.used_bytes(), photon_bytes + grid.memory_bytes());
    }
    EXPECT_EQ(memory.used_bytes(), 0);
    EXPECT_TRUE(memory.structures().empty());
    EXPECT_GE(memory.peak_bytes(), 6064);
    memory.reset_peak();
    EXPECT_EQ(memory.peak_bytes(), 0);
}

TEST(GpuDevice, FreedMemoryIsUsedAgainAndGivenBack) {
    gpu::Device device(options());
    constexpr uint64_t kBytes = 200'000;
    {
        const Buffer kept(device, "kept", 4);
        std::vector<Buffer> buffers;
        for (int i = 0; i < 30; ++i) buffers.emplace_back(device, "piece", kBytes);
        const uint64_t blocks = device.memory().block_bytes();
        EXPECT_LT(blocks, 20u * 30 * kBytes) << "they share blocks";
        // Every other one goes; two neighbours' places together hold one of twice the size.
        for (size_t i = 10; i < 20; ++i) buffers[i] = Buffer();
        for (int i = 0; i < 5; ++i) buffers.emplace_back(device, "larger piece", 2 * kBytes);
        EXPECT_EQ(device.memory().block_bytes(), blocks);
        // No two lie over each other: each keeps what it was filled with.
        gpu::CommandList commands(device);
        std::vector<Buffer*> filled;
        for (Buffer& buffer : buffers)
            if (buffer) {
                commands.fill(buffer, static_cast<uint32_t>(filled.size()));
                filled.push_back(&buffer);
            }
        commands.submit();
        commands.wait();
        for (uint32_t i = 0; i < filled.size(); ++i) {
            const size_t words = filled[i]->bytes() / 4;
            EXPECT_EQ(gpu::read_back<uint32_t>(device, *filled[i], words), std::vector<uint32_t>(words, i));
        }
    }
    EXPECT_EQ(device.memory().block_bytes(), 0) << "blocks that hold nothing go back to the driver";
}

TEST(GpuDevice, LimitsAreToldWithBothFigures) {
    gpu::DeviceOptions small = options();
    small.memory_limit_bytes = 1'000'000;
    gpu::Device device(small);
    const Buffer held(device, "held", 600'064);
    std::string text = error_of(ErrorCode::OutOfMemory, [&] { const Buffer buffer(device, "photon_map", 500'000); });
    EXPECT_TRUE(says(text, "photon_map") && says(text, "500000 bytes") && says(text, "1000000 bytes")) << text;
    EXPECT_EQ(device.memory().used_bytes(), held.memory_bytes());

    const uint64_t range = device.limits().storage_buffer_range;
    text = error_of(ErrorCode::OutOfMemory, [&] { const Buffer buffer(device, "texels", range + 4); });
    EXPECT_TRUE(says(text, "texels") && says(text, std::to_string(range + 4) + " bytes") &&
                says(text, std::to_string(range) + " bytes"))
        << text;
}

/// Ten shifts to and fro, each of which must see all of what the last wrote, over lists and within them; by the
/// validation layers' synchronisation checks as well.
TEST(GpuDevice, DependentDispatchesWaitForEachOther) {
    gpu::Device& device = test::gpu_device();
    const gpu::ComputePipeline shift(device, kShift, sizeof(uint32_t));
    constexpr uint32_t kCount = 100'000, kShifts = 10;
    std::vector<uint32_t> start(kCount);
    std::iota(start.begin(), start.end(), 0u);
    Buffer a = gpu::make_buffer(device, "a", std::span<const uint32_t>(start)), b(device, "b", 4 * kCount),
           runs(device, "runs", 4 * kCount);
    gpu::CommandList first(device), second(device);
    first.fill(runs, 0);
    for (uint32_t i = 0; i < kShifts; ++i) {
        gpu::CommandList& commands = i < kShifts / 2 ? first : second;
        commands.bind(shift, {read("from", i % 2 ? b : a), write("to", i % 2 ? a : b), read_write("runs", runs)});
        commands.push(kCount);
        commands.dispatch_threads(kCount, kGroup);
    }
    second.copy(a, 0, b, 4 * (kCount / 2), 4 * (kCount / 2));
    first.submit();
    second.submit();
    second.wait();
    EXPECT_TRUE(first.done());
    const auto shifted = gpu::read_back<uint32_t>(device, a, kCount),
               copied = gpu::read_back<uint32_t>(device, b, kCount);
    EXPECT_EQ(gpu::read_back<uint32_t>(device, runs, kCount), std::vector<uint32_t>(kCount, kShifts));
    for (uint32_t i = 0; i < kCount; ++i) {
        ASSERT_EQ(shifted[i], start[(i + kShifts) % kCount] + kShifts);
        if (i >= kCount / 2) {
            ASSERT_EQ(copied[i], shifted[i - kCount / 2]);
        }
    }
}

TEST(GpuDevice, CountsWrittenByTheDeviceAreDispatched) {
    gpu::Device& device = test::gpu_device();
    const gpu::ComputePipeline shift(device, kShift, sizeof(uint32_t));
    constexpr uint32_t kCount = 3 * kGroup;
    Buffer from(device, "from", 4 * kCount), to(device, "to", 4 * kCount), runs(device, "runs", 4 * kCount),
        counts(device, "counts", 32);
    gpu::CommandList commands(device);
    for (Buffer* buffer : {&from, &to, &runs}) commands.fill(*buffer, 7);
    commands.update(counts, std::array<uint32_t, 8>{9, 9, 9, 9, 2, 1, 1, 9});
    commands.bind(shift, {read("from", from), write("to", to), read_write("runs", runs)});
    commands.push(kCount);
    commands.dispatch_indirect(counts, 16);
    commands.submit();
    commands.wait();
    std::vector<uint32_t> expected(kCount, 8);
    std::fill(expected.begin() + 2 * kGroup, expected.end(), 7u);
    EXPECT_EQ(gpu::read_back<uint32_t>(device, to, kCount), expected) << "two groups of the three";
}

/// Whatever the order of the list: each buffer is where the shader has its name.
TEST(GpuDevice, BuffersAreBoundByTheirNames) {
    gpu::Device& device = test::gpu_device();
    const gpu::ComputePipeline shift(device, kShift, sizeof(uint32_t));
    constexpr uint32_t kCount = kGroup;
    Buffer from(device, "from", 4 * kCount), to(device, "to", 4 * kCount), runs(device, "runs", 4 * kCount);
    std::array<int, 3> order{0, 1, 2};
    do {
        SCOPED_TRACE(testing::Message() << order[0] << order[1] << order[2]);
        const std::array<gpu::Binding, 3> all{read("from", from), write("to", to), read_write("runs", runs)};
        std::vector<gpu::Binding> bindings;
        for (const int i : order) bindings.push_back(all[static_cast<size_t>(i)]);
        gpu::CommandList commands(device);
        commands.fill(from, 7);
        commands.fill(to, 0);
        commands.fill(runs, 20);
        commands.bind(shift, bindings);
        commands.push(kCount);
        commands.dispatch_threads(kCount, kGroup);
        commands.submit();
        commands.wait();
        EXPECT_EQ(gpu::read_back<uint32_t>(device, from, kCount), std::vector<uint32_t>(kCount, 7));
        EXPECT_EQ(gpu::read_back<uint32_t>(device, to, kCount), std::vector<uint32_t>(kCount, 8));
        EXPECT_EQ(gpu::read_back<uint32_t>(device, runs, kCount), std::vector<uint32_t>(kCount, 21));
    } while (std::next_permutation(order.begin(), order.end()));
}

TEST(GpuDevice, BindingsThatAreNotTheShadersAreRefused) {
    gpu::Device& device = test::gpu_device();
    const gpu::ComputePipeline shift(device, kShift, sizeof(uint32_t));
    Buffer a(device, "a", 64), b(device, "b", 64), c(device, "c", 64), nothing;
    gpu::CommandList commands(device);
    const auto bound = [&](std::initializer_list<gpu::Binding> bindings) {
        return error_of(ErrorCode::Internal, [&] { commands.bind(shift, bindings); });
    };
    // Each text begins with the shader and names the buffer.
    const std::string buffer = std::string(kShift) + ", buffer ";
    EXPECT_EQ(bound({read("from", a), write("to", b)}), buffer + "runs: not bound");
    EXPECT_EQ(bound({}), buffer + "from: not bound");
    EXPECT_EQ(bound({read("from", a), write("to", b), write("run", c)}), buffer + "run: the shader has no such buffer");
    EXPECT_EQ(bound({read("from", a), write("to", b), read_write("runs", c), read("", a)}),
              buffer + ": the shader has no such buffer");
    EXPECT_EQ(bound({read("from", a), write("to", b), write("to", c)}), buffer + "to: bound twice");
    EXPECT_EQ(bound({read("from", a), write("to", b), read_write("runs", c), read("from", a)}),
              buffer + "from: bound twice");
    const std::string access = "the shader declares another access to ";
    EXPECT_EQ(bound({write("from", a), write("to", b), write("runs", c)}), buffer + "from: " + access + "a");
    EXPECT_EQ(bound({read("from", a), read("to", b), write("runs", c)}), buffer + "to: " + access + "b");
    EXPECT_EQ(bound({read("from", a), write("to", b), read("runs", c)}), buffer + "runs: " + access + "c");
    EXPECT_EQ(bound({read("from", a), write("to", nothing), write("runs", c)}), buffer + "to: no buffer");
    EXPECT_EQ(bound({read("from", a), write("to", b), read_write("runs", c)}), "");
    EXPECT_TRUE(says(error_of(ErrorCode::Internal, [&] { commands.push(uint64_t{1}); }), "8 bytes"));
    EXPECT_TRUE(says(error_of(ErrorCode::Internal, [&] { commands.dispatch(1, device.limits().workgroups[1] + 1); }),
                     "passes the device's limit"));
    EXPECT_TRUE(
        says(error_of(ErrorCode::Internal, [&] { const gpu::ComputePipeline none(device, "tests/gpu/none.comp", 0); }),
             "tests/gpu/none.comp"));
    EXPECT_TRUE(says(
        error_of(ErrorCode::Internal, [&] { const gpu::ComputePipeline none(device, "tests/gpu/unit_cross.comp", 4); }),
        "reads the scene"));
}

TEST(GpuDevice, ScopesAreTimedByTheDevice) {
    gpu::Device& device = test::gpu_device();
    ASSERT_GT(device.limits().timestamp_seconds, 0);
    const gpu::ComputePipeline shift(device, kShift, sizeof(uint32_t));
    constexpr uint32_t kMost = 1'000'000;
    Buffer from(device, "from", 4 * kMost), to(device, "to", 4 * kMost), runs(device, "runs", 4 * kMost);
    gpu::CommandList commands(device);
    for (Buffer* buffer : {&from, &runs}) commands.fill(*buffer, 0);
    for (const auto& [name, count] : {std::pair{"little", 64u}, std::pair{"much", kMost}, std::pair{"much", kMost}}) {
        const gpu::Scope scope(commands, name);
        commands.bind(shift, {read("from", from), write("to", to), read_write("runs", runs)});
        commands.push(count);
        commands.dispatch_threads(count, kGroup);
    }
    const double start = wall_now_seconds();
    commands.submit();
    commands.wait();
    const double wall = wall_now_seconds() - start;
    const std::vector<gpu::ScopeTime> times = commands.times();
    ASSERT_EQ(times.size(), 3);
    EXPECT_EQ(times[0].name, "little");
    EXPECT_EQ(times[2].name, "much");
    EXPECT_GT(times[1].seconds, 0);
    EXPECT_LE(times[0].seconds + times[1].seconds + times[2].seconds, wall);
    Stats stats;
    commands.add_times(stats);
    EXPECT_DOUBLE_EQ(stats.stage("much").gpu_seconds, times[1].seconds + times[2].seconds);
    EXPECT_DOUBLE_EQ(stats.stage("little").gpu_seconds, times[0].seconds);
}

/// Bytes of a device's pipeline cache now.
size_t cache_bytes(const gpu::Device& device) {
    size_t bytes = 0;
    device.vk().vkGetPipelineCacheData(device.handle(), device.pipeline_cache(), &bytes, nullptr);
    return bytes;
}

/// What is in it is the driver's: lavapipe puts a header alone.
TEST(GpuDevice, CompiledPipelinesAreKeptInTheirFile) {
    const TemporaryFolder folder;
    gpu::DeviceOptions cached = options();
    cached.pipeline_cache = folder.path() / "pipelines";
    size_t filled = 0;
    {
        gpu::Device device(cached);
        const gpu::ComputePipeline shift(device, kShift, sizeof(uint32_t));
        filled = cache_bytes(device);
    }
    EXPECT_EQ(std::filesystem::file_size(cached.pipeline_cache), filled);
    {
        gpu::Device device(cached);
        EXPECT_GE(cache_bytes(device), filled) << "what the first device compiled is there";
    }
    // Half a file, as a full disk could leave it: it is compiled anew, and written again.
    std::filesystem::resize_file(cached.pipeline_cache, 20);
    {
        gpu::Device device(cached);
        const gpu::ComputePipeline shift(device, kShift, sizeof(uint32_t));
    }
    EXPECT_GE(std::filesystem::file_size(cached.pipeline_cache), filled);
}

TEST(GpuDevice, APipelineIsCompiledOnceForAllThatAskForTheSame) {
    gpu::Device device(options());
    const auto reduce = [&](std::initializer_list<gpu::Specialization> constants) {
        return gpu::ComputePipeline(device, "renderer/backends/gpu/prefix_sum_reduce.comp", 32, nullptr, constants)
            .handle();
    };
    const gpu::Specialization group{GROUP_SIZE_CONSTANT, 64}, other_group{GROUP_SIZE_CONSTANT, 128};
    const VkPipeline first = reduce({group});
    EXPECT_EQ(reduce({group}), first) << "nobody used it in between";
    EXPECT_EQ(reduce({group, {7, 1}}), first) << "the shader has no such constant";
    EXPECT_NE(reduce({other_group}), first);
    EXPECT_NE(reduce({}), first);
    EXPECT_EQ(reduce({group}), first);
}

TEST(GpuDevice, TheOldestPipelinesAreLetGo) {
    gpu::Device device(options());
    gpu::KeptPipelines kept(device);
    size_t compiled = 0;
    const auto get = [&](size_t key) {
        const size_t before = compiled;
        kept.get(std::to_string(key), [&]() -> VkPipeline { return ++compiled, VK_NULL_HANDLE; });
        return compiled > before;
    };
    for (size_t key = 0; key < gpu::KeptPipelines::kMost; ++key) EXPECT_TRUE(get(key));
    EXPECT_FALSE(get(0)) << "all are kept";
    EXPECT_TRUE(get(gpu::KeptPipelines::kMost)) << "one too many";
    EXPECT_FALSE(get(0)) << "asked for since";
    EXPECT_TRUE(get(1)) << "the one used longest ago";
}

TEST(GpuDevice, ListsThatAreDroppedLeaveNothingUndone) {
    gpu::Device& device = test::gpu_device();
    const gpu::ComputePipeline shift(device, kShift, sizeof(uint32_t));
    constexpr uint32_t kCount = 100'000;
    Buffer a(device, "a", 4 * kCount), b(device, "b", 4 * kCount), runs(device, "runs", 4 * kCount);
    gpu::CommandList first(device), last(device);
    const auto record = [&](gpu::CommandList& commands, Buffer& from, Buffer& to) {
        commands.bind(shift, {read("from", from), write("to", to), read_write("runs", runs)});
        commands.push(kCount);
        commands.dispatch_threads(kCount, kGroup);
    };
    for (Buffer* buffer : {&a, &runs}) first.fill(*buffer, 0);
    record(first, a, b);
    first.submit();
    {
        gpu::CommandList dropped(device);
        record(dropped, b, a);
        dropped.reset();
        record(dropped, b, a);
    }
    record(last, b, a);
    last.submit();
    last.wait();
    EXPECT_EQ(gpu::read_back<uint32_t>(device, a, kCount), std::vector<uint32_t>(kCount, 2));
    EXPECT_EQ(gpu::read_back<uint32_t>(device, runs, kCount), std::vector<uint32_t>(kCount, 2));
}

TEST(GpuDevice, WhatListsCannotRecordIsRefused) {
    gpu::Device& device = test::gpu_device();
    const gpu::ComputePipeline shift(device, kShift, sizeof(uint32_t));
    constexpr uint32_t kCount = kGroup;
    Buffer a(device, "a", 4 * kCount), b(device, "b", 4 * kCount), runs(device, "runs", 4 * kCount),
        large(device, "large", 1 << 17);
    gpu::CommandList commands(device);
    const auto refused = [](const std::function<void()>& run) { return error_of(ErrorCode::Internal, run); };
    EXPECT_TRUE(says(refused([&] { commands.dispatch(1); }), "before anything was bound"));
    const std::vector<std::byte> bytes(65540);
    EXPECT_TRUE(says(refused([&] { commands.update(large, std::span(bytes)); }), "65540 bytes"));
    EXPECT_TRUE(says(refused([&] { commands.update(large, std::span(bytes).first(3)); }), "3 bytes"));
    for (Buffer* buffer : {&a, &b, &runs}) commands.fill(*buffer, 0);
    commands.bind(shift, {read("from", a), write("to", b), read_write("runs", runs)});
    EXPECT_NE(refused([&] { commands.bind(shift, {read("from", b), read("to", a), read_write("runs", runs)}); }), "");
    EXPECT_TRUE(says(refused([&] { commands.dispatch_threads((1ull << 31) + 1, kGroup); }), "threads"));
    commands.push(kCount);  // to what was bound before
    commands.dispatch_threads(kCount, kGroup);
    for (int i = 0; i < 512; ++i) const gpu::Scope scope(commands, "scope");
    EXPECT_TRUE(says(refused([&] { const gpu::Scope scope(commands, "scope"); }), "512 scopes"));
    commands.submit();
    EXPECT_TRUE(says(refused([&] { commands.submit(); }), "submitted already"));
    EXPECT_TRUE(says(refused([&] { commands.fill(a, 0); }), "submitted already"));
    commands.wait();
    EXPECT_EQ(commands.times().size(), 512);
    EXPECT_EQ(gpu::read_back<uint32_t>(device, b, kCount), std::vector<uint32_t>(kCount, 1));
    commands.reset();
    commands.fill(b, 5);
    commands.submit();
    commands.wait();
    EXPECT_EQ(gpu::read_back<uint32_t>(device, b, kCount), std::vector<uint32_t>(kCount, 5));
}

TEST(GpuDevice, TransfersPastABuffersEndAreRefused) {
    gpu::Device& device = test::gpu_device();
    Buffer buffer(device, "little", 16);
    std::vector<std::byte> bytes(20);
    std::string text = error_of(ErrorCode::Internal, [&] { gpu::upload(device, buffer, bytes); });
    EXPECT_TRUE(says(text, "little") && says(text, "16 bytes") && says(text, "20")) << text;
    text = error_of(ErrorCode::Internal, [&] { gpu::download(device, buffer, bytes); });
    EXPECT_TRUE(says(text, "little") && says(text, "16 bytes") && says(text, "20")) << text;
}

TEST(GpuDevice, SetsThatDoNotFitAreRefused) {
    gpu::Device& device = test::gpu_device();
    Buffer buffer(device, "buffer", 16), nothing;
    const std::vector<Buffer*> with_hole{&buffer, &nothing};
    EXPECT_TRUE(says(error_of(ErrorCode::Internal, [&] { const gpu::BufferSet set(device, "the set", with_hole); }),
                     "the set, binding 1: no buffer"));
    // Software devices take few buffers: 20 of the scene's leave 12.
    if (device.limits().storage_buffers > 1000) GTEST_SKIP() << "this device takes any number of buffers";
    const gpu::BufferSet most(device, "most", std::vector<Buffer*>(device.limits().storage_buffers - 2, &buffer));
    const std::string text = error_of(
        ErrorCode::Internal, [&] { const gpu::ComputePipeline shift(device, kShift, sizeof(uint32_t), &most); });
    EXPECT_TRUE(says(text, kShift) && says(text, std::to_string(device.limits().storage_buffers + 1))) << text;
}

}  // namespace
}  // namespace photond::gpu_device_test
