#include "server/routes/idempotency.h"

namespace photond::http {

std::optional<std::string> idempotency_key(const Call& call) {
    const std::string* key = call.head.header("idempotency-key");
    if (key == nullptr) return std::nullopt;
    if (key->empty() || key->size() > 255)
        throw Error(ErrorCode::BadRequest,
                    "Idempotency-Key must have 1 to 255 bytes, has " + std::to_string(key->size()));
    return *key;
}

}  // namespace photond::http
