#include "clients/cli/units.h"

#include <array>
#include <cmath>
#include <cstdio>

namespace photond::cli {

namespace {

std::string formatted(const char* format, double value) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), format, value);
    return text.data();
}

/// Three significant digits of a value in [1, 1000), and whole numbers above.
std::string three_digits(double value) {
    if (value >= 99.95) return formatted("%.0f", value);
    if (value >= 9.995) return formatted("%.1f", value);
    return formatted("%.2f", value);
}

}  // namespace

std::string human_bytes(double bytes) {
    constexpr std::array<const char*, 5> kUnits = {"B", "kB", "MB", "GB", "TB"};
    size_t unit = 0;
    while (bytes >= 999.5 && unit + 1 < kUnits.size()) {
        bytes /= 1000;
        ++unit;
    }
    return (unit == 0 ? formatted("%.0f", bytes) : three_digits(bytes)) + " " + kUnits[unit];
}

std::string human_seconds(double seconds) {
    if (!(seconds >= 0)) return "-";
    if (seconds == 0) return "0 s";
    if (seconds < 9.995e-4) return three_digits(seconds * 1e6) + " us";
    if (seconds < 0.9995) return three_digits(seconds * 1e3) + " ms";
    if (seconds < 59.95) return three_digits(seconds) + " s";
    const auto whole = static_cast<uint64_t>(std::llround(seconds));
    std::array<char, 64> text{};
    if (whole < 3600)
        std::snprintf(text.data(), text.size(), "%u min %02u s", static_cast<unsigned>(whole / 60),
                      static_cast<unsigned>(whole % 60));
    else
        std::snprintf(text.data(), text.size(), "%llu h %02u min", static_cast<unsigned long long>(whole / 3600),
                      static_cast<unsigned>(whole / 60 % 60));
    return text.data();
}

std::string human_count(double count) {
    constexpr std::array<const char*, 5> kPrefixes = {"", " k", " M", " G", " T"};
    size_t prefix = 0;
    while (std::abs(count) >= 999.5 && prefix + 1 < kPrefixes.size()) {
        count /= 1000;
        ++prefix;
    }
    return (prefix == 0 ? human_number(count) : three_digits(count)) + kPrefixes[prefix];
}

std::string counted(uint64_t count, const std::string& one) {
    return std::to_string(count) + " " + one + (count == 1 ? "" : "s");
}

std::string human_number(double value) {
    if (value == std::floor(value) && std::abs(value) < 1e7) return formatted("%.0f", value);
    if (std::abs(value) >= 1e7 || std::abs(value) < 1e-3) return formatted("%.3g", value);
    return formatted("%.4g", value);
}

std::string three_digit_number(double value) { return formatted("%.3g", value); }

std::string human_time(const nlohmann::json& rfc3339) {
    if (!rfc3339.is_string()) return "-";
    std::string text = printable(rfc3339.get<std::string>());
    if (text.size() < 19) return text;
    text.resize(19);
    text[10] = ' ';
    return text;
}

std::string plain_text(const nlohmann::json& value) {
    if (value.is_null()) return "-";
    if (value.is_string()) return printable(value.get<std::string>());
    if (value.is_number_float()) return human_number(value.get<double>());
    return printable(value.dump());
}

size_t display_width(std::string_view utf8) {
    size_t width = 0;
    for (const char c : utf8) width += (static_cast<unsigned char>(c) & 0xC0U) != 0x80U;  // not a continuation byte
    return width;
}

std::string printable(std::string_view text) {
    std::string clean;
    for (size_t i = 0; i < text.size(); ++i) {
        const auto byte = static_cast<unsigned char>(text[i]);
        const auto next = static_cast<unsigned char>(i + 1 < text.size() ? text[i + 1] : 0);
        if (byte == 0xC2 && next >= 0x80 && next < 0xA0) {  // U+0080..U+009F, among them the one-character CSI
            clean += '?';
            ++i;
        } else if (byte < 0x20 || byte == 0x7F) {
            clean += byte == '\t' || byte == '\n' ? ' ' : '?';
        } else {
            clean += text[i];
        }
    }
    return clean;
}

}  // namespace photond::cli
