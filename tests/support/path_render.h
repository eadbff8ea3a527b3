#pragma once
// Renders by path tracing, which tests of other methods are compared with. Only those include this file, so that a
// change of path tracing does not reach all tests that render (tests/run --changed).

#include "renderer/methods/path_tracing/path_tracing.h"
#include "tests/support/render.h"

namespace photond::test {

using RenderSettings = RenderSettingsOf<PathTracing>;

}  // namespace photond::test
