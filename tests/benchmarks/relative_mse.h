#pragma once
#include <vector>

namespace photond {

/// conventions.md, `relative_mse`.
inline double relative_mse(const std::vector<float>& image, const std::vector<float>& reference) {
    double mean = 0, sum = 0;
    for (const float r : reference) mean += r;
    mean /= double(reference.size());
    for (size_t i = 0; i < image.size(); ++i)
        sum +=
            (image[i] - reference[i]) * (image[i] - reference[i]) / (reference[i] * reference[i] + 0.01 * mean * mean);
    return sum / double(image.size());
}

}  // namespace photond
