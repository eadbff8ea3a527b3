#pragma once
// How a report's numbers and names are written.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "renderer/error/curve.h"

namespace photond {

/// Text as it may stand in HTML and SVG, in attributes too.
std::string escaped(std::string_view text);
/// Three digits that count: "0.00123", "12.3", "1.2e-7".
std::string short_number(double value);
/// The same with as many more digits as this number needs to be told from any other.
std::string exact_number(double value);
/// "0.52 s", "12 ms", "3 min 20 s".
std::string short_seconds(double seconds);
/// "12.3 MB".
std::string short_bytes(uint64_t bytes);
/// Of whichever of the above: "0.50 – 0.55".
std::string range(double from, double to, std::string (*written)(double));
/// Over the seeds, likewise; empty without an interval.
std::string interval(const SeedMean& mean, std::string (*written)(double));
std::string base64(std::span<const uint8_t> bytes);
/// base64 of the SHA-256 of a text: what a content-security policy names an inline script or style by.
std::string sha256_base64(std::string_view text);

}  // namespace photond
