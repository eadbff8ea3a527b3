#pragma once
// What images are measured against, and the other images that are measured: pixels from a film or an image file.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "protocol/message_parts.h"
#include "renderer/core/geometry.h"

namespace photond {

class Film;

/// The layers of radiance that can be measured: scene-linear RGB, interleaved, row 0 at the top.
struct ReferenceImage {
    Size2 size;
    std::optional<uint32_t> passes;                    // of a film
    std::map<std::string, std::vector<float>> layers;  // "beauty", "emitted", "direct", "indirect", "caustic"
    /// Of each value's mean; of the layers it is known of: a film's beauty, direct and indirect from its second pass
    /// on, and the beauty of an EXR that says it. Empty where the noise is unknown.
    std::map<std::string, std::vector<float>> standard_error;
};

/// Of a film with at least one pass. `standard_error_scale`: as ErrorEstimate's; passes of low-discrepancy sequences
/// overstate the error by its inverse.
ReferenceImage reference_of_film(const Film& film, double standard_error_scale = 1);

/// Loads `source`. `limit_bytes`: what it may take while it is loaded. Throws ErrorCode::OutOfMemory past that,
/// ErrorCode::BadImage for an image file that cannot be read, ErrorCode::Internal for a film that is missing or damaged
/// or has no pass, ErrorCode::MissingField when `source` names neither.
ReferenceImage load_reference(const ImageSource& source, uint64_t limit_bytes = UINT64_MAX);

}  // namespace photond
