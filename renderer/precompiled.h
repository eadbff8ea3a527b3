#pragma once
// What nearly every file of the renderer includes anyway, read once for all of them (CMakeLists.txt). No file includes
// this one; each includes what it needs itself, which tests/run --tidy proves.

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <experimental/simd>
#include <functional>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>
