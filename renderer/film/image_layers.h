#pragma once
// Which channels of an image belong together.

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace photond {

/// A layer as the names of an image's channels tell it.
struct NamedLayer {
    std::string name;
    std::vector<size_t> channels;  // indices into the image's, in the order in which they are interleaved
};

/// What is before a channel's last dot names its layer, "beauty" where there is none. A layer is R, G and B, or X, Y
/// and Z, or Y alone, or Z alone, the first of these that there is; what has no name is light, R, G and B or Y.
/// Channels of other names, alpha among them, are of no layer. The beauty is first, then as the channels stand; of two
/// layers of one name the first counts.
std::vector<NamedLayer> layers_of_channels(std::span<const std::string> channel_names);

}  // namespace photond
