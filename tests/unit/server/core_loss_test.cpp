// To whom a job lost processor time, and the sentence about it.

#include "server/core_loss.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "server/service/process_meter.h"

namespace photond::core_loss_test {
namespace {

using nlohmann::json;

CoreUse use_of(double had, double waited, double outside, double clock) {
    CoreUse use = CoreUse::of_nothing();
    use.processor_seconds = had;
    use.run_delay_seconds = waited;
    use.host_busy_outside_seconds = outside;
    use.derive(clock, 2);
    return use;
}

TEST(CoreLoss, OthersAreWhatIsLeft) {
    const std::vector<LostTo> to = CoreLoss::of(use_of(6, 2, 4, 4), {{"helper", 1}, {"job J12", 0.01}})->to;
    ASSERT_EQ(to.size(), 2u) << "a hundredth is too little to be named";
    EXPECT_EQ(to[0].who, "others");
    EXPECT_DOUBLE_EQ(to[0].seconds, 2 * 2.99 / 4);
    EXPECT_EQ(to[1].who, "helper");
    EXPECT_DOUBLE_EQ(to[1].seconds, 0.5);
}

TEST(CoreLoss, OursAreBlamedForNoMoreThanWasLost) {
    // They are read over more than the clock: here they took more than ran outside while it ran.
    const std::vector<LostTo> to = CoreLoss::of(use_of(6, 2, 2, 4), {{"helper", 3}, {"job J12", 1}})->to;
    ASSERT_EQ(to.size(), 2u);
    EXPECT_EQ(to[0].who, "helper");
    EXPECT_DOUBLE_EQ(to[0].seconds, 1.5);
    EXPECT_DOUBLE_EQ(to[1].seconds, 0.5);
}

TEST(CoreLoss, AJobIsDisturbedBelowNinetyEightPercent) {
    EXPECT_TRUE(to_json(CoreLoss::of(use_of(98, 2, 2, 50), {})).is_null());
    EXPECT_TRUE(to_json(CoreLoss::of(use_of(0.01, 0.009, 0.009, 0.01), {})).is_null()) << "less than a tick";
    const json shared = to_json(CoreLoss::of(use_of(97.9, 2.1, 50, 50), {}));
    EXPECT_DOUBLE_EQ(shared["share"], 0.979);
    EXPECT_DOUBLE_EQ(shared["lost_seconds"], 2.1);
    EXPECT_EQ(shared["to"], json::parse(R"([{"who": "others", "seconds": 2.1}])"));
    EXPECT_EQ(shared["warning"],
              "2.1 s of its processor time (2 %) were lost to others: its clock cannot be compared; run it again.");
}

TEST(CoreLoss, TheSentenceNamesThoseWhoTookMuch) {
    CoreLoss loss{0.8, 2, 1, {{"others", 1.5}, {"job J12", 0.4}, {"helper", 0.1}}};
    EXPECT_EQ(loss.warning(),
              "2 s of its processor time (20 %) were lost to others (1.5 s) and job J12 (400 ms): its clock cannot be "
              "compared; run it again.");
    EXPECT_EQ(loss.what(), "2 s of its processor time (20 %) to others (1.5 s) and job J12 (400 ms)");
    loss.to = {{"helper", 1.9}, {"others", 0.1}};
    EXPECT_EQ(loss.what(), "2 s of its processor time (20 %) to our helper");
    const CoreLoss read = CoreLoss::of_statistics({{"shared", to_json(std::optional(loss))}}).value();
    EXPECT_EQ(to_json(std::optional(read)), to_json(std::optional(loss)));
    EXPECT_FALSE(CoreLoss::of_statistics({{"shared", nullptr}}) || CoreLoss::of_statistics(nullptr));
}

TEST(CoreLoss, WhatTheKernelDoesNotSayIsNobodysFault) {
    CoreUse use;
    use.derive(1, 2);
    EXPECT_FALSE(CoreLoss::of(use, {{"helper", 1}}));
    use.run_delay_seconds = 3;  // but not what ran outside
    use.derive(1, 2);
    EXPECT_EQ(to_json(CoreLoss::of(use, {}))["to"], json::parse(R"([{"who": "others", "seconds": 3.0}])"));
}

TEST(ProcessMeter, ChargesWhatWasTakenSinceTheLastReading) {
    ProcessMeter meter;
    const ProcessorSeconds first = meter.read({{"photond", getpid()}, {"helper", -1}});
    EXPECT_GT(first.at("photond"), 0);
    EXPECT_FALSE(first.contains("helper"));
    volatile double work = 1;
    for (int i = 0; i < 1'000'000; ++i) work = work * 1.0000001;
    const ProcessorSeconds second = meter.read({{"job J1", getpid()}});
    EXPECT_GT(second.at("job J1"), 0);
    EXPECT_LT(second.at("job J1"), first.at("photond") + 1);
}

}  // namespace
}  // namespace photond::core_loss_test
