#include "server/auth.h"

#include <openssl/crypto.h>
#include <openssl/rand.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

#include "protocol/error.h"
#include "renderer/core/sha256.h"

namespace photond {

namespace {

constexpr std::string_view kHashPrefix = "sha256:";

bool is_hash(std::string_view hex) {
    return hex.size() == 64 &&
           std::all_of(hex.begin(), hex.end(), [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

[[noreturn]] void refuse(const std::filesystem::path& file, size_t line, const std::string& why) {
    throw Error(ErrorCode::OutOfRange, file.string() + (line ? ", line " + std::to_string(line) : "") + ": " + why);
}

}  // namespace

TokenList TokenList::load(const std::filesystem::path& file) {
    struct stat status {};
    if (stat(file.c_str(), &status) != 0) refuse(file, 0, std::strerror(errno));
    if (!S_ISREG(status.st_mode)) refuse(file, 0, "is not a regular file");
    if (status.st_mode & S_IWOTH) refuse(file, 0, "may be written by everybody; chmod o-w it");
    std::ifstream in(file);
    if (!in) refuse(file, 0, "cannot be read");

    TokenList list;
    std::string line;
    for (size_t number = 1; std::getline(in, line); ++number) {
        if (const size_t comment = line.find('#'); comment != std::string::npos) line.resize(comment);
        std::istringstream words(line);
        std::string name, role, hash, more;
        if (!(words >> name)) continue;
        if (!(words >> role >> hash) || (words >> more)) refuse(file, number, "expected NAME ROLE sha256:HEX");
        if (role != "read" && role != "write") refuse(file, number, "role '" + role + "' is neither read nor write");
        if (!hash.starts_with(kHashPrefix) || !is_hash(std::string_view(hash).substr(kHashPrefix.size())))
            refuse(file, number, "expected sha256: and 64 lower-case hexadecimal digits");
        for (const Row& row : list.rows_)
            if (row.grant.name == name) refuse(file, number, "the name '" + name + "' is there twice");
        list.rows_.push_back({{name, role == "write" ? Role::Write : Role::Read}, hash.substr(kHashPrefix.size())});
    }
    if (list.rows_.empty()) refuse(file, 0, "holds no token");
    return list;
}

std::optional<Grant> TokenList::check(std::string_view token) const {
    const std::string hash = sha256_hex(token.data(), token.size());
    const Row* match = nullptr;
    // Every row is compared, whether or not one has matched; CRYPTO_memcmp does not branch on the bytes.
    for (const Row& row : rows_)
        if (CRYPTO_memcmp(row.hash_hex.data(), hash.data(), hash.size()) == 0) match = &row;
    return match ? std::optional(match->grant) : std::nullopt;
}

NewToken make_token(const std::string& name, Role role) {
    std::array<unsigned char, 32> random{};
    if (RAND_bytes(random.data(), static_cast<int>(random.size())) != 1)
        throw Error(ErrorCode::Internal, "the system gives no random bytes");
    std::string token = "photond_";
    for (const unsigned char byte : random) {
        constexpr char kDigits[] = "0123456789abcdef";
        token += kDigits[byte >> 4];
        token += kDigits[byte & 15];
    }
    return {token, name + (role == Role::Write ? " write " : " read ") + std::string(kHashPrefix) +
                       sha256_hex(token.data(), token.size())};
}

}  // namespace photond
