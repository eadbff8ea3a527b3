#pragma once
// Parallel sweeps over pixels whose results do not depend on the number of threads: the chunks are fixed.

#include <algorithm>
#include <cstddef>
#include <vector>

#include "renderer/core/parallel.h"

namespace photond {

inline constexpr size_t kPixelChunk = 4096;

/// Calls body(first, last) for consecutive ranges that make up [0, count).
template <class Body>
void for_each_chunk(size_t count, const Body& body) {
    parallel_for((count + kPixelChunk - 1) / kPixelChunk, 1,
                 [&](size_t chunk) { body(chunk * kPixelChunk, std::min(count, (chunk + 1) * kPixelChunk)); });
}

/// The sum (+=) of what sums_of(first, last) gives for those ranges, added in their order.
template <class Sums, class SumsOf>
Sums sum_of_chunks(size_t count, const SumsOf& sums_of) {
    std::vector<Sums> parts((count + kPixelChunk - 1) / kPixelChunk);
    for_each_chunk(count, [&](size_t first, size_t last) { parts[first / kPixelChunk] = sums_of(first, last); });
    Sums total{};
    for (const Sums& part : parts) total += part;
    return total;
}

}  // namespace photond
