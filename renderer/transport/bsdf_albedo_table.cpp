#include "renderer/transport/bsdf_albedo_table.h"

#include "renderer/transport/fresnel.h"
#include "renderer/transport/microfacet.h"

namespace photond {

namespace {

/// (A, B): facets split by Schlick's curve.
vec2 integrate(float cos_theta, float alpha) {
    const vec3 wo(std::sqrt(1.0f - sqr(cos_theta)), 0, cos_theta);
    return Ggx{alpha}.directional_albedo<vec2>(wo, 16, 32, false, [](float cos_h) {
        const float schlick = schlick_weight(cos_h);
        return vec2(1.0f - schlick, schlick);
    });
}

/// The place of a fractional node. The limit at the horizon is taken just above it.
float cos_of_column(float column) {
    return std::max(sqr(sqr(column / static_cast<float>(AlbedoTable::kColumns - 1))), 1e-9f);
}
float alpha_of_row(float row) {
    const float least = std::sqrt(DELTA_ROUGHNESS);
    const float root = least + (1.0f - least) * row / static_cast<float>(AlbedoTable::kRows - 1);
    return sqr(sqr(root));
}

/// What the grid of integrate() may miss (bsdf_energy_test): a share of the result, and of B this much, near grazing.
constexpr float kMissedShare = 1.5e-3f;
constexpr float kMissedB = 7e-4f;

}  // namespace

AlbedoTable::AlbedoTable(bool raised) {
    integrate_nodes();
    if (raised) raise_to_cover_cells();
    average_rows();
}

void AlbedoTable::integrate_nodes() {
    // Not in parallel: a thread that waited here could be handed a task that needs this very table.
    for (size_t r = 0; r < kRows; ++r)
        for (size_t c = 0; c < kColumns; ++c)
            directional_[r][c] = integrate(cos_of_column(static_cast<float>(c)), alpha_of_row(static_cast<float>(r)));
}

/// Where a cell's middle lies above the mean of its corners, interpolation falls short all over the cell: the corners
/// are raised by what is missing in the middle.
void AlbedoTable::raise_to_cover_cells() {
    std::array<std::array<vec2, kColumns>, kRows> missing{};
    for (size_t r = 0; r + 1 < kRows; ++r)
        for (size_t c = 0; c + 1 < kColumns; ++c) {
            const vec2 middle =
                integrate(cos_of_column(static_cast<float>(c) + 0.5f), alpha_of_row(static_cast<float>(r) + 0.5f));
            const vec2 interpolated = 0.25f * (directional_[r][c] + directional_[r][c + 1] + directional_[r + 1][c] +
                                               directional_[r + 1][c + 1]);
            for (const size_t i : {r, r + 1})
                for (const size_t j : {c, c + 1}) missing[i][j] = glm::max(missing[i][j], middle - interpolated);
        }
    for (size_t r = 0; r < kRows; ++r)
        for (size_t c = 0; c < kColumns; ++c)
            directional_[r][c] = (1 + kMissedShare) * (directional_[r][c] + missing[r][c]) + vec2(0, kMissedB);
}

/// Mean of E 2 cos dcos = E 8 t^7 dt with t = cos^(1/4), of the linear interpolant exactly: a node weighs the integral
/// of its hat function times 8 t^7.
void AlbedoTable::average_rows() {
    constexpr double kStep = 1.0 / (kColumns - 1);
    for (size_t r = 0; r < kRows; ++r) {
        dvec3 sum(0);
        for (size_t c = 0; c + 1 < kColumns; ++c) {
            const double a = static_cast<double>(c) * kStep, b = a + kStep;
            const double mass = std::pow(b, 8) - std::pow(a, 8);
            const double moment = 8.0 / 9.0 * (std::pow(b, 9) - std::pow(a, 9));
            const double right = (moment - a * mass) / kStep, left = mass - right;
            sum += left * dvec3(vec3(directional_[r][c], 0)) + right * dvec3(vec3(directional_[r][c + 1], 0));
        }
        average_[r] = vec2(sum);
    }
}

std::vector<vec2> AlbedoTable::device_data() const {
    std::vector<vec2> data;
    data.reserve(kRows * kColumns + kRows);
    for (const auto& row : directional_) data.insert(data.end(), row.begin(), row.end());
    data.insert(data.end(), average_.begin(), average_.end());
    return data;
}

const AlbedoTable& AlbedoTable::get() {
    static const AlbedoTable table(true);
    return table;
}

const AlbedoTable& AlbedoTable::unraised() {
    static const AlbedoTable table(false);
    return table;
}

}  // namespace photond
