#pragma once
// Where a method is biased: per block of pixels, whether the mean of its images differs from the references' by more
// than both noises explain (believing-errors.md, "Where a method is biased").
//
// [Jung et al. 2020] Detecting Bias in Monte Carlo Renderers using Welch's t-test. JCGT 9(2). Departures:
//   * Variances of a method come from images of different seeds, never from its pixels or passes, which share photons,
//     lights and points of a sequence; that of the references from half of their difference, whose pixels are
//     independent.
//   * Satterthwaite's degrees of freedom are stated, and not used: where the variance of few seeds comes out small by
//     luck, that of the references seems to be all there is, with a thousand degrees. In 500 images without bias of 64
//     blocks that called 73 % biased with two seeds and 15 % with three. The chance is the mean over all variances that
//     the seeds' may have come from instead, which keeps the level: 1 % with two seeds, three and eight.
//   * The blocks of an image are judged together [Holm 1979, A Simple Sequentially Rejective Multiple Test Procedure].
//
// What is compared is luminance. Noise is much the same in all three channels, so that three tests a block would find
// hardly more than one, and Holm's level would be a third; of what changes a colour but not its luminance, or blue
// alone (7 % of it), this map says little.
//
// Few seeds have few degrees of freedom, and their t has long tails: to be found as the one block of 64 a difference
// has to be 3.8 standard errors with any number of seeds, 4.9 with 17, 10 with 6, 80 with three and 4,100 with two,
// unless the references' noise is the larger one. A bias of 1 % at a standard error of 0.18 % of the block is found
// nine times of ten with kSeedsToTell seeds, eight times with 20 (or with 8, where three quarters of the variance are
// the references').

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "renderer/core/geometry.h"
#include "renderer/error/cross_meter.h"

namespace photond {

struct WelchBlock {
    /// The method's mean less the references', over sqrt(r^2 + 0.01 m^2): r the block's mean luminance in R, m the
    /// image's. Of a black reference: as they are.
    double difference = 0;
    double standard_error = 0;  // of that, likewise
    double degrees = 0;         // of freedom [Satterthwaite 1946]; 0 where there is no noise at all
    double p = 1;               // of a difference as large by chance; 1 where the block has no finite pixel
    bool found = false;         // it differs, at kLevel for the image as a whole
};

struct WelchMap {
    static constexpr uint32_t kBlock = 32;  // pixels a side
    static constexpr double kLevel = 0.01;  // chance of finding any block of an image without bias
    static constexpr size_t kSeedsToTell = 45;

    uint32_t block = kBlock;
    Size2 size;  // in blocks; those at the right and at the bottom may be cut
    size_t seeds = 0;
    std::vector<WelchBlock> blocks;  // row by row from the top
    size_t tested = 0;               // of them: those that have a finite pixel
    size_t found = 0;
    double share_below_level = 0;  // of blocks whose own p is below kLevel: about that without bias
    /// The bias, relative as above, that half of the blocks would have shown nine times of ten.
    double detectable = 0;
    /// In these of `judged` blocks the noise is that of few bright pixels: t is not distributed as assumed there.
    size_t heavy_blocks = 0, judged_blocks = 0;
    bool heavy_tailed = false;

    /// "biased: 3 of 64 blocks differ from the reference at a level of 1 %, the worst by +2.3 % +- 0.4 %".
    std::string text() const;
};

/// `films`: two or more images of one method with different seeds, of the references' size (asserted). Pixels that are
/// not finite in any of them are left out.
WelchMap welch_map(const CrossMeter& references, std::span<const std::vector<float>> films,
                   uint32_t block = WelchMap::kBlock);

}  // namespace photond
