#include "server/routes/dashboard.h"

#include <algorithm>

#include "server/routes/file_reply.h"
#include "server/routes/routes.h"

namespace photond::http {
namespace {

// Pictures arrive by fetch(), which can carry a token, and are shown as blobs.
constexpr const char* kContentSecurityPolicy =
    "default-src 'self'; img-src 'self' blob:; "
    "object-src 'none'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'";

/// Whether a list such as "gzip;q=0.5, br" takes gzip.
bool takes_gzip(const RequestHead& head) {
    const std::string* accepted = head.header("accept-encoding");
    if (accepted == nullptr) return false;
    for (const std::string_view item : list_items(*accepted)) {
        const std::string_view coding = item.substr(0, item.find_first_of("; \t"));
        if (coding != "gzip" && coding != "x-gzip" && coding != "*") continue;
        const size_t weight = item.find("q=");
        return weight == std::string_view::npos ||
               item.substr(weight + 2).find_first_of("123456789") != std::string_view::npos;
    }
    return false;
}

Reply file_at(const Call& call, const DashboardFile& file) {
    Reply reply;
    const bool gzip = takes_gzip(call.head);
    const std::string etag = "\"" + std::string(file.etag) + (gzip ? "-gzip\"" : "\"");
    reply.media_type = file.media_type;
    reply.headers["ETag"] = etag;
    reply.headers["Vary"] = "Accept-Encoding";
    // Files below /assets have their contents' hash in their names: another build's have others.
    const bool named_by_content = file.path.starts_with("/assets/");
    reply.headers["Cache-Control"] = named_by_content ? "public, max-age=31536000, immutable" : "no-cache";
    reply.headers["Content-Security-Policy"] = kContentSecurityPolicy;
    reply.headers["Referrer-Policy"] = "no-referrer";
    if (const std::string* known = call.head.header("if-none-match"); known && lists_etag(*known, etag, true)) {
        reply.status = 304;
        return reply;
    }
    if (gzip) reply.headers["Content-Encoding"] = "gzip";
    reply.body = gzip ? file.gzip : file.bytes;
    return reply;
}

const DashboardFile& require_file(std::string_view path) {
    const auto files = dashboard_files();
    const auto found = std::find_if(files.begin(), files.end(), [&](const DashboardFile& f) { return f.path == path; });
    if (found == files.end()) throw Error(ErrorCode::NotFound, "there is nothing at this path");
    return *found;
}

}  // namespace

// Pages are open: what they show they ask for with the token of who looks.
void add_dashboard_routes(std::vector<Route>& routes) {
    const auto add = [&routes](const char* pattern, std::function<Reply(Call&)> handle) {
        routes.push_back({.method = "GET", .pattern = pattern, .open = true, .handle = std::move(handle)});
    };
    const DashboardFile& page = require_file("/index.html");
    for (const char* pattern : kDashboardPages) add(pattern, [&page](Call& call) { return file_at(call, page); });
    add("missing page", [&page](Call& call) {
        Reply reply = file_at(call, page);
        if (reply.status == 200) reply.status = 404;
        return reply;
    });
    routes.back().missing_page = true;
    add("/favicon.svg", [](Call& call) { return file_at(call, require_file("/favicon.svg")); });
    add("/assets/{file}", [](Call& call) { return file_at(call, require_file("/assets/" + call.path_parameters[0])); });
}

}  // namespace photond::http
