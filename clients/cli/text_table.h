#pragma once
// Aligned tables for people.

#include <iosfwd>
#include <string>
#include <vector>

namespace photond::cli {

enum class Align : unsigned char { Left, Right };

/// Columns as wide as their widest cell, two spaces between them, no trailing blanks.
class TextTable {
public:
    struct Column {
        std::string title;
        Align align = Align::Left;
    };
    explicit TextTable(std::vector<Column> columns) : columns_(std::move(columns)) {}

    /// As many cells as there are columns.
    void add_row(std::vector<std::string> cells);
    bool empty() const { return rows_.empty(); }
    /// The titles are left out when every one is empty.
    void print(std::ostream& out, const std::string& indent = "") const;

private:
    std::vector<Column> columns_;
    std::vector<std::vector<std::string>> rows_;
};

}  // namespace photond::cli
