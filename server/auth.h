#pragma once
// Bearer tokens. The file holds only their SHA-256: one token a line, `NAME ROLE sha256:HEX`, '#' starts a comment.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace photond {

enum class Role : uint8_t { Read, Write };  // Write may do everything

struct Grant {
    std::string name;
    Role role = Role::Read;
};

class TokenList {
public:
    /// Throws photond::Error with the line's number for a file that cannot be read, that everybody may write, or that
    /// has a malformed line, a name twice or no token at all.
    static TokenList load(const std::filesystem::path& file);

    /// Who presents this token; none when nobody does. Takes the same time whatever the token: the presented token is
    /// hashed and compared with every row, without branching on a byte.
    std::optional<Grant> check(std::string_view token) const;
    size_t size() const { return rows_.size(); }

private:
    struct Row {
        Grant grant;
        std::string hash_hex;
    };
    std::vector<Row> rows_;
};

/// A fresh token of 256 random bits and the line for the file.
struct NewToken {
    std::string token;
    std::string line;
};
NewToken make_token(const std::string& name, Role role);

}  // namespace photond
