#pragma once
// Sums of what two references make of an image, and the error that they give (cross_meter.h).

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "renderer/error/cross_meter.h"

namespace photond {

/// Of terms divided by one kind of D.
struct CrossSums {
    double products = 0;          // x y / D
    double squared_terms = 0;     // q^2, by pixel
    double squared_products = 0;  // of x y / D, by pixel

    CrossSums& operator+=(const CrossSums& other) {
        products += other.products, squared_terms += other.squared_terms;
        squared_products += other.squared_products;
        return *this;
    }
    /// Of `count` values in `pixels` pixels.
    CrossError error(uint64_t count, uint64_t pixels) const {
        const auto n = static_cast<double>(count);
        const double scatter = squared_products - products * products / static_cast<double>(pixels);
        return {products / n, std::sqrt(std::min(squared_terms, std::max(scatter, 0.0))) / n};
    }
};

}  // namespace photond
