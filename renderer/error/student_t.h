#pragma once
// Student's t distribution, with a whole or a fractional number of degrees of freedom.

namespace photond {

/// P(|T| >= |t|) for `degrees` above 0, which may be fractional (Satterthwaite's) or infinite: the normal distribution.
/// [Abramowitz and Stegun 1964] Handbook of Mathematical Functions, 26.7.1: I_x(degrees / 2, 1 / 2) at
/// x = degrees / (degrees + t^2). Tails keep their digits: 1e-12 relative, 1e-9 for millions of degrees.
double student_t_tails(double t, double degrees);

/// The t that |T| stays below with `probability`, in [0, 1).
double two_sided_student_t(double probability, double degrees);

}  // namespace photond
