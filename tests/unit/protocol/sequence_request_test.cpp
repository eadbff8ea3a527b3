// Sequences as the wire says them: which moments and views their frames have, and what is refused.

#include <gtest/gtest.h>

#include <cmath>

#include "protocol/camera_path.h"
#include "protocol/error.h"
#include "protocol/sequence.h"
#include "tests/support/job_vocabulary.h"

namespace photond::sequence_request_test {
namespace {

using nlohmann::json;

json smallest(json more) {
    json body = json::parse(R"({"scene": "s", "image": {"width": 8, "height": 8}, "method": {"name": "path_tracing"},
                                "stop": {"passes": 1}})");
    body.update(more);
    return body;
}
SequenceRequest read(const json& body) { return parse_sequence_request(body, test::job_vocabulary()); }

TEST(SequenceRequest, FramesAreMomentsOneAfterTheOther) {
    const SequenceRequest by_count = read(smallest({{"frames", 3}, {"fps", 10}, {"from", 2}, {"seed", 7u}}));
    ASSERT_EQ(by_count.frames.size(), 3u);
    for (uint32_t i = 0; i < 3; ++i) {
        EXPECT_DOUBLE_EQ(by_count.frames[i].time, 2 + 0.1 * i);
        EXPECT_EQ(by_count.frames[i].seed, 7u + i);
        EXPECT_EQ(by_count.frames[i].animation->index, 0u);
    }
    // The last moment is `to`, where it is one but for rounding.
    EXPECT_EQ(read(smallest({{"to", 1}})).frames.size(), 25u);
    EXPECT_EQ(read(smallest({{"to", 0.3}, {"fps", 10}})).frames.size(), 4u);
    EXPECT_EQ(read(smallest({{"to", 0.29}, {"fps", 10}})).frames.size(), 3u);
    EXPECT_EQ(read(smallest({{"to", 0}})).frames.size(), 1u);
    const SequenceRequest still = read(smallest({{"frames", 2}, {"noise", "still"}, {"animation", "walk"}}));
    EXPECT_EQ(still.frames[1].seed, still.frames[0].seed);
    EXPECT_EQ(still.frames[1].animation->name, "walk");
}

TEST(SequenceRequest, ATurntableGoesRoundItsTarget) {
    const json look_at = {{"eye", {3, 1, 0}}, {"target", {1, 0, 0}}};
    const SequenceRequest turn =
        read(smallest({{"frames", 4}, {"camera", {{"look_at", look_at}}}, {"camera_path", {{"turns", 1}}}}));
    const double expected[][3] = {{3, 1, 0}, {1, 1, -2}, {-1, 1, 0}, {1, 1, 2}};  // counter-clockwise from above
    for (int i = 0; i < 4; ++i) {
        const JobRequest& frame = turn.frames[static_cast<size_t>(i)];
        EXPECT_FALSE(frame.animation) << "along a path nothing else moves unless it is said";
        EXPECT_EQ(frame.time, 0);
        for (size_t k = 0; k < 3; ++k) EXPECT_NEAR(frame.camera.look_at->eye[k], expected[i][k], 1e-12) << i;
        EXPECT_EQ(frame.camera.look_at->target, (std::array<double, 3>{1, 0, 0}));
    }
}

TEST(SequenceRequest, APathGoesThroughItsKeysAndStopsAtItsEnds) {
    const auto key = [](double time, double x) {
        return json{{"time", time}, {"eye", {x, 0, 5}}, {"target", {x, 0, 0}}};
    };
    const SequenceRequest ride = read(smallest(
        {{"from", -1}, {"to", 4}, {"fps", 4}, {"camera_path", {{"keys", {key(0, 0), key(1, 2), key(3, 3)}}}}}));
    const auto x_at = [&](double time) {
        return ride.frames[static_cast<size_t>(std::lround((time + 1) * 4))].camera.look_at->eye[0];
    };
    EXPECT_EQ(x_at(-1), 0);
    EXPECT_EQ(x_at(0), 0);
    EXPECT_NEAR(x_at(1), 2, 1e-12);
    EXPECT_NEAR(x_at(3), 3, 1e-12);
    EXPECT_EQ(x_at(4), 3);
    // At the key in the middle the speed is (3 - 0) / (3 - 0) = 1: half of a second before, by Hermite's cubic.
    EXPECT_NEAR(x_at(0.5), 0.5 * 2 - 0.125 * 1, 1e-12);
    EXPECT_LT(x_at(0.25) - x_at(0), 0.5 * (x_at(0.5) - x_at(0.25))) << "it starts slowly";
}

TEST(SequenceRequest, AnAngleBetweenKeysIsOneThatALensCanHave) {
    const auto key = [](double time, double yfov) {
        return json{{"time", time}, {"eye", {0, 0, 5}}, {"target", {0, 0, 0}}, {"yfov", yfov}};
    };
    const SequenceRequest zoom =
        read(smallest({{"frames", 31},
                       {"fps", 10},
                       {"camera_path", {{"keys", {key(0, 0.01), key(1, 0.01), key(2, 3), key(3, 3)}}}}}));
    for (const JobRequest& frame : zoom.frames) EXPECT_EQ(fault_of_view(*frame.camera.look_at), "");
    const auto yfov = [&](size_t frame) { return zoom.frames[frame].camera.look_at->yfov; };
    EXPECT_NEAR(yfov(10), 0.01, 1e-12);
    EXPECT_NEAR(yfov(20), 3, 1e-12);
    EXPECT_LT(yfov(7), 0.01) << "it swings back first, as positions do";
    // Halfway the image is as much larger than at the one end as it is smaller than at the other.
    EXPECT_NEAR(std::tan(yfov(15) / 2), std::sqrt(std::tan(0.005) * std::tan(1.5)), 1e-9);
}

TEST(SequenceRequest, TheEchoIsAFixedPoint) {
    for (const json& more :
         {json{{"frames", 3}}, json{{"to", 0.5}, {"animation", "walk"}, {"shutter", 0.02}},
          json{{"frames", 2},
               {"camera", {{"look_at", {{"eye", {3, 1, 0}}, {"target", {1, 0, 0}}}}}},
               {"camera_path", {{"turns", -0.5}}}},
          json{{"frames", 2},
               {"camera_path",
                {{"keys", {{{"time", 0.5}, {"eye", {0, 0, 1}}, {"target", {0, 0, 0}}, {"yfov", 1.0}}}}}}}}) {
        const SequenceRequest once = read(smallest(more)), again = read(once.echo);
        EXPECT_EQ(once.echo.dump(), again.echo.dump());
        ASSERT_EQ(once.frames.size(), again.frames.size());
        for (size_t i = 0; i < once.frames.size(); ++i)
            EXPECT_EQ(to_json(once.frames[i]).dump(), to_json(again.frames[i]).dump());
    }
}

TEST(SequenceRequest, FaultsHaveTheirPlaces) {
    const json turning = {{"frames", 2}, {"camera_path", {{"turns", 1}}}};
    const auto seen = [](std::array<double, 3> eye, std::array<double, 3> target) {
        return json{{"eye", eye}, {"target", target}};
    };
    const auto along = [](auto... views) {  // a second from one to the next, 24 frames
        json keys = {views...};
        for (size_t i = 0; i < keys.size(); ++i) keys[i]["time"] = i;
        return json{{"to", keys.size() - 1}, {"camera_path", {{"keys", keys}}}};
    };
    const std::pair<json, std::string> cases[] = {
        {smallest(json::object()), "/frames"},
        {smallest({{"frames", 2}, {"to", 1}}), "/frames"},
        {smallest({{"frames", 0}}), "/frames"},
        {smallest({{"frames", 10'001}}), "/frames"},
        {smallest({{"to", 1000}}), "/to"},
        {smallest({{"to", -1}}), "/to"},
        {smallest({{"frames", 2}, {"fps", 0}}), "/fps"},
        {smallest({{"frames", 2}, {"time", 1}}), "/time"},
        {smallest({{"frames", 2}, {"first_pass", 1}}), "/first_pass"},
        {smallest({{"frames", 2}, {"noise", "loud"}}), "/noise"},
        {smallest({{"frames", 2}, {"framse", 2}}), "/framse"},
        {smallest({{"frames", 2}, {"animation", -1}}), "/animation"},
        {smallest(turning), "/camera/look_at"},
        {smallest({{"frames", 2}, {"camera_path", json::object()}}), "/camera_path"},
        {smallest({{"frames", 2}, {"camera_path", {{"keys", json::array()}}}}), "/camera_path/keys"},
        {smallest({{"frames", 2},
                   {"camera_path",
                    {{"keys",
                      {{{"time", 1}, {"eye", {0, 0, 1}}, {"target", {0, 0, 0}}},
                       {{"time", 1}, {"eye", {0, 0, 1}}, {"target", {0, 0, 0}}}}}}}}),
         "/camera_path/keys/1/time"},
        // Good keys, and between them a frame that no camera could take: the eye in its target, up along the view.
        {smallest(along(seen({0, 0, 1}, {0, 0, 0}), seen({0, 0, -1}, {0, 0, 0}))), "/camera_path/keys"},
        {smallest(along(seen({0, 0, 1}, {0, 0, 0}), seen({0, 2, -1}, {0, 0, 0}))), "/camera_path/keys"},
        {smallest(along(seen({9e11, 0, 0}, {0, 0, 0}), seen({1e12, 0, 0}, {0, 0, 0}), seen({1e12, 0, 0}, {0, 0, 0}))),
         "/camera_path/keys"},
        {smallest({{"frames", 4},
                   {"camera", {{"look_at", {{"eye", {0, 0, 1}}, {"target", {0, 0, 0}}, {"up", {1, 0, 0}}}}}},
                   {"camera_path", {{"turns", 1}}}}),
         "/camera_path/turns"},
        {smallest({{"frames", 2000}, {"fps", 1e-6}}), "/fps"},
        {smallest({{"frames", 100}, {"from", 1e9}}), "/frames"},
    };
    for (const auto& [body, pointer] : cases) try {
            read(body);
            ADD_FAILURE() << pointer << " is taken: " << body.dump();
        } catch (const Error& error) {
            ASSERT_FALSE(error.faults.empty()) << pointer;
            EXPECT_EQ(error.faults.front().pointer, pointer) << error.what();
        }
    const json nothing = json::array();
    EXPECT_THROW(read(nothing), Error);
    try {
        read(smallest(along(seen({0, 0, 1}, {0, 0, 0}), seen({0, 0, -1}, {0, 0, 0}))));
    } catch (const Error& error) {
        EXPECT_EQ(error.faults.size(), 1u);
        EXPECT_STREQ(error.what(), "gives frame 12, at 0.5 s, no view: target must differ from eye");
    }
}

}  // namespace
}  // namespace photond::sequence_request_test
