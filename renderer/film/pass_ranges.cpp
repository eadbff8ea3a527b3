#include "renderer/film/pass_ranges.h"

#include <algorithm>
#include <cassert>

#include "protocol/error.h"

namespace photond {

PassRanges::PassRanges(std::vector<Range> ranges) : ranges_(std::move(ranges)) {
    for (size_t i = 0; i < ranges_.size(); ++i)
        if (ranges_[i].first >= ranges_[i].end || (i > 0 && ranges_[i].first <= ranges_[i - 1].end))
            throw Error(ErrorCode::Internal, "ranges of passes that are empty, touch or do not rise");
}

void PassRanges::add(uint32_t pass) {
    if (!ranges_.empty() && ranges_.back().end == pass) {
        ++ranges_.back().end;
        return;
    }
    add(PassRanges({{pass, pass + 1}}));
}

void PassRanges::add(const PassRanges& other) {
    std::vector<Range> all = ranges_;
    all.insert(all.end(), other.ranges_.begin(), other.ranges_.end());
    std::sort(all.begin(), all.end(), [](const Range& a, const Range& b) { return a.first < b.first; });
    std::vector<Range> joined;
    for (const Range& range : all) {
        if (!joined.empty() && range.first < joined.back().end)
            throw Error(ErrorCode::Conflict, "pass " + std::to_string(range.first) + " is in both");
        if (!joined.empty() && range.first == joined.back().end)
            joined.back().end = range.end;
        else
            joined.push_back(range);
    }
    ranges_ = std::move(joined);
}

uint32_t PassRanges::count() const {
    uint32_t passes = 0;
    for (const Range& range : ranges_) passes += range.end - range.first;
    return passes;
}

std::string PassRanges::text() const {
    std::string text;
    for (const Range& range : ranges_) {
        text += (text.empty() ? "" : ", ") + std::to_string(range.first);
        if (range.end - range.first > 1) text.append("-").append(std::to_string(range.end - 1));
    }
    return text.empty() ? "none" : text;
}

}  // namespace photond
