#pragma once
// Which passes an image holds, so that parts of it rendered apart can be joined and none is counted twice.

#include <cstdint>
#include <string>
#include <vector>

namespace photond {

/// Half-open ranges of pass indices, rising and apart from each other.
class PassRanges {
public:
    struct Range {
        uint32_t first = 0, end = 0;
        bool operator==(const Range&) const = default;
    };
    PassRanges() = default;
    /// Throws ErrorCode::Internal when the ranges overlap, touch, are empty or do not rise.
    explicit PassRanges(std::vector<Range> ranges);

    /// The pass must not be in it (asserted).
    void add(uint32_t pass);
    /// Throws ErrorCode::Conflict, naming the first pass that is in both; nothing has changed then.
    void add(const PassRanges& other);
    uint32_t count() const;
    uint32_t end() const { return ranges_.empty() ? 0 : ranges_.back().end; }  // behind the last
    const std::vector<Range>& ranges() const { return ranges_; }
    /// "0-63, 128-191"; "none".
    std::string text() const;
    bool operator==(const PassRanges&) const = default;

private:
    std::vector<Range> ranges_;
};

}  // namespace photond
