#include "renderer/transport/environment_sampling.h"

#include <algorithm>
#include <cassert>

#include "renderer/scene/scene.h"

namespace photond {

namespace {

constexpr float kTwoPi = 2 * kPi;
constexpr float kBelowOne = 0x1.fffffep-1f;
constexpr double kEven = 1e-6;  // a map whose brightest texel exceeds the mean by less, relatively, has one radiance

/// Cosine of the polar angle of a row's upper edge.
double exact_row_edge(uint32_t row, uint32_t height) {
    return std::cos(3.14159265358979323846 * row / static_cast<double>(height));
}

/// The interval of a cumulative table that holds u, and where in it, in [0, 1).
size_t find_interval(const float* cdf, size_t count, float u, float& within) {
    const float* above = std::upper_bound(cdf + 1, cdf + count, u);
    const size_t i = static_cast<size_t>(above - cdf) - 1;
    const float share = cdf[i + 1] - cdf[i];
    within = share > 0 ? std::clamp((u - cdf[i]) / share, 0.0f, kBelowOne) : 0.5f;
    return i;
}

void normalise(float* cdf, size_t count, const std::vector<double>& sums) {
    for (size_t i = 0; i <= count; ++i)
        cdf[i] = static_cast<float>(sums[count] > 0 ? sums[i] / sums[count]
                                                    : static_cast<double>(i) / static_cast<double>(count));
    cdf[count] = 1;
}

/// Calls visit(y, means) for each row from above: the mean of the bilinear interpolant over each texel, which weighs
/// its neighbours 1 : 6 : 1 in each direction; so no place that shines has none.
template <class Visit>
void visit_texel_means(const EnvironmentMap& map, const Visit& visit) {
    const uint32_t width = map.size.width, height = map.size.height;
    std::vector<float> blurred(size_t{width} * 3);  // rows y-1, y, y+1 blurred along x
    std::vector<double> means(width);
    const auto blur_row = [&](uint32_t y) {
        float* out = &blurred[size_t{y % 3} * width];
        const Rgb* row = &map.radiance[size_t{y} * width];
        for (uint32_t x = 0; x < width; ++x)
            out[x] =
                (mean(row[x > 0 ? x - 1 : width - 1]) + 6 * mean(row[x]) + mean(row[x + 1 < width ? x + 1 : 0])) / 8;
    };
    blur_row(0);
    for (uint32_t y = 0; y < height; ++y) {
        if (y + 1 < height) blur_row(y + 1);
        const float* above = &blurred[size_t{(y > 0 ? y - 1 : 0) % 3} * width];
        const float* here = &blurred[size_t{y % 3} * width];
        const float* below = &blurred[size_t{(y + 1 < height ? y + 1 : y) % 3} * width];
        for (uint32_t x = 0; x < width; ++x)
            means[x] = std::max(0.0, (double{above[x]} + 6 * double{here[x]} + below[x]) / 8);
        visit(y, means);
    }
}

}  // namespace

EnvironmentSampler::EnvironmentSampler(const Environment& environment, EnvironmentDensity density)
    : environment_(environment) {
    const EnvironmentMap& map = environment.map;
    const uint32_t width = map.size.width, height = map.size.height;
    assert(width > 0 && height > 0 && map.radiance.size() == map.size.pixels());
    row_cdf_.resize(size_t{height} + 1);
    column_cdf_.resize(size_t{height} * (width + 1));

    const auto solid_angle = [&](uint32_t y) {  // of a row, to a common factor
        return exact_row_edge(y, height) - exact_row_edge(y + 1, height);
    };
    double sum = 0, most = 0;
    visit_texel_means(map, [&](uint32_t y, std::span<const double> means) {
        double row = 0;
        for (const double value : means) row += value, most = std::max(most, value);
        sum += row * solid_angle(y);
    });
    // Texels of a row share its solid angle 2 pi (cos a - cos b); the mean is over 4 pi.
    const double mean_of_map = sum / (2.0 * width);
    mean_radiance_ = environment.scale * static_cast<float>(mean_of_map);

    const bool compensated = density == EnvironmentDensity::Compensated;
    const bool even = compensated && most - mean_of_map <= kEven * most;
    const double taken = compensated ? mean_of_map : 0;
    std::vector<double> row_sums(size_t{height} + 1, 0.0), column_sums(size_t{width} + 1, 0.0);
    visit_texel_means(map, [&](uint32_t y, std::span<const double> means) {
        for (uint32_t x = 0; x < width; ++x)
            column_sums[x + 1] = column_sums[x] + (even ? 1.0 : std::max(0.0, means[x] - taken));
        normalise(&column_cdf_[size_t{y} * (width + 1)], width, column_sums);
        row_sums[y + 1] = row_sums[y] + column_sums[width] * solid_angle(y);
    });
    normalise(row_cdf_.data(), height, row_sums);
}

float EnvironmentSampler::row_edge(uint32_t row) const {
    return static_cast<float>(exact_row_edge(row, environment_.map.size.height));
}

vec2 EnvironmentSampler::to_map(const vec3& wi) const {
    // Column centre at -z, columns running towards +x; turning the map counter-clockwise moves its columns back.
    float column = 0.5f + (std::atan2(wi.x, -wi.z) + environment_.rotation) / kTwoPi;
    column -= std::floor(column);
    // From the tangent: acos would lose half the digits near the poles.
    const float row = std::atan2(std::sqrt(wi.x * wi.x + wi.z * wi.z), wi.y) / kPi;
    return {std::min(column, kBelowOne), std::clamp(row, 0.0f, kBelowOne)};
}

bool EnvironmentSampler::sample(vec2 u, vec3& wi, float& pdf_sa) const {
    if (!(mean_radiance_ > 0)) return false;
    const uint32_t width = environment_.map.size.width, height = environment_.map.size.height;
    float in_row, in_column;
    const size_t y = find_interval(row_cdf_.data(), height, u.y, in_row);
    const float* columns = &column_cdf_[y * (width + 1)];
    const size_t x = find_interval(columns, width, u.x, in_column);

    const float top = row_edge(static_cast<uint32_t>(y));
    const float bottom = row_edge(static_cast<uint32_t>(y) + 1);
    const float cos_polar = top + in_row * (bottom - top);
    const float sin_polar = std::sqrt(std::max(0.0f, 1 - cos_polar * cos_polar));
    const float azimuth =
        kTwoPi * ((static_cast<float>(x) + in_column) / static_cast<float>(width) - 0.5f) - environment_.rotation;
    wi = {sin_polar * std::sin(azimuth), cos_polar, -sin_polar * std::cos(azimuth)};
    const float probability = (row_cdf_[y + 1] - row_cdf_[y]) * (columns[x + 1] - columns[x]);
    pdf_sa = probability * static_cast<float>(width) / (kTwoPi * (top - bottom));
    return pdf_sa > 0;
}

float EnvironmentSampler::pdf(const vec3& wi) const {
    if (!(mean_radiance_ > 0)) return 0.0f;
    const uint32_t width = environment_.map.size.width, height = environment_.map.size.height;
    const vec2 at = to_map(wi);
    const size_t y = std::min(static_cast<size_t>(at.y * static_cast<float>(height)), size_t{height} - 1);
    const size_t x = std::min(static_cast<size_t>(at.x * static_cast<float>(width)), size_t{width} - 1);
    const float* columns = &column_cdf_[y * (width + 1)];
    const float probability = (row_cdf_[y + 1] - row_cdf_[y]) * (columns[x + 1] - columns[x]);
    const float top = row_edge(static_cast<uint32_t>(y));
    const float bottom = row_edge(static_cast<uint32_t>(y) + 1);
    return probability * static_cast<float>(width) / (kTwoPi * (top - bottom));
}

Rgb EnvironmentSampler::radiance(const vec3& wi) const {
    const EnvironmentMap& map = environment_.map;
    const int width = static_cast<int>(map.size.width), height = static_cast<int>(map.size.height);
    const vec2 at = to_map(wi);
    const float x = at.x * static_cast<float>(width) - 0.5f, y = at.y * static_cast<float>(height) - 0.5f;
    const float fx = x - std::floor(x), fy = y - std::floor(y);
    const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
    const auto texel = [&](int column, int row) {
        column = column < 0 ? column + width : column >= width ? column - width : column;
        row = std::clamp(row, 0, height - 1);
        return map.radiance[static_cast<size_t>(row) * static_cast<size_t>(width) + static_cast<size_t>(column)];
    };
    const Rgb above = (1 - fx) * texel(x0, y0) + fx * texel(x0 + 1, y0);
    const Rgb below = (1 - fx) * texel(x0, y0 + 1) + fx * texel(x0 + 1, y0 + 1);
    return environment_.scale * ((1 - fy) * above + fy * below);
}

}  // namespace photond
