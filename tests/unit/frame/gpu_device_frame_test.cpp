// A device frame: which of its steps are submitted together, and which passes are made. What becomes of cancelled
// passes and what order passes may come in is tested with the methods.

#include <gtest/gtest.h>

#include <bit>

#include "protocol/error.h"
#include "renderer/frame/device_frame.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/gpu_render.h"

namespace photond::gpu_device_frame_test {
namespace {

constexpr Size2 kSize{5, 3};

class GpuDeviceFrame : public testing::Test {
protected:
    RenderContext context(MemoryBudget& budget) {
        return {scene_, &where_.intersector, {find_camera(scene_, ""), kSize}, 1, budget, &where_.device_scene};
    }

    const Scene scene_ = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where_{scene_};
    MemoryBudget budget_;
    Stats stats_;
};

TEST_F(GpuDeviceFrame, SubmitsAsManyStepsTogetherAsASubmitHolds) {
    const uint64_t most = test::gpu_device().paths_per_submit();
    const std::vector<uint64_t> paths = {0, most, 0, 1, most - 1, 1, 2 * most, 0};
    std::vector<const gpu::CommandList*> lists;  // by step; one submit's is not the next one's
    DeviceFrame frame(context(budget_), [&](uint32_t, DeviceFrame::Steps& steps) {
        for (const uint64_t of_step : paths)
            steps.push_back({of_step, [&lists](gpu::CommandList& commands) { lists.push_back(&commands); }});
    });
    ASSERT_TRUE(frame.run(0, stats_, CancelToken{}));
    ASSERT_EQ(lists.size(), paths.size());
    std::vector<int> submits = {0};
    for (size_t i = 1; i < lists.size(); ++i) submits.push_back(submits.back() + (lists[i] != lists[i - 1]));
    EXPECT_EQ(submits, (std::vector<int>{0, 0, 0, 1, 1, 2, 3, 4}));
}

TEST_F(GpuDeviceFrame, MakesAPassOnceThatWasExpectedAndAnewThatWasNot) {
    std::vector<uint32_t> asked;
    DeviceFrame* made = nullptr;
    DeviceFrame frame(context(budget_), [&](uint32_t pass, DeviceFrame::Steps& steps) {
        asked.push_back(pass);
        steps.push_back({0, [&, pass](gpu::CommandList& commands) {
                             commands.fill(made->image().layers(), std::bit_cast<uint32_t>(1 + float(pass)));
                             made->image().record_readback(commands);
                         }});
    });
    made = &frame;
    const auto radiance_of = [&](uint32_t pass) {  // emitted, direct and indirect light
        Film film(kSize, LayerSet());
        EXPECT_TRUE(frame.run(pass, stats_, CancelToken{}));
        frame.read(stats_);
        film.add_pass(*frame.end_pass());
        return test::mean_of(film.resolve_beauty());
    };
    frame.expect_pass(3);
    frame.expect_pass(3);
    frame.settle();
    EXPECT_EQ(radiance_of(3), 3 * 4);
    EXPECT_EQ(asked, (std::vector<uint32_t>{3}));
    EXPECT_EQ(radiance_of(3), 3 * 4);
    frame.expect_pass(4);
    EXPECT_EQ(radiance_of(2), 3 * 3);
    EXPECT_EQ(radiance_of(4), 3 * 5);
    EXPECT_EQ(asked, (std::vector<uint32_t>{3, 3, 4, 2, 4}));
    frame.expect_pass(5);
    frame.end();  // while it is under way
}

TEST_F(GpuDeviceFrame, TakesTheMemoryItSays) {
    const Workload workload{.film_size = kSize};
    const uint64_t host_bytes = DeviceFrame::estimate_bytes(workload);
    const auto no_steps = [](uint32_t, DeviceFrame::Steps&) {};
    const uint64_t before = test::gpu_device().memory().used_bytes();
    const DeviceFrame frame(context(budget_), no_steps);
    EXPECT_EQ(budget_.structures(), (std::map<std::string, uint64_t>{{"pass_image", host_bytes}}));
    EXPECT_GE(test::gpu_device().memory().used_bytes() - before, DeviceFrame::estimate_device_bytes(workload));
    MemoryBudget small(host_bytes - 1);
    EXPECT_THROW(DeviceFrame(context(small), no_steps), Error);
}

}  // namespace
}  // namespace photond::gpu_device_frame_test
