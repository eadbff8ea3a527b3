// Events: one rising numbering, found again from memory and from the store, and a wake-up for the streaming thread.
#include "server/events.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

namespace photond::events_test {
namespace {

void publish(EventHub& hub, const std::string& job) { hub.publish({hub.next_id(), "state", job, "{}"}); }

std::vector<uint64_t> ids(const std::vector<Event>& events) {
    std::vector<uint64_t> result;
    for (const Event& event : events) result.push_back(event.id);
    return result;
}

TEST(EventHub, GivesWhatCameAfter) {
    EventHub hub;
    hub.open(10, {});
    EXPECT_EQ(hub.last_id(), 9u);
    for (const char* job : {"J1", "J2", "J1"}) publish(hub, job);
    EXPECT_EQ(ids(hub.after(9)), (std::vector<uint64_t>{10, 11, 12}));
    EXPECT_EQ(ids(hub.after(9, "J1")), (std::vector<uint64_t>{10, 12}));
    EXPECT_EQ(ids(hub.after(9, "", 2)), (std::vector<uint64_t>{10, 11}));
    EXPECT_TRUE(hub.after(12).empty());
    EXPECT_TRUE(hub.after(UINT64_MAX - 1).empty());
}

TEST(EventHub, AsksTheStoreForWhatMemoryNoLongerHolds) {
    EventHub hub;
    std::vector<std::pair<uint64_t, uint64_t>> asked;
    hub.open(100, [&](uint64_t after_id, uint64_t before_id, const std::string&, size_t limit) {
        asked.emplace_back(after_id, before_id);
        std::vector<Event> events;
        for (uint64_t id = after_id + 1; id < before_id && events.size() < limit; ++id)
            if (id % 10 == 0) events.push_back({id, "state", "J1", "{}"});
        return events;
    });
    publish(hub, "J1");
    EXPECT_EQ(ids(hub.after(75)), (std::vector<uint64_t>{80, 90, 100}));
    EXPECT_EQ(asked.size(), 1u);
    EXPECT_EQ(ids(hub.after(99)), (std::vector<uint64_t>{100}));
    EXPECT_EQ(asked.size(), 1u) << "memory holds all of it";

    for (int i = 0; i < 10'000; ++i) publish(hub, "J1");
    // Nothing is there twice or out of order where memory and store meet.
    uint64_t last = 105;
    size_t seen = 0;
    for (auto page = hub.after(last); !page.empty(); page = hub.after(last))
        for (const Event& event : page) {
            ASSERT_GT(event.id, last);
            last = event.id;
            ++seen;
        }
    EXPECT_EQ(last, hub.last_id());
    EXPECT_GT(seen, 4096u);
}

TEST(EventHub, WakesItsReaders) {
    EventHub hub;
    hub.open(1, {});
    const int news = hub.make_wake_fd(), also = hub.make_wake_fd();
    pollfd waiting{news, POLLIN, 0}, waiting_too{also, POLLIN, 0};
    EXPECT_EQ(poll(&waiting, 1, 0), 0);
    publish(hub, "J1");
    publish(hub, "J1");
    EXPECT_EQ(poll(&waiting, 1, 0), 1);
    uint64_t count = 0;
    EXPECT_EQ(read(news, &count, sizeof count), static_cast<ssize_t>(sizeof count));
    EXPECT_EQ(poll(&waiting, 1, 0), 0);
    EXPECT_EQ(poll(&waiting_too, 1, 0), 1) << "each by its own";
}

}  // namespace
}  // namespace photond::events_test
