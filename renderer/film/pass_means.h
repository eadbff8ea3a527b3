#pragma once
// What passes say of the mean over an image. Within a pass pixels share photons, lights and a sequence's points: only
// between passes does it show how far such a mean is known.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "renderer/film/fixed_sums.h"

namespace photond {

/// By channel, over passes, the exact sums of each pass's mean over the pixels (a multiple of 2^-64) and of its square.
/// Whole numbers: any order of passes and any cut into parts gives the same bits.
class PassMeans {
public:
    using Sum = std::array<FixedSum, 3>;  // over an image's pixels, R G B
    enum class Of : uint8_t { Beauty, Direct, Indirect };

    /// A pass, by its sums over `pixels` > 0 pixels.
    void add(const Sum& emitted, const Sum& direct, const Sum& indirect, uint64_t pixels);
    /// The passes of another, which are not in this one.
    void merge(const PassMeans& other);

    /// How many passes are in it. Fewer than the film's where some of those come from a file of a version before 6,
    /// which says nothing of them.
    uint32_t passes() const { return passes_; }
    /// Unbiased variance, between the passes in it, of one pass's mean; nothing for fewer than two.
    std::optional<std::array<double, 3>> variance(Of image) const;

    /// As it lies in a film's file, little-endian.
    std::string bytes() const;
    /// Nothing where they are not as many as bytes() gives.
    static std::optional<PassMeans> from_bytes(std::string_view bytes);

    bool operator==(const PassMeans&) const = default;

private:
    /// Calls visitor(number) for each number that means keep.
    template <class Means, class Visitor>
    static void for_each_number(Means& means, const Visitor& visitor);

    struct Channel {
        FixedSum sum = 0;
        WideSquares squares;
        void add(FixedSum mean);
        bool operator==(const Channel&) const = default;
    };
    uint32_t passes_ = 0;
    std::array<std::array<Channel, 3>, 3> channels_;  // by Of
};

}  // namespace photond
