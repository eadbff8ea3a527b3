#pragma once
// photond --check and --repair: the data folder of a daemon that does not run, row by row and file by file.

#include <filesystem>
#include <string>
#include <vector>

namespace photond {

/// What is wrong, a line each; empty: nothing. Reads every file and writes none. Throws Unavailable while a daemon
/// runs on it.
std::vector<std::string> check_data_folder(const std::filesystem::path& folder);

/// Does what a start does with what it finds, and sets right what check_data_folder() names: rows whose files are gone
/// or damaged say so from here on. What was done, a line each. Throws where the store itself is damaged.
std::vector<std::string> repair_data_folder(const std::filesystem::path& folder);

}  // namespace photond
