#pragma once
// Which of several error curves are worth choosing.

#include <span>
#include <vector>

#include "renderer/error/curve.h"

namespace photond {

/// For each curve whether it is on the Pareto front of (seconds, error): whether at some time of its span no other
/// curve has been as low before, or is lower then. Equal curves do not exclude each other; an empty one is never on it.
/// Between their points curves are taken as straight in log-log.
std::vector<bool> pareto_front(std::span<const std::vector<TimedError>> curves);

}  // namespace photond
