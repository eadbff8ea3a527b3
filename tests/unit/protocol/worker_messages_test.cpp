// How an Error crosses the socket.

#include "protocol/worker_messages.h"

#include <gtest/gtest.h>

namespace photond::worker_messages_test {
namespace {

using nlohmann::json;

TEST(FailureJson, KeepsCodeAndFaults) {
    const Error error(ErrorCode::OutOfRange, "/image/width", "too wide");
    EXPECT_EQ(failure_json(error), json({{"code", "out_of_range"},
                                         {"detail", "too wide"},
                                         {"errors", {{{"pointer", "/image/width"}, {"detail", "too wide"}}}}}));
}

}  // namespace
}  // namespace photond::worker_messages_test
