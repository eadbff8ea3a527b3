#pragma once
// What images are measured against, and the other images that are measured: pixels from a film or an image file.

#include <cstdint>
#include <map>
#include <optional>
#include <set>
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

    /// Of the pixels.
    uint64_t bytes() const;
};

/// What a film is measured against, of one size. With a second image, whose noise is independent of the first's, it is
/// their mean, and quadratic measures are cross estimates.
struct LoadedReference {
    ReferenceImage first;
    std::optional<ReferenceImage> second;
};

/// Of a film with at least one pass. `standard_error_scale`: as ErrorEstimate's; passes of low-discrepancy sequences
/// overstate the error by its inverse.
ReferenceImage reference_of_film(const Film& film, double standard_error_scale = 1);

/// The layers that both have, and their standard error where it is known of both: the mean of two independent images of
/// one size (asserted).
ReferenceImage mean_of(ReferenceImage one, const ReferenceImage& other);

/// Loads `source`. `limit_bytes`: what it may take while it is loaded. Throws ErrorCode::OutOfMemory past that,
/// ErrorCode::BadImage for an image file that cannot be read, ErrorCode::Internal for a film that is missing or damaged
/// or has no pass, ErrorCode::MissingField when `source` names neither.
ReferenceImage load_image(const ImageSource& source, uint64_t limit_bytes = UINT64_MAX);
/// Both images of `source`, of their layers those named. Throws likewise, and ErrorCode::Conflict where they differ in
/// size.
LoadedReference load_reference(const ReferenceSource& source, const std::set<std::string>& layers,
                               uint64_t limit_bytes = UINT64_MAX);

}  // namespace photond
