#pragma once
// What a client would have an answer be of.

#include <string>
#include <vector>

#include "server/routes/request_head.h"

namespace photond::http {

/// The type of those on offer that the request's Accept header likes best (RFC 9110, 12.5.1), the first of several that
/// it likes alike, and without such a header. Throws NotAcceptable where it takes none of them.
std::string accepted_type(const RequestHead& head, const std::vector<std::string>& offered);

}  // namespace photond::http
