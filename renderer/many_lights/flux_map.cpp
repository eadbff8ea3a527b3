#include "renderer/many_lights/flux_map.h"

#include "renderer/core/hilbert.h"
#include "renderer/transport/sobol.h"

namespace photond {

namespace {

/// Divides a number, in fractions of 2^32, between two by their weights and stretches what the chosen one has to the
/// whole again. The probability is multiplied by the share that was really used. True: the second.
bool divide(float first, float second, uint32_t& u, float& probability) {
    if (!(second > 0)) return false;
    if (!(first > 0)) return true;
    constexpr float kMostShare = 4294967040.0f;  // the last float below 2^32
    const auto share = static_cast<uint32_t>(glm::clamp(first / (first + second) * 4294967296.0f, 1.0f, kMostShare));
    const bool is_second = u >= share;
    const uint32_t mine = is_second ? 0u - share : share;
    u = static_cast<uint32_t>((uint64_t{is_second ? u - share : u} << 32) / mine);
    probability *= static_cast<float>(mine) * 0x1p-32f;
    return is_second;
}

}  // namespace

FluxMap::FluxMap(uint32_t levels) : levels_(levels), sums_(values(levels)) {}

void FluxMap::sum() {
    constexpr float kMostWorth = 1e30f;
    for (float& value : worth()) value = value > 0 && value < kInfinity ? std::min(value, kMostWorth) : 0.0f;
    const float* below = sums_.data();
    float* next = sums_.data() + texels();
    for (uint32_t count = texels() / 4; count > 0; count /= 4)
        for (uint32_t i = 0; i < count; ++i, below += 4) *next++ = (below[0] + below[1]) + (below[2] + below[3]);
}

Texel FluxMap::choose(uvec2 point) const {
    Texel texel{.index = 0, .probability = 1};
    HilbertSquare square;
    const float* level = sums_.data() + sums_.size() - 1;
    for (uint32_t count = 4; count <= texels(); count *= 4) {  // of the level's squares
        level -= count;
        const float* of_four = level + 4 * texel.index;
        const auto worth_of = [&](uint32_t x, uint32_t y) { return of_four[square.child({x, y})]; };
        const uint32_t y =
            divide(worth_of(0, 0) + worth_of(1, 0), worth_of(0, 1) + worth_of(1, 1), point.y, texel.probability);
        const uint32_t x = divide(worth_of(0, y), worth_of(1, y), point.x, texel.probability);
        const uint32_t child = square.child({x, y});
        texel.index = 4 * texel.index + child;
        square = square.below(child);
    }
    return texel;
}

uvec2 rotated_halton_point(uint32_t i, const uvec2& rotation) {
    constexpr uint32_t kDigits = 20;  // 3^20 < 2^32
    constexpr uint64_t kThrees = 3'486'784'401;
    uint32_t in_base_3 = 0, left = i;
    for (uint32_t digit = 0; digit < kDigits; ++digit, left /= 3) in_base_3 = 3 * in_base_3 + left % 3;
    const auto y = static_cast<uint32_t>((uint64_t{in_base_3} << 32) / kThrees);
    return uvec2(sobol_detail::reverse_bits(i), y) + rotation;
}

}  // namespace photond
