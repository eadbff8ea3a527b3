#include "server/service/idempotency_key.h"

#include <algorithm>

#include "protocol/error.h"

namespace photond {

namespace {

constexpr size_t kMaxKeyBytes = 255;

}  // namespace

void check_idempotency_key(const std::string& key) {
    const bool printable = std::all_of(key.begin(), key.end(), [](char c) { return c > 31 && c < 127; });
    if (key.empty() || key.size() > kMaxKeyBytes || !printable)
        throw Error(ErrorCode::OutOfRange,
                    "an Idempotency-Key has 1 to " + std::to_string(kMaxKeyBytes) + " printable ASCII characters");
}

}  // namespace photond
