// Hostile glTF: the hand-made files of tests/support/malformed_gltf.py, each with the place that must be named, and
// random mutations of a sound file. A crash ends the program and so fails the test; sanitizer builds make it sharper.

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "protocol/error.h"
#include "renderer/scene/scene.h"
#include "renderer/scene/texture_decode.h"
#include "tests/support/temporary_folder.h"

namespace photond::gltf_malformed_test {
namespace {

namespace fs = std::filesystem;

struct MalformedFile {
    std::string name;
    std::string code;
    std::string pointer;
};

std::vector<uint8_t> read_bytes(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

void write_bytes(const fs::path& path, const std::vector<uint8_t>& bytes) {
    std::ofstream out(path, std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

/// Writes the corpus below `folder` with its Python generator and reads the index.
std::vector<MalformedFile> generate_corpus(const fs::path& folder) {
    const std::string generator = std::string(PHOTOND_TEST_DATA) + "/../support/malformed_gltf.py";
    const std::string command =
        "PYTHONDONTWRITEBYTECODE=1 /usr/bin/python3 '" + generator + "' '" + folder.string() + "'";
    if (std::system(command.c_str()) != 0) return {};
    std::vector<MalformedFile> files;
    std::ifstream index(folder / "cases.tsv");
    for (std::string line; std::getline(index, line);) {
        std::istringstream fields(line);
        MalformedFile file;
        std::getline(fields, file.name, '\t');
        std::getline(fields, file.code, '\t');
        std::getline(fields, file.pointer, '\t');
        files.push_back(file);
    }
    return files;
}

bool names_place(const Error& error, const std::string& pointer) {
    if (pointer.empty() && error.faults.empty()) return true;
    for (const Fault& fault : error.faults)
        if (fault.pointer == pointer) return true;
    return false;
}

std::string describe(const Error& error) {
    std::string text = std::string(error_kind(error.code).name) + ": " + error.what();
    for (const Fault& fault : error.faults) text += "\n  at \"" + fault.pointer + "\": " + fault.detail;
    return text;
}

/// What a loaded scene promises to everything after it.
void expect_sound(const Scene& scene) {
    for (const Mesh& mesh : scene.meshes) {
        ASSERT_LT(mesh.material, scene.materials.size());
        for (const size_t size :
             {mesh.normals.size(), mesh.tangents.size(), mesh.uv[0].size(), mesh.uv[1].size(), mesh.colors.size()})
            ASSERT_TRUE(size == 0 || size == mesh.positions.size());
        for (const uvec3& t : mesh.triangles)
            for (int k = 0; k < 3; ++k) ASSERT_LT(t[k], mesh.positions.size());
        for (const vec3& p : mesh.positions) ASSERT_TRUE(is_finite(p));
        for (const vec3& n : mesh.normals) ASSERT_NEAR(glm::length(n), 1, 1e-3);
    }
    for (const Instance& instance : scene.instances) ASSERT_LT(instance.mesh, scene.meshes.size());
    for (const Texture& texture : scene.textures) ASSERT_EQ(texture.texels.size(), texture.size.pixels());
}

TEST(MalformedGltf, EachFileIsRefusedWithItsPlace) {
    const TemporaryFolder folder;
    const std::vector<MalformedFile> files = generate_corpus(folder.path());
    ASSERT_GE(files.size(), 200u);
    for (const MalformedFile& file : files) {
        SCOPED_TRACE(file.name);
        try {
            load_gltf(folder.path() / file.name, folder.path(), decode_texture);
            ADD_FAILURE() << "was loaded";
        } catch (const Error& error) {
            EXPECT_EQ(error_kind(error.code).name, file.code) << describe(error);
            EXPECT_TRUE(names_place(error, file.pointer))
                << "expected \"" << file.pointer << "\", got " << describe(error);
            EXPECT_LT(std::string(error.what()).size(), 1000u);
        }
    }
    EXPECT_NO_THROW(expect_sound(load_gltf(folder.path() / "valid.glb", folder.path(), decode_texture)));
}

/// One random change of the kind a broken exporter, a broken disk or an attacker makes.
std::vector<uint8_t> mutated(std::vector<uint8_t> bytes, std::mt19937_64& random) {
    const auto below = [&random](size_t n) { return static_cast<size_t>(random() % n); };
    const auto count = 1 + below(3);
    for (size_t i = 0; i < count && bytes.size() > 64; ++i) {
        // Half of them in the binary chunk, which is the smaller part, at the end.
        const size_t at =
            below(2) == 0 ? below(bytes.size()) : bytes.size() - 1 - below(std::min<size_t>(bytes.size(), 700));
        switch (below(6)) {
            case 0: bytes[at] = static_cast<uint8_t>(random()); break;
            case 1: bytes[at] ^= static_cast<uint8_t>(1u << below(8)); break;
            case 2: {  // another digit, so that the JSON stays well-formed and its numbers go wrong
                size_t digit = at;
                while (digit < bytes.size() && (bytes[digit] < '0' || bytes[digit] > '9')) ++digit;
                if (digit < bytes.size()) bytes[digit] = static_cast<uint8_t>('0' + below(10));
                break;
            }
            case 3: {  // a piece copied over another
                const size_t from = below(bytes.size()),
                             length = std::min(below(32), bytes.size() - std::max(from, at));
                std::copy_n(std::vector<uint8_t>(bytes).begin() + static_cast<ptrdiff_t>(from), length,
                            bytes.begin() + static_cast<ptrdiff_t>(at));
                break;
            }
            case 4: {  // a float or an index that is extreme
                constexpr uint32_t kExtremes[] = {0,          0xffffffff, 0x7f800000, 0x7fc00000,
                                                  0x80000000, 0x7f7fffff, 0x00000001};
                const uint32_t value = kExtremes[below(std::size(kExtremes))];
                if (at + 4 <= bytes.size())
                    for (size_t k = 0; k < 4; ++k) bytes[at + k] = static_cast<uint8_t>(value >> (8 * k));
                break;
            }
            default: {  // an object's comma or brace
                size_t mark = at;
                constexpr std::string_view kMarks = ",:{}[]";
                while (mark < bytes.size() && kMarks.find(static_cast<char>(bytes[mark])) == kMarks.npos) ++mark;
                if (mark < bytes.size()) bytes[mark] = static_cast<uint8_t>(kMarks[below(kMarks.size())]);
            }
        }
    }
    if (below(20) == 0) bytes.resize(below(bytes.size()));
    return bytes;
}

TEST(MalformedGltf, TwoThousandMutationsLoadSoundlyOrAreRefused) {
    const TemporaryFolder folder;
    ASSERT_FALSE(generate_corpus(folder.path() / "corpus").empty());
    const std::vector<uint8_t> sound = read_bytes(folder.path() / "corpus" / "valid.glb");
    std::mt19937_64 random(20260117);
    int loaded = 0, refused = 0;
    for (int i = 0; i < 2000; ++i) {
        SCOPED_TRACE(i);
        write_bytes(folder.path() / "mutant", mutated(sound, random));
        try {
            expect_sound(load_gltf(folder.path() / "mutant", folder.path(), decode_texture));
            ++loaded;
        } catch (const Error& error) {
            EXPECT_TRUE(error.code == ErrorCode::BadScene || error.code == ErrorCode::BadImage ||
                        error.code == ErrorCode::Unsupported)
                << describe(error);
            ++refused;
        }
    }
    // Were one of the two rare, the mutations would be too wild or too tame to test anything.
    EXPECT_GT(loaded, 200);
    EXPECT_GT(refused, 200);
}

TEST(MalformedGltf, NothingOutsideTheBundleIsRead) {
    const TemporaryFolder folder;
    const fs::path bundle = folder.path() / "bundle";
    fs::create_directories(bundle / "sub");
    write_bytes(folder.path() / "secret.bin", std::vector<uint8_t>(64, 7));
    write_bytes(bundle / "inside.bin", std::vector<uint8_t>(64, 7));
    fs::create_symlink(folder.path() / "secret.bin", bundle / "absolute_link.bin");
    fs::create_symlink("../secret.bin", bundle / "relative_link.bin");
    fs::create_symlink("inside.bin", bundle / "link_inside.bin");
    fs::create_directory_symlink(folder.path(), bundle / "folder_link");
    fs::create_directory_symlink("/proc/self/root", bundle / "magic_link");
    ASSERT_EQ(::mkfifo((bundle / "pipe").c_str(), 0600), 0);

    const auto load = [&](const std::string& uri) {
        std::ofstream(bundle / "scene.gltf")
            << R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":36,"uri":")" << uri << R"("}],)"
            << R"("bufferViews":[{"buffer":0,"byteLength":36}],)"
            << R"("accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":3}],)"
            << R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}]})";
        return load_gltf(bundle / "scene.gltf", bundle, decode_texture);
    };
    for (const char* inside : {"inside.bin", "./inside.bin", "inside%2Ebin", "sub/.//../inside.bin"}) {
        SCOPED_TRACE(inside);
        if (std::string(inside).find("..") == std::string::npos)
            EXPECT_NO_THROW(load(inside));
        else
            EXPECT_THROW(load(inside), Error);
    }
    for (const std::string& uri :
         {std::string("../secret.bin"), std::string("%2e%2e/secret.bin"), std::string("sub/../../secret.bin"),
          (folder.path() / "secret.bin").string(), "file://" + (folder.path() / "secret.bin").string(),
          std::string("absolute_link.bin"), std::string("relative_link.bin"), std::string("link_inside.bin"),
          std::string("folder_link/secret.bin"), std::string("magic_link/etc/hostname"), std::string("pipe"),
          std::string("sub"), std::string("sub/"), std::string("/dev/zero"), std::string("inside.bin/")}) {
        SCOPED_TRACE(uri);
        try {
            load(uri);
            ADD_FAILURE() << "was read";
        } catch (const Error& error) {
            EXPECT_EQ(error.code, ErrorCode::BadScene);
            EXPECT_TRUE(names_place(error, "/buffers/0/uri")) << describe(error);
        }
    }
    EXPECT_THROW(load_gltf(folder.path() / "secret.bin", bundle, decode_texture), Error);
    EXPECT_THROW(load_gltf("../secret.bin", bundle, decode_texture), Error);
}

}  // namespace
}  // namespace photond::gltf_malformed_test
