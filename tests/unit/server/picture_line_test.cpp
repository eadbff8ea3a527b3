// Which picture is drawn next while a job renders, and when.

#include "server/service/picture_line.h"

#include <gtest/gtest.h>

namespace photond {
namespace {

using std::chrono::seconds;

constexpr unsigned kProcessors = 2;
const PictureLine::Clock::time_point kNow{std::chrono::hours(1)};

Artefact nothing() { return {}; }

TEST(PictureLine, IsFirstComeFirstServed) {
    PictureLine line(kProcessors);
    EXPECT_EQ(line.next(kNow, true), nullptr);
    const auto first = line.want("a", nothing, kNow), second = line.want("b", nothing, kNow);
    EXPECT_EQ(line.waiting(), 2u);
    EXPECT_EQ(line.next(kNow, true), first);
    first->over = true;
    EXPECT_EQ(line.waiting(), 1u);
    EXPECT_EQ(line.next(kNow, true), second);
    line.remove(*second);
    EXPECT_EQ(line.next(kNow, true), nullptr);
}

TEST(PictureLine, WhoeverWantsTheSameSharesIt) {
    PictureLine line(kProcessors);
    const auto picture = line.want("a", nothing, kNow);
    EXPECT_EQ(line.want("a", nothing, kNow), picture);
    EXPECT_EQ(line.waiting(), 1u);
    picture->over = true;  // and is there to be fetched
    EXPECT_EQ(line.want("a", nothing, kNow), picture);
    line.remove(*picture);
    EXPECT_NE(line.want("a", nothing, kNow), picture);
}

TEST(PictureLine, TakesAShareOfTheProcessors) {
    PictureLine line(kProcessors);
    line.want("a", nothing, kNow);
    ASSERT_NE(line.next(kNow, true), nullptr);
    const double processor_seconds = 0.4;
    line.note(kNow, processor_seconds);
    const double pause = processor_seconds / (PictureLine::kPictureShare * kProcessors);
    EXPECT_DOUBLE_EQ(pause, 10);
    EXPECT_EQ(line.next(kNow + seconds(9), true), nullptr);
    EXPECT_NE(line.next(kNow + seconds(9), false), nullptr) << "nobody is disturbed";
    EXPECT_NE(line.next(kNow + seconds(10), true), nullptr);
}

TEST(PictureLine, ForgetsWhatNobodyAsksForAgain) {
    PictureLine line(kProcessors);
    line.want("a", nothing, kNow);
    const auto asked_again = line.want("b", nothing, kNow);
    line.want("b", nothing, kNow + seconds(15));
    EXPECT_EQ(line.next(kNow + PictureLine::kForgotten + seconds(1), true), asked_again);
    EXPECT_EQ(line.waiting(), 1u);
    EXPECT_EQ(line.next(kNow + seconds(60), true), nullptr);
    EXPECT_EQ(line.waiting(), 0u);
}

TEST(PictureLine, HasAnEnd) {
    PictureLine line(kProcessors);
    for (size_t i = 0; i < PictureLine::kLongest; ++i) EXPECT_NE(line.want(std::to_string(i), nothing, kNow), nullptr);
    EXPECT_EQ(line.want("one more", nothing, kNow), nullptr);
    EXPECT_NE(line.want("0", nothing, kNow + seconds(15)), nullptr) << "it is in line";
    EXPECT_NE(line.want("one more", nothing, kNow + PictureLine::kForgotten + seconds(1)), nullptr);
    EXPECT_EQ(line.waiting(), 2u);
}

}  // namespace
}  // namespace photond
