// Tokens: kept as hashes, read strictly, granted to whoever presents one.
#include "server/auth.h"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>

#include "protocol/error.h"

namespace photond::auth_test {
namespace {

class TokenFile : public testing::Test {
protected:
    TokenFile() {
        std::string name = (std::filesystem::temp_directory_path() / "photond-tokens-XXXXXX").string();
        close(mkstemp(name.data()));
        path_ = name;
    }
    ~TokenFile() override { std::filesystem::remove(path_); }

    TokenList load(const std::string& text) const {
        std::ofstream(path_, std::ios::trunc) << text;
        return TokenList::load(path_);
    }
    std::filesystem::path path_;
};

TEST_F(TokenFile, GrantsWhatTheLineSays) {
    const NewToken reader = make_token("viewer", Role::Read), writer = make_token("lab", Role::Write);
    EXPECT_NE(reader.token, writer.token);
    EXPECT_EQ(reader.line.find(reader.token), std::string::npos) << "the file must not hold the token itself";
    const TokenList list = load("# tokens\n\n" + reader.line + "   # a comment\n" + writer.line + "\n");
    EXPECT_EQ(list.size(), 2u);
    ASSERT_TRUE(list.check(reader.token));
    EXPECT_EQ(list.check(reader.token)->name, "viewer");
    EXPECT_EQ(list.check(reader.token)->role, Role::Read);
    EXPECT_EQ(list.check(writer.token)->role, Role::Write);
    EXPECT_FALSE(list.check(""));
    EXPECT_FALSE(list.check(reader.token.substr(1)));
    EXPECT_FALSE(list.check(reader.token + "x"));
    EXPECT_FALSE(list.check(reader.line.substr(reader.line.find("sha256:") + 7))) << "a hash is no token";
}

TEST_F(TokenFile, RefusesWhatItDoesNotUnderstand) {
    const std::string hash = "sha256:" + std::string(64, 'a');
    EXPECT_NO_THROW(load("a read " + hash + "\n"));
    for (const std::string& wrong :
         {std::string(), std::string("# nothing\n"), std::string("a read\n"), "a admin " + hash,
          "a read plain:" + std::string(64, 'a'), "a read sha256:" + std::string(63, 'a'),
          "a read sha256:" + std::string(64, 'A'), "a read " + hash + " more", "a read " + hash + "\na write " + hash})
        EXPECT_THROW(load(wrong), Error) << wrong;
    EXPECT_THROW(TokenList::load("/nonexistent/tokens"), Error);
    chmod(path_.c_str(), 0666);
    EXPECT_THROW(load("a read " + hash + "\n"), Error);
}

}  // namespace
}  // namespace photond::auth_test
