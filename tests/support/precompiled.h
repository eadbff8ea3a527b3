#pragma once
// What nearly every test includes anyway, read once for all of them (tests/CMakeLists.txt).

#include <gtest/gtest.h>

#include "renderer/precompiled.h"
