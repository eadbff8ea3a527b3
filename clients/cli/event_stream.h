#pragma once
// Server-sent events (WHATWG HTML, section 9.2.6), as far as the daemon uses them.

#include <string>
#include <string_view>
#include <vector>

namespace photond::cli {

struct ServerEvent {
    std::string type;  // "message" where the stream names none
    std::string data;
};

/// Takes a stream in pieces cut anywhere.
class EventParser {
public:
    /// The events that `bytes` complete. Comments (heartbeats) complete none.
    std::vector<ServerEvent> feed(std::string_view bytes);
    /// The last id seen: what `Last-Event-ID` resumes from; empty before the first.
    const std::string& last_event_id() const { return last_event_id_; }
    /// A new connection starts on a clean line; the id is kept.
    void reconnect();

private:
    void take_line(std::string_view line, std::vector<ServerEvent>& events);

    std::string line_;
    bool after_cr_ = false;  // a line feed now belongs to the line end already taken
    std::string type_;
    std::string data_;
    std::string last_event_id_;
};

}  // namespace photond::cli
