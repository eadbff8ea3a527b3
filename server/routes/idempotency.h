#pragma once
#include <optional>
#include <string>

#include "server/routes/exchange.h"

namespace photond::http {

/// The header Idempotency-Key, where there is one. Throws BadRequest for an empty or overlong one.
std::optional<std::string> idempotency_key(const Call& call);

}  // namespace photond::http
