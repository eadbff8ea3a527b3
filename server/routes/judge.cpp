#include "server/routes/judge.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace photond::http {
namespace {

// A wrong token may be a slip; ten and then one in ten seconds are not.
constexpr double kGuesses = 10, kGuessesPerSecond = 0.1;
constexpr double kGuessHeld_seconds = 1;
constexpr const char* kBearer = "Bearer realm=\"photond\"";

std::vector<std::string_view> split(std::string_view path) {
    std::vector<std::string_view> parts;
    for (path.remove_prefix(1);; path.remove_prefix(parts.back().size() + 1)) {
        parts.push_back(path.substr(0, path.find('/')));
        if (parts.back().size() == path.size()) return parts;
    }
}

/// "hard-case/corner-90": built-in scenes of a family are the only names with a slash, and have nothing else in them
/// that a path could mean.
bool is_family_member(std::string_view name) {
    const size_t slash = name.find('/');
    const auto word = [](std::string_view part) {
        return !part.empty() && part.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-") == std::string::npos;
    };
    return word(name.substr(0, slash)) && word(name.substr(slash + 1));
}

// The values of {..} where the pattern fits; nothing where it does not.
std::optional<std::vector<std::string>> match(std::string_view pattern, const std::vector<std::string>& parts) {
    const std::vector<std::string_view> wanted = split(pattern);
    if (wanted.size() != parts.size()) return std::nullopt;
    std::vector<std::string> values;
    for (size_t i = 0; i < wanted.size(); ++i) {
        if (wanted[i].starts_with('{')) {
            if (parts[i].empty()) return std::nullopt;
            if (parts[i].find('/') != std::string::npos && !(wanted[i] == "{scene}" && is_family_member(parts[i])))
                return std::nullopt;
            values.push_back(parts[i]);
        } else if (wanted[i] != parts[i]) {
            return std::nullopt;
        }
    }
    return values;
}

bool is_read(const std::string& method) { return method == "GET" || method == "HEAD"; }

/// Whether a browser opens it as a page, by what it says that it takes.
bool wants_page(const RequestHead& head) {
    const std::string* accept = head.header("accept");
    return is_read(head.method) && !head.path.starts_with("/v1/") && accept != nullptr &&
           accept->find("text/html") != std::string::npos;
}

}  // namespace

Judge::Judge(JudgeSettings settings, const std::vector<Route>& routes, const TokenList* tokens)
    : settings_(std::move(settings)),
      routes_(routes),
      tokens_(tokens),
      rates_(settings_.max_requests_per_second),
      guesses_(kGuessesPerSecond, kGuesses),
      told_of_(kGuessesPerSecond, 1) {}

void Judge::operator()(Exchange& exchange) {
    const RequestHead& head = exchange.call.head;
    check_host(head);
    check_origin(head);
    find_route(exchange);
    check_token(exchange);
    check_rate(exchange);
    check_body(exchange);
}

// Against DNS rebinding: a page of a stranger may make a browser send requests here under the stranger's own name.
// Where tokens are asked for, the stranger has none.
void Judge::check_host(const RequestHead& head) const {
    if (!settings_.loopback || tokens_ != nullptr || head.host.empty()) return;
    const bool local =
        head.host == "localhost" || head.host == "[::1]" ||
        (head.host.starts_with("127.") && head.host.find_first_not_of("0123456789.") == std::string::npos);
    if (!local) throw Error(ErrorCode::Forbidden, "the Host \"" + head.host + "\" is not this machine");
}

void Judge::check_origin(const RequestHead& head) const {
    const auto origins = std::count_if(head.headers.begin(), head.headers.end(),
                                       [](const auto& header) { return header.first == "origin"; });
    if (origins > 1) throw Error(ErrorCode::Forbidden, "two Origin headers");
    if (is_read(head.method)) return;
    // Browsers say it themselves, and no page can keep them from it.
    for (const auto& [name, value] : head.headers)
        if (name == "sec-fetch-site" && value == "cross-site")
            throw Error(ErrorCode::Forbidden, "requests that change something are not taken from pages of other sites");
    const std::string* origin = head.header("origin");
    if (origin == nullptr) return;  // no browser, or none that was led here by another site
    if (*origin != "http://" + head.authority && *origin != "https://" + head.authority)
        throw Error(ErrorCode::Forbidden, "requests that change something are not taken from pages of other origins");
}

void Judge::find_route(Exchange& exchange) const {
    const RequestHead& head = exchange.call.head;
    std::vector<std::string> parts;
    for (const std::string_view part : split(head.path)) {
        const std::optional<std::string> decoded = percent_decode(part);
        if (!decoded) throw Error(ErrorCode::BadRequest, "the path has a malformed percent escape");
        // Nothing here has such a name, and nothing behind this point should have to think of them.
        if (*decoded == "." || *decoded == ".." || std::any_of(decoded->begin(), decoded->end(), [](char c) {
                return c == '\\' || static_cast<unsigned char>(c) < 0x20;
            }))
            throw Error(ErrorCode::NotFound, "there is nothing at this path");
        parts.push_back(*decoded);
    }
    std::set<std::string> allowed;
    const Route* missing_page = nullptr;
    for (const Route& route : routes_) {
        if (route.missing_page) {
            missing_page = &route;
            continue;
        }
        std::optional<std::vector<std::string>> values = match(route.pattern, parts);
        if (!values) continue;
        allowed.insert(route.method);
        if (route.method == "GET") allowed.insert("HEAD");
        if (route.method != head.method && !(route.method == "GET" && head.method == "HEAD")) continue;
        exchange.route = &route;
        exchange.call.path_parameters = std::move(*values);
        return;
    }
    if (allowed.empty() && missing_page && wants_page(head)) {
        exchange.route = missing_page;
        return;
    }
    if (allowed.empty()) throw Error(ErrorCode::NotFound, "there is nothing at this path");
    std::string list;
    for (const std::string& method : allowed) list += (list.empty() ? "" : ", ") + method;
    throw Refusal{Error(ErrorCode::MethodNotAllowed, head.method + " is not one of " + list), {{"Allow", list}}};
}

