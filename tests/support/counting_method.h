#pragma once
// A method for tests of the loop over passes: its pixels say which passes were added, and it says what it was told.

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <string>
#include <thread>

#include "renderer/core/cancel.h"
#include "renderer/frame/method.h"

namespace photond::test {

class NoIntersector final : public Intersector {
public:
    Hit closest_hit(const Ray&) const override { return {}; }
    bool occluded(const Ray&) const override { return false; }
    void closest_hits(std::span<const Ray>, std::span<Hit>, Coherence) const override {}
    void occluded(std::span<const Ray>, std::span<uint8_t>, Coherence) const override {}
    uint64_t bytes() const override { return 0; }
};

/// A method whose pass p is p + 1 everywhere and takes a stated time; it can be told to cancel itself within a pass.
class CountingMethod final : public Method {
public:
    std::chrono::milliseconds begin_time{0}, pass_time{0};
    CancelToken* cancel_in_pass = nullptr;
    std::function<void(Stats& stats, const CancelToken& cancel)> in_pass;
    uint32_t cancel_pass = 0;
    uint32_t passes_run = 0;
    bool began = false;
    std::string said;  // what the loop said: eN for expect_pass(N), r for end_pass(), s for settle()

    void begin(const RenderContext& context, Stats&) override {
        began = true;
        image_ = PassImage(context.view.film_size, context.view.layers);
        std::this_thread::sleep_for(begin_time);
    }
    void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) override {
        EXPECT_EQ(pass, passes_run);
        ++passes_run;
        if (in_pass) in_pass(stats, cancel);
        std::this_thread::sleep_for(pass_time);
        image_.of<Layer::Direct>().assign(image_.of<Layer::Direct>().size(), Rgb(static_cast<float>(pass + 1)));
        if (cancel_in_pass && pass == cancel_pass) cancel_in_pass->cancel();
    }
    void expect_pass(uint32_t pass) override { said += "e" + std::to_string(pass); }
    void settle() override {
        said += "s";
        if (on_settle) on_settle();
        std::this_thread::sleep_for(settle_time);
    }
    PassImage* end_pass() override {
        said += "r";
        return &image_;
    }
    std::chrono::milliseconds settle_time{0};
    std::function<void()> on_settle;

private:
    PassImage image_;
};

}  // namespace photond::test
