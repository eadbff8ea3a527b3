// photonctl: the command line client of photond.

#include "clients/cli/program.h"

int main(int argc, char** argv) { return photond::cli::photonctl({argv + 1, argv + argc}); }
