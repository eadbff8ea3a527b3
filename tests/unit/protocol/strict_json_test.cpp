#include "protocol/strict_json.h"

#include <gtest/gtest.h>

#include "protocol/error.h"
#include "protocol/problem.h"

namespace photond::strict_json_test {
namespace {

Error error_of(const std::string& text, const JsonLimits& limits = {}) {
    try {
        parse_strict_json(text, limits);
    } catch (const Error& error) {
        return error;
    }
    ADD_FAILURE() << "accepted: " << text.substr(0, 200);
    return Error(ErrorCode::Internal, "accepted");
}

TEST(StrictJson, ReadsWhatIsGood) {
    const nlohmann::json value =
        parse_strict_json(R"( {"a": [1, -2, 2.5, "x\u00e9", true, null, {}], "b": {"a": []}} )");
    EXPECT_EQ(value.dump(), R"({"a":[1,-2,2.5,"xé",true,null,{}],"b":{"a":[]}})");
    EXPECT_EQ(parse_strict_json("18446744073709551615").get<uint64_t>(), UINT64_MAX);
    EXPECT_EQ(parse_strict_json("\"alone\""), "alone");
}

TEST(StrictJson, SaysLineAndColumn) {
    const Error error = error_of("{\n  \"a\": 1,\n  \"b\" 2\n}");
    EXPECT_EQ(error.code, ErrorCode::BadJson);
    EXPECT_NE(std::string(error.what()).find("line 3, column 7"), std::string::npos) << error.what();
}

TEST(StrictJson, RefusesMalformedText) {
    for (const char* text : {"",     " ",        "{",        "[1,]",  "{\"a\":}",    "{a:1}",   "nul",  "1 2",
                             "[1]]", "\"\x01\"", "\"\xff\"", "'a'",   "01",          "+1",      ".5",   "1.",
                             "NaN",  "Infinity", "-",        "1e999", "\"\\ud800\"", "// x\n1", "[1 2]"})
        EXPECT_EQ(error_of(text).code, ErrorCode::BadJson) << text;
    EXPECT_EQ(error_of(std::string("[\0]", 3)).code, ErrorCode::BadJson);
}

TEST(StrictJson, RefusesDuplicateKeysWithTheirPlace) {
    const Error error = error_of(R"({"a": [0, {"b/c": 1, "x": {}, "b/c": 2}]})");
    ASSERT_EQ(error.faults.size(), 1u);
    EXPECT_EQ(error.faults[0].pointer, "/a/1/b~1c");
    EXPECT_NO_THROW(parse_strict_json(R"({"a": {"a": {"a": 1}}, "b": [{"a": 1}, {"a": 2}]})"));
}

TEST(StrictJson, RefusesDepthBeforeItCostsStack) {
    const JsonLimits limits{.max_depth = 10};
    EXPECT_NO_THROW(parse_strict_json(std::string(10, '[') + std::string(10, ']'), limits));
    EXPECT_EQ(error_of(std::string(11, '[') + std::string(11, ']'), limits).code, ErrorCode::BadJson);
    EXPECT_EQ(error_of(std::string(1'000'000, '[')).code, ErrorCode::BadJson);
    std::string objects;
    for (int i = 0; i < 100'000; ++i) objects += "{\"a\":";
    EXPECT_EQ(error_of(objects).code, ErrorCode::BadJson);
}

TEST(StrictJson, RefusesSizeAndNumberOfValues) {
    EXPECT_EQ(error_of(std::string(101, ' '), {.max_bytes = 100}).code, ErrorCode::PayloadTooLarge);
    EXPECT_EQ(error_of("[1,2,3,4]", {.max_values = 4}).code, ErrorCode::BadJson);
    EXPECT_NO_THROW(parse_strict_json("[1,2,3]", {.max_values = 4}));
}

TEST(Problem, CanAlwaysBeWritten) {
    const Error error(ErrorCode::OutOfRange, "/\xff", "value \xc3\x28 is bad");
    const nlohmann::json problem = problem_json(error, "/v1/\xfe");
    EXPECT_NO_THROW((void)problem.dump());
    EXPECT_EQ(problem["status"], 422);
    EXPECT_EQ(problem["type"], "urn:photond:problem:out_of_range");
    EXPECT_EQ(problem["errors"].size(), 1u);
}

}  // namespace
}  // namespace photond::strict_json_test
