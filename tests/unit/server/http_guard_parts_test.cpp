// The parts of the HTTP guard that are pure functions of bytes.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "server/routes/accept.h"
#include "server/routes/file_reply.h"
#include "server/routes/multipart.h"
#include "server/routes/rate_limiter.h"
#include "server/routes/request_head.h"

namespace photond::http::http_guard_parts_test {
namespace {

std::string code_of(const std::function<void()>& action) {
    try {
        action();
    } catch (const Error& error) {
        return std::string(error_kind(error.code).name);
    }
    return "accepted";
}

TEST(RequestHead, ReadsAPlainRequest) {
    const RequestHead head = parse_head(
        "\r\nPOST /v1/jobs?a=1&b HTTP/1.1\r\nHOST: LocalHost:80\r\nContent-Length: 12\r\nX:  y \r\nX: z\r\n"
        "Content-Type: Application/JSON; charset=utf-8\r\n\r\n");
    EXPECT_EQ(head.method, "POST");
    EXPECT_EQ(head.path, "/v1/jobs");
    EXPECT_EQ(head.query, "a=1&b");
    EXPECT_EQ(head.host, "localhost");
    EXPECT_EQ(head.content_length, 12u);
    EXPECT_EQ(*head.header("x"), "y");
    EXPECT_EQ(head.media_type(), "application/json");
    EXPECT_TRUE(head.keep_alive);
}

TEST(RequestHead, TakesTheAbsoluteForm) {
    const RequestHead head = parse_head("GET http://[::1]:8080?x HTTP/1.1\r\nHost: other\r\n\r\n");
    EXPECT_EQ(head.host, "[::1]");
    EXPECT_EQ(head.path, "/");
    EXPECT_EQ(head.query, "x");
}

TEST(RequestHead, FindsParametersOfHeaders) {
    EXPECT_EQ(header_parameter("application/json; Charset=\"UTF-8\"; x=y", "charset"), "UTF-8");
    EXPECT_EQ(header_parameter("application/json;charset=latin1 ", "charset"), "latin1");
    EXPECT_EQ(header_parameter("application/json; xcharset=latin1", "charset"), std::nullopt);
}

TEST(RequestHead, ItemsOfAList) {
    using Items = std::vector<std::string_view>;
    EXPECT_EQ(list_items("br, gzip;q=0.5\t, *"), (Items{"br", "gzip;q=0.5", "*"}));
    EXPECT_EQ(list_items(" ,, respond-async ,"), (Items{"respond-async"}));
    EXPECT_EQ(list_items(""), Items{});
}

// Whatever the pieces in which a head arrives, its end is found at the same byte.
TEST(HeadScanner, FindsTheEndInAnyPieces) {
    const std::string text = "\r\n\r\nGET / HTTP/1.1\r\nHost: a\r\nX: y\r\n\r\nbody\r\n\r\n";
    const size_t end = text.find("body");
    for (size_t step = 1; step <= text.size(); ++step) {
        HeadScanner scanner;
        std::optional<size_t> found;
        for (size_t n = step; !found && n < text.size() + step; n += step)
            found = scanner.scan(std::string_view(text).substr(0, std::min(n, text.size())), {});
        EXPECT_EQ(found, end) << step;
    }
}

TEST(HeadScanner, HoldsItsLimits) {
    const HeadLimits limits{.max_bytes = 1000, .max_line_bytes = 100, .max_lines = 10};
    const auto scan = [&](const std::string& text) { return code_of([&] { (void)HeadScanner().scan(text, limits); }); };
    EXPECT_EQ(scan("GET / HTTP/1.1\r\n" + std::string(99, 'x')), "accepted");
    EXPECT_EQ(scan("GET / HTTP/1.1\r\n" + std::string(101, 'x')), "head_too_large");
    std::string lines = "GET / HTTP/1.1\r\n";
    for (int i = 0; i < 10; ++i) lines += "a: b\r\n";
    EXPECT_EQ(scan(lines), "head_too_large");
    std::string many;
    for (int i = 0; i < 600; ++i) many += "\r\n";
    EXPECT_EQ(scan(many), "head_too_large");
    EXPECT_EQ(scan("GET / HTTP/1.1\n"), "bad_request");
    EXPECT_EQ(scan("GET\r/ HTTP/1.1"), "bad_request");
    EXPECT_EQ(scan(std::string("GET\0", 4)), "bad_request");
}

// Mutated heads end in a head or an Error, never in anything else (run under ASan too).
TEST(RequestHead, SurvivesMutations) {
    const std::string seeds[] = {
        "GET /a%20b?c=d HTTP/1.1\r\nHost: [::1]:80\r\nContent-Length: 5\r\nExpect: 100-continue\r\n\r\n",
        "POST http://h:1/x HTTP/1.0\r\nConnection: keep-alive, close\r\nTransfer-Encoding: chunked\r\n\r\n"};
    std::mt19937 random(3);
    size_t accepted = 0, refused = 0;
    for (int i = 0; i < 50'000; ++i) {
        std::string text = seeds[i % 2];
        for (auto edits = random() % 6; edits > 0; --edits) {
            const size_t at = random() % text.size();
            switch (random() % 4) {
                case 0: text[at] = static_cast<char>(random()); break;
                case 1: text.erase(at, random() % 9); break;
                case 2: text.insert(at, 1, ":\r\n %[]?,"[random() % 9]); break;
                default: text.insert(at, text.substr(random() % text.size(), random() % 30)); break;
            }
            if (text.empty()) text = " ";
        }
        try {
            HeadScanner scanner;
            const std::optional<size_t> end = scanner.scan(text, {});
            if (!end) continue;
            const RequestHead head = parse_head(std::string_view(text).substr(0, *end));
            EXPECT_TRUE(head.path.starts_with('/'));
            ++accepted;
        } catch (const Error&) {
            ++refused;
        }
    }
    EXPECT_GT(accepted, 1000u);
    EXPECT_GT(refused, 1000u);
}

TEST(Range, OneRangeOrTheWhole) {
    using Kind = ByteRange::Kind;
    const struct {
        const char* header;
        Kind kind;
        uint64_t offset, length;
    } cases[] = {{"bytes=0-0", Kind::Part, 0, 1},         {"bytes=5-", Kind::Part, 5, 5},
                 {"bytes=-3", Kind::Part, 7, 3},          {"bytes=-30", Kind::Part, 0, 10},
                 {"bytes=9-100", Kind::Part, 9, 1},       {"bytes=10-", Kind::Unsatisfiable, 0, 0},
                 {"bytes=-0", Kind::Unsatisfiable, 0, 0}, {"bytes=1-2,3-4", Kind::Whole, 0, 10},
                 {"bytes=4-2", Kind::Whole, 0, 10},       {"bytes=1", Kind::Whole, 0, 10},
                 {"items=0-1", Kind::Whole, 0, 10},       {"bytes=0x1-2", Kind::Whole, 0, 10}};
    for (const auto& wanted : cases) {
        const ByteRange range = parse_range(wanted.header, 10);
        EXPECT_EQ(range.kind, wanted.kind) << wanted.header;
        EXPECT_EQ(range.offset, wanted.offset) << wanted.header;
        EXPECT_EQ(range.length, wanted.length) << wanted.header;
    }
    EXPECT_EQ(parse_range("bytes=-5", 0).kind, Kind::Unsatisfiable);
}

TEST(RateLimiter, TakesItsRateAndNoMore) {
    RateLimiter limiter(10);
    const auto start = RateLimiter::Clock::now();
    int taken = 0;
    for (int ms = 0; ms < 5000; ++ms) taken += limiter.take("a", start + std::chrono::milliseconds(ms)) == 0;
    EXPECT_NEAR(taken, 10 + 50, 1);  // a full bucket, and five seconds
    EXPECT_EQ(limiter.take("b", start), 0);
    EXPECT_NEAR(RateLimiter(0.5).take("a", start), 0, 0);
    RateLimiter slow(0.1, 10);
    for (int i = 0; i < 10; ++i) EXPECT_EQ(slow.take("a", start), 0);
    EXPECT_NEAR(slow.take("a", start), 10, 1e-9);
    EXPECT_EQ(slow.take("a", start + std::chrono::seconds(10)), 0);
}

class Multipart : public ::testing::Test {
protected:
    void SetUp() override {
        std::string pattern = (std::filesystem::temp_directory_path() / "multipart-XXXXXX").string();
        ASSERT_NE(mkdtemp(pattern.data()), nullptr);
        root_ = pattern;
        std::filesystem::create_directory(root_ / "out");
    }
    void TearDown() override { std::filesystem::remove_all(root_); }

