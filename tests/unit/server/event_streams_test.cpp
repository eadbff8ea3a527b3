// Event streams over plain sockets: events as they happen, and the daemon's status once a second to whoever listens to
// all of it.
#include "server/routes/event_streams.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>

#include <chrono>

namespace photond::http::event_streams_test {
namespace {

using std::chrono::steady_clock;

/// A client of streams that are up, with a status that counts how often it was asked for.
struct Streams {
    EventHub hub;
    std::atomic<int> asked{0}, clients{0};
    std::atomic<bool> broken{false};
    std::atomic<int64_t> connections{0}, exchanges{0};
    EventStreams streams{hub, [this](int delta) { clients += delta; },
                         [this] {
                             if (broken) throw Error(ErrorCode::Internal, "no status");
                             return nlohmann::json{{"asked", ++asked}};
                         }};

    Streams() {
        hub.open(1, {});
        streams.start();
    }

    /// The client's end of a stream; `job` empty: of the whole daemon.
    FileDescriptor listen(const std::string& job) {
        int ends[2];
        EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends), 0);
        auto connection = std::make_unique<Connection>(FileDescriptor(ends[0]), "test", connections);
        connection->exchange = std::make_unique<Exchange>(exchanges);
        connection->exchange->wire = ": listening\n\n";
        connection->exchange->reply.events = EventSubscription{job, hub.last_id(), ""};
        streams.adopt(std::move(connection));
        return FileDescriptor(ends[1]);
    }
};

/// Everything that comes until `end` has come or the stream is closed.
std::string read_until(const FileDescriptor& client, const std::string& end) {
    std::string text;
    while (text.find(end) == std::string::npos) {
        pollfd waiting{client.get(), POLLIN, 0};
        poll(&waiting, 1, -1);
        char bytes[4096];
        const ssize_t got = recv(client.get(), bytes, sizeof bytes, MSG_DONTWAIT);
        if (got > 0) text.append(bytes, static_cast<size_t>(got));
        if (got == 0) break;
    }
    return text;
}

TEST(EventStreams, TheWholeDaemonsHearItsStatusAndAJobsDoNot) {
    Streams daemon;
    const FileDescriptor job = daemon.listen("J1");
    read_until(job, "listening");
    daemon.hub.publish({1, "state", "J1", "{\"n\":1}"});
    EXPECT_EQ(read_until(job, "{\"n\":1}\n\n"), "event: state\nid: 1\ndata: {\"n\":1}\n\n");
    EXPECT_EQ(daemon.asked, 0) << "while nobody listens to the whole daemon, nobody asks";

    const auto begun = steady_clock::now();
    const FileDescriptor first = daemon.listen(""), second = daemon.listen("");
    const std::string text = read_until(first, "{\"asked\":2}\n\n");
    // Were it made for each client, the first would miss a number.
    EXPECT_EQ(text, ": listening\n\nevent: status\ndata: {\"asked\":1}\n\nevent: status\ndata: {\"asked\":2}\n\n");
    EXPECT_GE(steady_clock::now() - begun, std::chrono::seconds(2)) << "at most one a second";
    EXPECT_NE(read_until(second, "\"asked\":2").find("event: status"), std::string::npos);
    daemon.hub.publish({2, "state", "J1", "{\"n\":2}"});
    EXPECT_EQ(read_until(job, "{\"n\":2}\n\n"), "event: state\nid: 2\ndata: {\"n\":2}\n\n") << "nothing in between";
}

TEST(EventStreams, AStatusThatCannotBeToldStopsNoEvents) {
    Streams daemon;
    daemon.broken = true;
    const FileDescriptor client = daemon.listen("");
    read_until(client, "listening");
    std::this_thread::sleep_for(std::chrono::milliseconds(2500));
    daemon.hub.publish({1, "state", "J1", "{\"n\":1}"});
    EXPECT_EQ(read_until(client, "{\"n\":1}\n\n"), "event: state\nid: 1\ndata: {\"n\":1}\n\n");
    daemon.broken = false;
    EXPECT_NE(read_until(client, "\"asked\":1").find("event: status"), std::string::npos);
}

TEST(EventStreams, CountTheirClients) {
    Streams daemon;
    {
        const FileDescriptor client = daemon.listen("");
        read_until(client, "listening");
        EXPECT_EQ(daemon.clients, 1);
    }
    while (daemon.clients > 0) std::this_thread::sleep_for(std::chrono::milliseconds(10));
}

}  // namespace
}  // namespace photond::http::event_streams_test
