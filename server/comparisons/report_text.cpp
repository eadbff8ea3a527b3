#include "server/comparisons/report_text.h"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <vector>

#include "renderer/core/sha256.h"

namespace photond {
namespace {

/// `digits` that count, without an exponent where that is short.
std::string number(double value, int digits) {
    std::array<char, 64> text;
    const double size = std::abs(value);
    const bool plain = value == 0 || (size >= 1e-4 && size < 1e6);
    const auto end =
        plain
            ? std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed,
                            std::max(0, digits - 1 - (value == 0 ? 0 : static_cast<int>(std::floor(std::log10(size))))))
            : std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::scientific, digits - 1);
    std::string written(text.data(), end.ptr);
    const size_t exponent = written.find('e');
    std::string tail;
    if (exponent != std::string::npos) {  // "e-07" as "e-7"
        tail = "e" + std::to_string(std::stoi(written.substr(exponent + 1)));
        written.resize(exponent);
    }
    if (written.find('.') != std::string::npos) {
        written.erase(written.find_last_not_of('0') + 1);
        if (written.ends_with('.')) written.pop_back();
    }
    return written + tail;
}

}  // namespace

std::string escaped(std::string_view text) {
    std::string safe;
    for (const char c : text) switch (c) {
            case '&': safe += "&amp;"; break;
            case '<': safe += "&lt;"; break;
            case '>': safe += "&gt;"; break;
            case '"': safe += "&quot;"; break;
            case '\'': safe += "&#39;"; break;
            default: safe += c;
        }
    return safe;
}

std::string short_number(double value) { return number(value, 3); }

std::string exact_number(double value) {
    for (int digits = 3; digits < std::numeric_limits<double>::max_digits10; ++digits) {
        std::string text = number(value, digits);
        double read = 0;
        std::from_chars(text.data(), text.data() + text.size(), read);
        if (read == value) return text;
    }
    return number(value, std::numeric_limits<double>::max_digits10 + 1);  // log10 may be one too large
}

std::string short_seconds(double seconds) {
    if (seconds < 1) return number(seconds * 1000, 3) + " ms";
    if (seconds < 100) return number(seconds, 3) + " s";
    const auto whole = static_cast<uint64_t>(std::llround(seconds));
    const auto two = [](uint64_t part, const char* unit) {
        return part == 0 ? std::string() : " " + std::to_string(part) + unit;
    };
    if (whole < 3600) return std::to_string(whole / 60) + " min" + two(whole % 60, " s");
    return std::to_string(whole / 3600) + " h" + two(whole % 3600 / 60, " min");
}

std::string short_bytes(uint64_t bytes) {
    static constexpr const char* kUnits[] = {" B", " kB", " MB", " GB", " TB"};
    auto value = static_cast<double>(bytes);
    size_t unit = 0;
    while (value >= 999.5 && unit + 1 < std::size(kUnits)) value /= 1000, ++unit;
    return number(value, 3) + kUnits[unit];
}

std::string range(double from, double to, std::string (*written)(double)) {
    return written(from) + " – " + written(to);
}

std::string interval(const SeedMean& mean, std::string (*written)(double)) {
    return mean.low && mean.high ? range(*mean.low, *mean.high, written) : "";
}

std::string base64(std::span<const uint8_t> bytes) {
    static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (size_t i = 0; i < bytes.size(); i += 3) {
        const size_t count = std::min<size_t>(3, bytes.size() - i);
        uint32_t group = 0;
        for (size_t k = 0; k < 3; ++k) group = group << 8 | (k < count ? bytes[i + k] : 0u);
        for (size_t k = 0; k < 4; ++k) text += k <= count ? kDigits[group >> (18 - 6 * k) & 63] : '=';
    }
    return text;
}

std::string sha256_base64(std::string_view text) {
    const std::string hex = sha256_hex(text.data(), text.size());
    std::vector<uint8_t> bytes(hex.size() / 2);
    for (size_t i = 0; i < bytes.size(); ++i) std::from_chars(hex.data() + 2 * i, hex.data() + 2 * i + 2, bytes[i], 16);
    return base64(bytes);
}

}  // namespace photond