    UploadedForm unpack(const std::string& body, const std::map<std::string, size_t>& fields = {}) {
        std::ofstream(root_ / "body", std::ios::binary) << body;
        return unpack_form(root_ / "body", "B", root_ / "out", fields);
    }
    static std::string part(const std::string& file_name, const std::string& content) {
        return "--B\r\nContent-Disposition: form-data; name=\"f\"; filename=\"" + file_name +
               "\"\r\nContent-Type: x/y\r\n\r\n" + content + "\r\n";
    }
    std::string file(const std::string& name) {
        std::ifstream in(root_ / "out" / name, std::ios::binary);
        std::stringstream text;
        text << in.rdbuf();
        return text.str();
    }
    std::filesystem::path root_;
};

TEST_F(Multipart, WritesFilesByteForByte) {
    std::mt19937 random(5);
    std::string bytes(3'000'000, '\0');
    for (char& c : bytes) c = "\r\n-B\0x"[random() % 6];  // full of beginnings of a delimiter
    for (size_t at = bytes.find("\r\n--B"); at != std::string::npos; at = bytes.find("\r\n--B")) bytes[at] = 'z';
    const UploadedForm form = unpack(part("a.gltf", "{}") + part("tex/deep/b.bin", bytes) + part("empty", "") +
                                     "--B\r\nContent-Disposition: form-data; name=name\r\n\r\nmy scene\r\n--B--\r\n");
    EXPECT_EQ(form.files, 3u);
    EXPECT_EQ(form.fields.at("name"), "my scene");
    EXPECT_EQ(file("a.gltf"), "{}");
    EXPECT_EQ(file("tex/deep/b.bin"), bytes);
    EXPECT_EQ(file("empty"), "");
}

// A field that is asked for is one, whether it was typed or sent from a file.
TEST_F(Multipart, ReadsTheFieldsThatItIsToldOf) {
    const std::string typed = "--B\r\nContent-Disposition: form-data; name=job\r\n\r\n{}\r\n";
    const std::string sent = "--B\r\nContent-Disposition: form-data; name=job; filename=a.json\r\n\r\n[1]\r\n--B--";
    const UploadedForm form = unpack(part("a.glb", "x") + typed + sent, {{"job", 3}});
    EXPECT_EQ(form.files, 1u);
    EXPECT_EQ(form.fields.at("job"), "[1]");
    EXPECT_EQ(code_of([&] { unpack(typed + sent, {{"job", 2}}); }), "out_of_range");
    EXPECT_EQ(code_of([&] { unpack(typed + sent); }), "unknown_field");
}

std::string accepted(const std::string& accept) {
    RequestHead head;
    if (!accept.empty()) head.headers.emplace_back("accept", accept);
    return accepted_type(head, {"image/png", "image/x-exr", "application/json"});
}

TEST(Accept, TakesWhatIsLikedBest) {
    EXPECT_EQ(accepted(""), "image/png");
    EXPECT_EQ(accepted("*/*"), "image/png");
    EXPECT_EQ(accepted("image/x-exr"), "image/x-exr");
    EXPECT_EQ(accepted("text/html, application/json;q=0.5"), "application/json");
    EXPECT_EQ(accepted("image/*;q=0.3, image/x-exr ; q=0.4, application/json;q=0.35"), "image/x-exr");
    EXPECT_EQ(accepted("*/*;q=0.1, image/png;q=0"), "image/x-exr") << "a name closer than the range refuses one";
    for (const char* none : {"text/html", "image/webp, video/*", "image/png;q=0", "image", "*"})
        EXPECT_EQ(code_of([&] { accepted(none); }), "not_acceptable") << none;
}

TEST_F(Multipart, RefusesNamesThatLeaveTheFolder) {
    for (const char* name : {"../x", "/x", "a/../x", "a/..", "..", ".", "./x", "a//x", "a/", "", "a\\\\x", "a\tb",
                             "1/2/3/4/5/6/7/8/9/10/11/12/13/14/15/16/17"})
        EXPECT_EQ(code_of([&] { unpack(part(name, "x") + "--B--"); }), "out_of_range") << name;
    EXPECT_EQ(code_of([&] { unpack(part("a", "x") + part("a", "y") + "--B--"); }), "conflict");
    EXPECT_EQ(code_of([&] { unpack(part("b", "x") + part("b/c", "y") + "--B--"); }), "conflict");
    EXPECT_FALSE(std::filesystem::exists(root_ / "x"));
}

TEST_F(Multipart, RefusesMalformedBodies) {
    for (const std::string& body :
         {std::string(), std::string("--B"), std::string("--B--x").substr(0, 4), part("c", "x"),
          std::string("--B\r\n\r\nx\r\n--B--"), std::string("--B\r\nnothing\r\n\r\nx\r\n--B--"),
          std::string("--Bx\r\n"), "--B\r\n" + std::string(20'000, 'h'),
          std::string("--B\r\nContent-Disposition: form-data; filename=q\r\n"
                      "Content-Transfer-Encoding: base64\r\n\r\nx\r\n--B--")})
        EXPECT_EQ(code_of([&] { unpack(body); }), "bad_request") << body.substr(0, 100);
    EXPECT_EQ(code_of([] { multipart_boundary("multipart/form-data"); }), "bad_request");
    EXPECT_EQ(multipart_boundary("multipart/form-data; charset=x; Boundary=\"a b\""), "a b");
}

}  // namespace
}  // namespace photond::http::http_guard_parts_test
