#pragma once
// Bias and noise of a method apart, from images of different seeds and two references (believing-errors.md, "Bias
// and noise apart").
//
// A_1 ... A_k are images of one method, I the truth, R = (U + V) / 2 and d = (U - V) / 2 of the two references, and
// <x, y> the mean over values of x y / D with the denominators of CrossMeter. With e_i = A_i - R, e their mean, G the
// matrix <e_i, e_j> and M the same of the e_i - e:
//
//   squared bias  B = the cross estimate of the A_i's mean, less V / k   (the mean of (A_i - U)(A_j - V) over i != j,
//                                                                        made symmetric)
//   variance      V = tr M / (k - 1)                                     (of one image, mean over values)
//
// and the error of one image is to be expected at B + V. Nothing is taken from the spread over an image's pixels, which
// share photons, lights and points of a sequence; of the references' pixels alone it is taken that they are
// independent, as those of path tracing with a box filter are.
//
// The interval of B. Its noise from the seeds is 2 <b, N> + the mean over i != j of <N_i, N_j>, N_i the noise of A_i
// and b its bias: of a variance 4 L / k + 2 Q / (k (k - 1)), L that of <b, N_i> and Q that of <N_i, N_j>. The sample
// variance a of g_i = <e, e_i> over the seeds estimates L + Q / k with k - 1 degrees of freedom, and what M has beside
// a multiple of the unit matrix estimates Q,
//
//   Q = (|M|^2 - (tr M)^2 / (k - 1)) / ((k - 2)(k + 1)),   with m = (k - 2)(k + 1) / 2 degrees.
//
// Both are replaced by what they may have come from, a (k - 1) / chi^2 and Q m / chi^2; the interval's half width h is
// the one that holds 90 % of normal numbers of all the variances this makes [Weerahandi 1993, Generalized Confidence
// Intervals], the references' added. At k = 2, where there is no Q, it is Student's t of one degree times
// |<e, e_1 - e_2>|, exact for normal noise without bias, of one direction or of many.
// With three images or more, of noise that is one pattern times a random number the share f = S / tr M, with
// S^2 = Q (k - 1)(k + 1), is 1, of pixels' own noise near 0. One pattern has another interval: the part p of e along it
// is a Student's t of k - 1 degrees, and B the square of the bias along it and of all the rest of e. Ends are mixed by
// f^4.
//
// The interval of V. Of pixels' own noise: on a logarithmic scale by Student's t of k - 1 degrees, from the spread of
// the M_ii. Of one pattern and pixels' own noise together: (1 - f) V of the pixels, which many of them tell, and
// S / chi^2 of the pattern, which the k seeds tell alone. Where f is as small as pixels' own noise makes it the first
// one is stated; from there on both, joined; and the second the more, the larger f is. Two images give none.
//
// Measured, how often stated 90 % hold the truth (2,000 trials of each kind; LongSeedErrorsStatistics), for 2, 3 and 5
// seeds. B: 89 to 92 for pixels' own noise, with a bias or without; 88 to 94 for one pattern, 94 and 95 with noisy
// references and two seeds; 92 to 97 for both kinds of noise at once (89 with two seeds). V: 90 to 92 for either kind,
// 88 and 92 for both at once. Rare bright values (9 in one case of ten, else -1): B 94 to 97, V 90 and 91. What they
// cannot hold is references whose pixels share their noise: less than half.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "renderer/error/cross_meter.h"
#include "renderer/error/interval.h"
#include "renderer/error/metric.h"

namespace photond {

struct SeedError {
    double squared_bias = 0;  // not clamped: may be negative
    Interval squared_bias_interval;
    double variance = 0;  // of one image
    std::optional<Interval> variance_interval;
};

struct SeedErrors {
    /// Empty where no value is left; relative_mse also where m is 0.
    std::optional<SeedError> mse, relative_mse;
    Denominators denominators = Denominators::Pixel;  // of relative_mse, the references' choice
    uint64_t left_out = 0;                            // values that are not finite in one of the images

    /// By a mean square (asserted).
    const std::optional<SeedError>& of(Metric mean_square) const;
};

/// Of a quadratic metric (asserted): that whose root it is, or itself. A root has no bias and noise that add up to it.
Metric mean_square_of(Metric metric);

/// `films`: two or more images of one method with different seeds, of the references' size (asserted).
SeedErrors seed_errors(const CrossMeter& references, std::span<const std::vector<float>> films);

}  // namespace photond
