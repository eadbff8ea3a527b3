#pragma once
// Bytes of film files (film_file.h) as versions of before wrote them.

#include <cstdint>
#include <cstring>
#include <string>
#include <utility>

#include "renderer/core/sha256.h"

namespace photond::test {

template <class Value>
std::string raw(Value value) {
    return {reinterpret_cast<const char*>(&value), sizeof value};
}

inline std::string film_digest(const std::string& bytes) {
    return sha256_hex(bytes.data(), bytes.size()).substr(0, 32);
}

/// Of the parts between header and sums, the first one being 0: those that versions brought.
inline constexpr int kOriginPart = 5, kMeansPart = 6, kStatePart = 7;

/// Where a part begins; how long it is there.
inline std::pair<size_t, size_t> place_of_part(const std::string& film, int part) {
    for (size_t at = 80;; --part) {
        uint64_t length;
        std::memcpy(&length, &film[at], sizeof length);
        if (part == 0) return {at, sizeof length + length + 32};
        at += sizeof length + length + 32;
    }
}

/// A film's file with another version, and further layers, in its header.
inline std::string relabelled(const std::string& film, uint32_t version, uint64_t extra_layers = 0) {
    uint32_t layers, passes, more_layers;
    std::memcpy(&layers, &film[20], sizeof layers);
    std::memcpy(&passes, &film[24], sizeof passes);
    std::memcpy(&more_layers, &film[28], sizeof more_layers);
    const std::string head = film.substr(0, 8) + raw(version) + film.substr(12, 8) +
                             raw(layers | static_cast<uint32_t>(extra_layers)) + raw(passes) +
                             raw(more_layers | static_cast<uint32_t>(extra_layers >> 32)) + film.substr(32, 16);
    return head + film_digest(head) + film.substr(80);
}

/// A film of this version, without a method's state, as version 6, 5 or 4 wrote it.
inline std::string film_of_version(std::string film, uint32_t version) {
    for (const auto& [part, last] :
         {std::pair{kStatePart, 6u}, std::pair{kMeansPart, 5u}, std::pair{kOriginPart, 4u}}) {
        if (version > last) continue;
        const auto [at, length] = place_of_part(film, part);
        film.erase(at, length);
    }
    return relabelled(film, version);
}

}  // namespace photond::test
