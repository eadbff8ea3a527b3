#pragma once
// Artefacts as answers: validators, single ranges, straight from disk.

#include "server/routes/exchange.h"
#include "server/service.h"

namespace photond::http {

struct ByteRange {
    enum class Kind : uint8_t { Whole, Part, Unsatisfiable };
    Kind kind = Kind::Whole;
    uint64_t offset = 0;
    uint64_t length = 0;
};

/// A Range header against a file of `bytes`. One range is honoured; several, other units and malformed ones mean the
/// whole (RFC 9110, 14.2 permits it, and overlapping ranges cost memory).
ByteRange parse_range(const std::string& header, uint64_t bytes);

/// Whether an If-None-Match or If-Match header names a validator (given with its quotes), or "*". If-None-Match
/// compares weakly (RFC 9110, 13.1.2): the W/ is passed over there.
bool lists_etag(std::string_view header, const std::string& quoted_etag, bool weak);

/// 200, 206, 304, or 202 while pending. Throws Refusal (416). The file is opened, never read here.
Reply file_reply(const Call& call, const Artefact& artefact);

}  // namespace photond::http