// A right token is taken all the same: the others behind an address (a proxy's) are not made to pay.
void Judge::refuse_guess(const std::string& peer) {
    const double wait_seconds = guesses_.take(peer);
    if (wait_seconds == 0) {
        spdlog::warn("a bearer token that is not known, from {}", peer);
        throw Refusal{Error(ErrorCode::Unauthorized, "the bearer token is not known"), {{"WWW-Authenticate", kBearer}}};
    }
    if (told_of_.take(peer) == 0)
        spdlog::warn("more bearer tokens that are not known, from {}: a guesser is slowed", peer);
    throw Refusal{Error(ErrorCode::TooManyRequests, "too many bearer tokens that are not known"),
                  {{"Retry-After", std::to_string(static_cast<int64_t>(std::ceil(wait_seconds)))}},
                  kGuessHeld_seconds};
}

void Judge::check_token(Exchange& exchange) {
    if (tokens_ == nullptr || exchange.route->open) return;
    const std::string* header = exchange.call.head.header("authorization");
    constexpr std::string_view kScheme = "bearer ";
    std::optional<Grant> grant;
    if (header != nullptr && header->size() > kScheme.size() &&
        std::equal(kScheme.begin(), kScheme.end(), header->begin(),
                   [](char a, char b) { return a == (b >= 'A' && b <= 'Z' ? b - 'A' + 'a' : b); }))
        grant = tokens_->check(std::string_view(*header).substr(kScheme.size()));
    if (!grant && header != nullptr) refuse_guess(exchange.call.peer);
    if (!grant)
        throw Refusal{Error(ErrorCode::Unauthorized, "no bearer token was given"), {{"WWW-Authenticate", kBearer}}};
    if (grant->role == Role::Read && !is_read(exchange.call.head.method))
        throw Error(ErrorCode::Forbidden, "the token \"" + grant->name + "\" may only read");
    exchange.call.grant = grant;
}

void Judge::check_rate(const Exchange& exchange) {
    if (exchange.route->open) return;
    const Call& call = exchange.call;
    const double wait_seconds = rates_.take(client_of(call));
    if (wait_seconds > 0)
        throw Refusal{Error(ErrorCode::TooManyRequests,
                            "more than " + std::to_string(settings_.max_requests_per_second) + " requests a second"),
                      {{"Retry-After", std::to_string(static_cast<int64_t>(std::ceil(wait_seconds)))}}};
}

void Judge::check_body(const Exchange& exchange) const {
    const RequestHead& head = exchange.call.head;
    const Route& route = *exchange.route;
    if (route.body == BodyKind::None) {
        if (head.content_length > 0) throw Error(ErrorCode::BadRequest, "this request takes no body");
        return;
    }
    const std::string type = head.media_type();
    const std::vector<std::string> json_type{"application/json"};
    const auto& types = route.body == BodyKind::Json ? json_type : route.media_types;
    if (std::find(types.begin(), types.end(), type) == types.end()) {
        std::string list;
        for (const std::string& known : types) list += (list.empty() ? "" : ", ") + known;
        throw Refusal{
            Error(ErrorCode::WrongMediaType, (type.empty() ? std::string("no Content-Type was given")
                                                           : "the Content-Type \"" + type + "\" is not taken here") +
                                                 "; taken are: " + list),
            {{"Accept-Post", list}}};
    }
    if (const std::string* content_type = head.header("content-type")) {
        const std::string charset = header_parameter(*content_type, "charset").value_or("utf-8");
        constexpr std::string_view kUtf8 = "utf-8";
        if (!std::equal(charset.begin(), charset.end(), kUtf8.begin(), kUtf8.end(),
                        [](char a, char b) { return a == b || (a >= 'A' && a <= 'Z' && a - 'A' + 'a' == b); }))
            throw Error(ErrorCode::WrongMediaType, "the charset \"" + charset + "\" is not taken here; send UTF-8");
    }
    if (!head.has_length) throw Error(ErrorCode::LengthRequired, "the body's Content-Length is missing");
    const uint64_t limit = route.body == BodyKind::Json ? settings_.max_json_bytes : settings_.max_upload_bytes;
    if (head.content_length > limit)
        throw Error(ErrorCode::PayloadTooLarge, "the body has " + std::to_string(head.content_length) +
                                                    " bytes, the limit is " + std::to_string(limit));
    if (route.body == BodyKind::Upload) settings_.check_disk(head.content_length);
}

}  // namespace photond::http
