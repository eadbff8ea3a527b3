#pragma once
// What an image of a sequence shows of motion that its references do not: CrossMeter's estimator on what changes from
// one frame to the next.
//
// A is the image and A' the one before it, U and V, U' and V' two references of either. With dA = A - A' and so on
//
//   flicker: the mean of (dA - dU)(dA - dV) / D, what changes that should not, or does not that should;
//   lag:     the mean of (A - U)(V - V') / D, both references in either place: below 0 where the image shows what was;
//   change:  the mean of dU dV / D, that of the truth itself: one frame of lag is a lag of minus so much.
//
// D is relative_mse's of the frame at hand, by its references. The noise of references drops out where it is
// independent, from frame to frame too: with one seed for all frames it would look like stillness. Where D shares the
// noise of its pixel, what that adds is taken off as CrossMeter takes it off relative_mse. With R = (U + V) / 2,
// h = (U - V) / 2, e = A - R, nu = h^2 / D, rho = R^2 / D and E = dA - dR it is the mean of
//
//   4 nu E R / D - 2/3 nu^2 (4 rho - 1) for flicker and, with -dR for E, for change;
//   -2 nu (e - dR) R / D + 2/3 nu^2 (4 rho - 1) for lag.
//
// Standard errors are of the references' noise, as CrossMeter's: q is -2 E dh / D for the two, and
// ((e - dR) h - e h') / D for lag, whose mean square is the variance of lag's terms where noise is normal.

#include <cstdint>
#include <optional>
#include <span>

#include "renderer/error/cross_meter.h"

namespace photond {

struct MotionErrors {
    /// Empty where no value is left or the references' mean is 0.
    std::optional<CrossError> flicker, lag, change;
    uint64_t left_out = 0;  // values that are not finite in one of the six

    /// How many frames an image shows too late, by lag over change; empty where nothing changes for certain.
    static std::optional<double> frames_late(const CrossError& lag, const CrossError& change);
};

/// `before`: of the frame before. Images and references are of one size (asserted).
MotionErrors motion_errors(const CrossMeter& references, const CrossMeter& references_before,
                           std::span<const float> image, std::span<const float> image_before);

}  // namespace photond
