#pragma once
// Pixels as the helper writes them for a download: what can be asked for, and what their bytes alone do not say.

#include <map>
#include <string>

#include "protocol/helper_messages.h"
#include "protocol/object_reader.h"

namespace photond {

/// A fault for what is neither "float" nor "half".
void check_precision(const std::string& precision, BodyFaults& faults);
/// Throws OutOfRange for what is neither "float" nor "half".
void require_precision(const std::string& precision);
/// What the helper says of pixels, as headers of a reply.
std::map<std::string, std::string> pixel_headers(const EncodedReply& encoded);

}  // namespace photond
