#include "clients/cli/text_table.h"

#include <algorithm>
#include <cassert>
#include <ostream>

#include "clients/cli/units.h"

namespace photond::cli {

void TextTable::add_row(std::vector<std::string> cells) {
    assert(cells.size() == columns_.size());
    rows_.push_back(std::move(cells));
}

void TextTable::print(std::ostream& out, const std::string& indent) const {
    std::vector<size_t> widths;
    bool titled = false;
    for (size_t column = 0; column < columns_.size(); ++column) {
        size_t width = display_width(columns_[column].title);
        titled = titled || width > 0;
        for (const auto& row : rows_) width = std::max(width, display_width(row[column]));
        widths.push_back(width);
    }
    const auto print_row = [&](const auto& cell_of) {
        std::string line = indent;
        for (size_t column = 0; column < columns_.size(); ++column) {
            const std::string& cell = cell_of(column);
            const std::string padding(widths[column] - display_width(cell), ' ');
            line += columns_[column].align == Align::Left ? cell + padding : padding + cell;
            line += "  ";
        }
        line.erase(line.find_last_not_of(' ') + 1);
        out << line << '\n';
    };
    if (titled) print_row([&](size_t column) -> const std::string& { return columns_[column].title; });
    for (const auto& row : rows_) print_row([&](size_t column) -> const std::string& { return row[column]; });
}

}  // namespace photond::cli
