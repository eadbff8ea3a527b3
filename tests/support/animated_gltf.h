#pragma once
// Animated glTF files made in code: each has one trap that loaders fall into.

#include <ostream>
#include <string>
#include <vector>

#include "tests/support/test_gltf.h"

namespace photond::test {

struct AnimatedFile {
    const char* name;
    TestGltf gltf;

    friend void PrintTo(const AnimatedFile& file, std::ostream* out) { *out << file.name; }
};

/// All of whose vertices gltf_equations.h can evaluate.
const std::vector<AnimatedFile>& animated_files();
/// One of them by name, or one of those that drive what gltf_equations.h leaves out.
TestGltf animated_file(const std::string& name);
/// Without animation.
TestGltf plain_square();

struct FaultyAnimation {
    const char* name;
    TestGltf gltf;
    std::string pointer, detail;  // of the complaint, which has that among other things
};
std::vector<FaultyAnimation> faulty_animations();

}  // namespace photond::test
