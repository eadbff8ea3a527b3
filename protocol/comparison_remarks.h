#pragma once
// What people say of a comparison: a title and notes. They decide nothing of what is rendered, and may be changed at
// any time.

#include <nlohmann/json.hpp>

#include "protocol/object_reader.h"

namespace photond {

inline constexpr size_t kMaxTitleBytes = 200;
inline constexpr size_t kMaxNotesBytes = 20'000;

/// "title" and "notes" of a body, those of them that it has: a string, or null where there is to be none. Notes may
/// have several lines. Faults are added.
nlohmann::json read_remarks(const nlohmann::json& body, ObjectReader& reader, BodyFaults& faults);

}  // namespace photond
