#include "clients/cli/event_stream.h"

namespace photond::cli {

std::vector<ServerEvent> EventParser::feed(std::string_view bytes) {
    std::vector<ServerEvent> events;
    for (const char c : bytes) {
        const bool second_of_pair = after_cr_ && c == '\n';
        after_cr_ = c == '\r';
        if (second_of_pair) continue;
        if (c == '\n' || c == '\r') {
            take_line(line_, events);
            line_.clear();
        } else {
            line_ += c;
        }
    }
    return events;
}

void EventParser::take_line(std::string_view line, std::vector<ServerEvent>& events) {
    if (line.empty()) {
        if (!data_.empty()) {
            data_.pop_back();  // the line feed after the last data line
            events.push_back({type_.empty() ? "message" : type_, data_});
        }
        type_.clear();
        data_.clear();
        return;
    }
    const size_t colon = line.find(':');
    if (colon == 0) return;  // a comment
    const std::string_view field = line.substr(0, colon);
    std::string_view value = colon == std::string_view::npos ? std::string_view() : line.substr(colon + 1);
    if (value.starts_with(' ')) value.remove_prefix(1);
    if (field == "event")
        type_ = value;
    else if (field == "data")
        data_.append(value).append("\n");
    else if (field == "id")
        last_event_id_ = value;
}

void EventParser::reconnect() {
    line_.clear();
    type_.clear();
    data_.clear();
    after_cr_ = false;
}

}  // namespace photond::cli
