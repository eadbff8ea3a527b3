#pragma once
// The name somebody most likely meant. Standard library only: shared by the readers of JSON and the renderer.

#include <string>
#include <string_view>
#include <vector>

namespace photond {

/// Edits (insert, delete, replace, swap two neighbours) that turn `a` into `b`; no part is edited twice.
/// [Damerau 1964] A Technique for Computer Detection and Correction of Spelling Errors. CACM 7(3): optimal string
/// alignment form.
size_t edit_distance(std::string_view a, std::string_view b);

/// The known name nearest to a misspelt one: at most a third of its length in edits (one edit for short names), letters
/// of either case alike. Empty when none is near. The first wins a tie.
std::string nearest_name(const std::string& wrong, const std::vector<std::string>& known);

}  // namespace photond
