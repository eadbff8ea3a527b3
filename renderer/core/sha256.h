#pragma once
#include <cstddef>
#include <memory>
#include <string>

namespace photond {

/// Incremental SHA-256 (OpenSSL's).
class Sha256 {
public:
    Sha256();
    ~Sha256();
    void update(const void* data, size_t bytes);
    /// Lower-case hex, 64 digits. Ends the computation.
    std::string hex_digest();

private:
    struct Context;
    std::unique_ptr<Context> context_;
};

std::string sha256_hex(const void* data, size_t bytes);

}  // namespace photond
