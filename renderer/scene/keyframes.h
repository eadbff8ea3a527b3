#pragma once
// Values at moments, and what lies between them (glTF 2.0, 3.11 and appendix C).

#include <cstdint>
#include <vector>

namespace photond {

enum class Interpolation : uint8_t { Step, Linear, CubicSpline };

/// What a property of `width` numbers is at any time. Before the first key and after the last one it is theirs.
struct Keyframes {
    std::vector<float> times;   // [s], none less than the one before; never empty
    std::vector<float> values;  // `width` numbers a key; of a spline the tangent in, the value, the tangent out
    uint32_t width = 1;
    Interpolation interpolation = Interpolation::Linear;
    bool rotation = false;  // quaternions (x, y, z, w): Linear goes the short way round, and results are unit

    /// Seconds of the last key.
    double end_s() const { return static_cast<double>(times.back()); }
    uint64_t bytes() const { return (times.capacity() + values.capacity()) * sizeof(float); }
    /// Writes `width` numbers.
    void evaluate(double time_s, double* result) const;
};

}  // namespace photond
