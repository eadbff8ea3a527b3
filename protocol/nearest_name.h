#pragma once
// The name somebody most likely meant. Standard library only and all in this header: shared by
// the readers of JSON and the renderer, which links nothing of protocol/.

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>
#include <vector>

namespace photond {

namespace nearest_name_detail {

// A longer "name" is no typing mistake; the limit keeps the table small whatever is sent.
inline constexpr size_t kLongestName = 256;

inline std::string lower_case(std::string_view text) {
    std::string lower(text);
    for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return lower;
}

}  // namespace nearest_name_detail

/// Edits (insert, delete, replace, swap two neighbours) that turn `a` into `b`; no part is edited twice.
/// [Damerau 1964] A Technique for Computer Detection and Correction of Spelling Errors. CACM 7(3): optimal string
/// alignment form.
inline size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<size_t> two_back(b.size() + 1), one_back(b.size() + 1), row(b.size() + 1);
    for (size_t j = 0; j <= b.size(); ++j) one_back[j] = j;
    for (size_t i = 1; i <= a.size(); ++i) {
        row[0] = i;
        for (size_t j = 1; j <= b.size(); ++j) {
            const size_t replace = one_back[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
            row[j] = std::min({one_back[j] + 1, row[j - 1] + 1, replace});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                row[j] = std::min(row[j], two_back[j - 2] + 1);
        }
        std::swap(two_back, one_back);
        std::swap(one_back, row);
    }
    return one_back[b.size()];
}

/// The known name nearest to a misspelt one: at most a third of its length in edits (one edit for short names), letters
/// of either case alike. Empty when none is near. The first wins a tie.
inline std::string nearest_name(const std::string& wrong, const std::vector<std::string>& known) {
    if (wrong.empty() || wrong.size() > nearest_name_detail::kLongestName) return {};
    const std::string wrong_lower = nearest_name_detail::lower_case(wrong);
    const size_t allowed = std::max<size_t>(1, wrong.size() / 3);
    size_t best_distance = allowed + 1;
    std::string best;
    for (const std::string& name : known) {
        if (name.size() > wrong.size() + allowed || name.size() + allowed < wrong.size()) continue;
        const size_t distance = edit_distance(wrong_lower, nearest_name_detail::lower_case(name));
        if (distance < best_distance) best_distance = distance, best = name;
    }
    return best;
}

}  // namespace photond
