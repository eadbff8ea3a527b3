#pragma once
// The command line client as a function, for its main() and for tests.

#include <string>
#include <vector>

namespace photond::cli {

/// Does what the arguments (without the program's name) ask for, and writes to standard output and standard error.
/// Returns the exit code (ExitCode); throws nothing that a user can cause.
int photonctl(const std::vector<std::string>& arguments);

}  // namespace photond::cli
