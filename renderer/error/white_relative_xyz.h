#pragma once
// Between scene-linear Rec.709 and CIE XYZ relative to the white D65, derived from the standard's chromaticities.

#include <array>
#include <cstddef>

namespace photond {

using Matrix3 = std::array<std::array<double, 3>, 3>;  // by row

constexpr Matrix3 inverse(const Matrix3& m) {
    const auto cofactor = [&](size_t i, size_t j) {
        const size_t i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
        return m[i1][j1] * m[i2][j2] - m[i1][j2] * m[i2][j1];
    };
    const double determinant = m[0][0] * cofactor(0, 0) + m[0][1] * cofactor(0, 1) + m[0][2] * cofactor(0, 2);
    Matrix3 result{};
    for (size_t i = 0; i < 3; ++i)
        for (size_t j = 0; j < 3; ++j) result[j][i] = cofactor(i, j) / determinant;
    return result;
}

/// Linear Rec.709 to X/Xn, Y/Yn, Z/Zn, from the chromaticities of the primaries and of the white D65 (ITU-R BT.709,
/// item 1.3 and 1.4). Rows add up to 1: white is (1, 1, 1).
constexpr Matrix3 white_relative_xyz_from_rgb() {
    constexpr double kX[4] = {0.64, 0.30, 0.15, 0.3127}, kY[4] = {0.33, 0.60, 0.06, 0.3290};  // R, G, B, white
    double xyz[3][4] = {};                                                                    // of luminance 1
    Matrix3 primaries{};
    for (size_t j = 0; j < 4; ++j) {
        xyz[0][j] = kX[j] / kY[j], xyz[1][j] = 1, xyz[2][j] = (1 - kX[j] - kY[j]) / kY[j];
        for (size_t i = 0; i < 3 && j < 3; ++i) primaries[i][j] = xyz[i][j];
    }
    const Matrix3 from_xyz = inverse(primaries);
    Matrix3 result{};
    for (size_t j = 0; j < 3; ++j) {
        const double share = from_xyz[j][0] * xyz[0][3] + from_xyz[j][1] * xyz[1][3] + from_xyz[j][2] * xyz[2][3];
        for (size_t i = 0; i < 3; ++i) result[i][j] = primaries[i][j] * share / xyz[i][3];
    }
    return result;
}

inline constexpr Matrix3 kXyzFromRgb = white_relative_xyz_from_rgb();
inline constexpr Matrix3 kRgbFromXyz = inverse(kXyzFromRgb);

}  // namespace photond
