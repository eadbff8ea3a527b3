#pragma once
// A small glTF file put together by a test: binary data by accessor, everything else as JSON text.

#include <algorithm>
#include <cstring>
#include <fstream>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "renderer/scene/scene.h"
#include "renderer/scene/texture_decode.h"
#include "tests/support/temporary_folder.h"

namespace photond {

template <class T>
std::vector<uint8_t> bytes_of(const std::vector<T>& values) {
    std::vector<uint8_t> bytes(values.size() * sizeof(T));
    std::memcpy(bytes.data(), values.data(), bytes.size());
    return bytes;
}

class TestGltf {
public:
    static constexpr int kI8 = 5120, kU8 = 5121, kI16 = 5122, kU16 = 5123, kU32 = 5125, kF32 = 5126;

    TestGltf() {
        members_["asset"] = R"({"version":"2.0"})";
        members_["scenes"] = R"([{"nodes":[0]}])";
        members_["nodes"] = R"([{"mesh":0}])";
    }

    /// Appends a buffer view with these bytes; `extra` is more JSON members, with a leading comma.
    int view(const std::vector<uint8_t>& data, const std::string& extra = "") {
        binary_.resize((binary_.size() + 3) / 4 * 4);
        const size_t offset = binary_.size();
        binary_.insert(binary_.end(), data.begin(), data.end());
        return add(views_, R"({"buffer":0,"byteOffset":)" + std::to_string(offset) + R"(,"byteLength":)" +
                               std::to_string(data.size()) + extra + "}");
    }
    int raw_view(const std::string& json) { return add(views_, json); }
    /// Appends an accessor; view -1: none.
    int accessor(int view, int component, const std::string& type, size_t count, const std::string& extra = "") {
        return add(accessors_, "{" + (view < 0 ? "" : R"("bufferView":)" + std::to_string(view) + ",") +
                                   R"("componentType":)" + std::to_string(component) + R"(,"type":")" + type +
                                   R"(","count":)" + std::to_string(count) + extra + "}");
    }
    int floats(const std::string& type, int components, const std::vector<float>& values) {
        return accessor(view(bytes_of(values)), kF32, type, values.size() / static_cast<size_t>(components));
    }
    int positions(const std::vector<float>& xyz) { return floats("VEC3", 3, xyz); }
    int indices(const std::vector<uint16_t>& values) {
        return accessor(view(bytes_of(values)), kU16, "SCALAR", values.size());
    }

    void set(const std::string& key, const std::string& json) { members_[key] = json; }
    const std::string& member(const std::string& key) const { return members_.at(key); }
    /// One mesh of one primitive; `extra` is more members of the primitive, with a leading comma.
    void set_mesh(const std::string& attributes, const std::string& extra = "") {
        set("meshes", R"([{"primitives":[{"attributes":{)" + attributes + "}" + extra + "}]}]");
    }

    std::string json() const {
        std::string text = "{";
        for (const auto& [key, value] : members_) text += "\"" + key + "\":" + value + ",";
        text += R"("bufferViews":)" + array(views_) + R"(,"accessors":)" + array(accessors_);
        text += R"(,"buffers":[{"byteLength":)" + std::to_string(binary_.size()) + extra_of_buffer + "}" +
                extra_buffers + "]}";
        return text;
    }
    const std::vector<uint8_t>& binary() const { return binary_; }

    std::vector<uint8_t> glb() const {
        std::string text = json();
        text.resize((text.size() + 3) / 4 * 4, ' ');
        std::vector<uint8_t> binary = binary_;
        binary.resize((binary.size() + 3) / 4 * 4);
        const auto length = [](size_t n) { return static_cast<uint32_t>(n); };
        const auto header = bytes_of(std::vector<uint32_t>{0x46546C67, 2, length(28 + text.size() + binary.size()),
                                                           length(text.size()), 0x4E4F534A});
        const auto chunk = bytes_of(std::vector<uint32_t>{length(binary.size()), 0x004E4942});
        std::vector<uint8_t> file(header);
        file.insert(file.end(), text.begin(), text.end());
        file.insert(file.end(), chunk.begin(), chunk.end());
        file.insert(file.end(), binary.begin(), binary.end());
        return file;
    }

    Scene load(const LoadLimits& limits = {}) const {
        const TemporaryFolder folder;
        write(folder.path() / "scene.glb", glb());
        return load_gltf(folder.path() / "scene.glb", folder.path(), decode_texture, limits);
    }

    static void write(const std::filesystem::path& path, std::span<const uint8_t> bytes) {
        std::ofstream out(path, std::ios::binary);
        out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    }

    std::string extra_of_buffer;  // more members of buffer 0, with a leading comma
    std::string extra_buffers;    // more buffers, with a leading comma

private:
    static int add(std::vector<std::string>& list, const std::string& json) {
        list.push_back(json);
        return static_cast<int>(list.size()) - 1;
    }
    static std::string array(const std::vector<std::string>& list) {
        std::string text = "[";
        for (const std::string& item : list) text += (text.size() > 1 ? "," : "") + item;
        return text + "]";
    }

    std::map<std::string, std::string> members_;
    std::vector<std::string> views_, accessors_;
    std::vector<uint8_t> binary_;
};

/// Whether one of the scene's warnings says this among other things.
inline bool has_warning(const Scene& scene, const std::string& part) {
    return std::ranges::any_of(scene.warnings, [&](const std::string& w) { return w.find(part) != w.npos; });
}

/// A PNG (8 bits, RGBA, stored without compression) of these texels, row by row from the top.
std::vector<uint8_t> make_png(Size2 size, const std::vector<u8vec4>& texels);

}  // namespace photond
