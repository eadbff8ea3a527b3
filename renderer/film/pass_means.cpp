#include "renderer/film/pass_means.h"

#include <cassert>
#include <cstring>

namespace photond {

void PassMeans::Channel::add(FixedSum mean) {
    sum += mean;
    squares += exact_square(mean);
}

void PassMeans::add(const Sum& emitted, const Sum& direct, const Sum& indirect, uint64_t pixels) {
    assert(pixels > 0 && "an image of no pixels has no mean");
    const auto count = static_cast<FixedSum>(pixels);
    for (size_t k = 0; k < 3; ++k) {
        channels_[0][k].add((emitted[k] + direct[k] + indirect[k]) / count);
        channels_[1][k].add(direct[k] / count);
        channels_[2][k].add(indirect[k] / count);
    }
    ++passes_;
}

void PassMeans::merge(const PassMeans& other) {
    for (size_t image = 0; image < channels_.size(); ++image)
        for (size_t k = 0; k < 3; ++k) {
            channels_[image][k].sum += other.channels_[image][k].sum;
            channels_[image][k].squares += other.channels_[image][k].squares;
        }
    passes_ += other.passes_;
}

std::optional<std::array<double, 3>> PassMeans::variance(Of image) const {
    if (passes_ < 2) return std::nullopt;
    std::array<double, 3> result;
    for (size_t k = 0; k < 3; ++k) {
        const Channel& channel = channels_[static_cast<size_t>(image)][k];
        result[k] = variance_of(channel.sum, times(channel.squares, passes_), passes_);
    }
    return result;
}

template <class Means, class Visitor>
void PassMeans::for_each_number(Means& means, const Visitor& visitor) {
    visitor(means.passes_);
    for (auto& image : means.channels_)
        for (auto& channel : image) visitor(channel.sum), visitor(channel.squares.low), visitor(channel.squares.high);
}

std::string PassMeans::bytes() const {
    std::string bytes;
    for_each_number(*this,
                    [&](const auto& number) { bytes.append(reinterpret_cast<const char*>(&number), sizeof number); });
    return bytes;
}

std::optional<PassMeans> PassMeans::from_bytes(std::string_view bytes) {
    PassMeans means;
    if (bytes.size() != means.bytes().size()) return std::nullopt;
    for_each_number(means, [&](auto& number) {
        std::memcpy(&number, bytes.data(), sizeof number);
        bytes.remove_prefix(sizeof number);
    });
    return means;
}

}  // namespace photond
