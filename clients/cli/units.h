#pragma once
// Figures for people: sizes, spans and counts with a unit and three significant digits.

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace photond::cli {

std::string human_bytes(double bytes);      // 1.25 MB: of 1,000,000 bytes
std::string human_seconds(double seconds);  // 3.1 ms, 12.4 s, 3 min 05 s, 2 h 10 min
std::string human_count(double count);      // 950, 12.3 k, 4.56 M
/// "1 file", "2 files"
std::string counted(uint64_t count, const std::string& one);
/// Four significant digits, no trailing zeros, no exponent between 1e-3 and 1e7.
std::string human_number(double value);
/// Three significant digits: errors, which are not known to more. No exponent between 1e-4 and 1e4.
std::string three_digit_number(double value);
/// "2026-11-21T06:25:12.345Z" as "2026-11-21 06:25:12"; "-" for null.
std::string human_time(const nlohmann::json& rfc3339);
/// A JSON scalar as a person writes it: no quotes, "-" for null; objects and arrays as JSON.
std::string plain_text(const nlohmann::json& value);

/// Number of terminal columns of UTF-8 text.
size_t display_width(std::string_view utf8);

/// Control characters out of text that came from elsewhere (names, messages), so that it cannot steer the terminal.
std::string printable(std::string_view text);

}  // namespace photond::cli
