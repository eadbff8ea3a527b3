// GLSL twin of transport/discrete_distribution.h: choice of one of many by a uniform number.
// [Chen and Asau 1974] On Generating Random Variates from an Empirical Distribution. AIIE Transactions 6.
#ifndef PHOTOND_DISCRETE_DISTRIBUTION_GLSL
#define PHOTOND_DISCRETE_DISTRIBUTION_GLSL

/// Defines, for a distribution whose tables are the arrays CDF (float) and GUIDE (uint), each from a place on:
///   uint NAME_sample(uint cdf, uint guide, uint guides, float u)   the entry for u in [0, 1); guides: intervals, > 0
///   float NAME_probability(uint cdf, uint entry)                   with which it is the one
#define DISCRETE_DISTRIBUTION(NAME, CDF, GUIDE)                                    \
    uint NAME##_sample(uint cdf, uint guide, uint guides, float u) {               \
        const uint i = uint(u * float(guides));                                    \
        uint low = GUIDE[guide + i], high = GUIDE[guide + i + 1u];                 \
        while (low < high) {                                                       \
            const uint middle = (low + high) / 2u;                                 \
            if (CDF[cdf + 1u + middle] <= u)                                       \
                low = middle + 1u;                                                 \
            else                                                                   \
                high = middle;                                                     \
        }                                                                          \
        return low;                                                                \
    }                                                                              \
    float NAME##_probability(uint cdf, uint entry) { return CDF[cdf + entry + 1u] - CDF[cdf + entry]; }

#endif
