#pragma once
// The same for tests of the service, which read and write JSON.

#include <nlohmann/json.hpp>

#include "tests/support/precompiled.h"
