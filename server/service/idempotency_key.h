#pragma once
#include <string>

namespace photond {

/// Throws OutOfRange for what is no Idempotency-Key.
void check_idempotency_key(const std::string& key);

}  // namespace photond
