#include "renderer/backends/gpu/spirv.h"

#include <algorithm>
#include <bit>
#include <map>
#include <set>
#include <string>

#include "protocol/error.h"

namespace photond::gpu {

namespace {

std::map<std::string_view, const Shader*>& registry() {
    static std::map<std::string_view, const Shader*> shaders;
    return shaders;
}

/// The few instructions of SPIR-V that say what a shader's buffers and constants are. [SPIR-V 1.6, sec. 3.42]
enum Opcode : uint16_t {
    kOpMemberName = 6,
    kOpTypeStruct = 30,
    kOpTypePointer = 32,
    kOpVariable = 59,
    kOpDecorate = 71,
    kOpMemberDecorate = 72
};
enum Decoration : uint32_t { kSpecId = 1, kNonWritable = 24, kBinding = 33, kDescriptorSet = 34 };
constexpr uint32_t kStorageBuffer = 12;

struct Declarations {
    struct Variable {
        uint32_t type;
        uint32_t set = 0, binding = 0;
        bool read_only = false;
    };
    std::map<uint32_t, Variable> variables;             // storage buffers, by id
    std::set<uint32_t> read_only_types;                 // structures with a member that is not writable
    std::map<uint32_t, uint32_t> pointee;               // of pointer types
    std::map<uint32_t, std::string_view> only_members;  // their names, by id of the structures with one member
    std::set<uint32_t> constants;                       // ids of specialisation constants
};

/// A literal string: its bytes lie in the words from the lowest up, and a zero ends it. [SPIR-V 1.6, sec. 2.2.1]
std::string_view text_of(std::span<const uint32_t> words) {
    static_assert(std::endian::native == std::endian::little);
    const std::string_view all(reinterpret_cast<const char*>(words.data()), words.size_bytes());
    return all.substr(0, all.find('\0'));
}

Declarations read(std::span<const uint32_t> words) {
    Declarations found;
    std::map<uint32_t, uint32_t> sets, bindings;
    std::set<uint32_t> read_only;
    constexpr size_t kHeader = 5;
    for (size_t i = kHeader; i < words.size();) {
        const uint32_t length = words[i] >> 16;
        if (length == 0 || i + length > words.size()) throw Error(ErrorCode::Internal, "a shader's SPIR-V is cut off");
        const std::span<const uint32_t> op = words.subspan(i, length);
        switch (op[0] & 0xffffu) {
            case kOpMemberName:
                if (op[2] == 0) found.only_members[op[1]] = text_of(op.subspan(3));
                break;
            case kOpTypeStruct:  // after all names
                if (length != 3) found.only_members.erase(op[1]);
                break;
            case kOpDecorate:
                if (op[2] == kSpecId) found.constants.insert(op[3]);
                if (op[2] == kDescriptorSet) sets[op[1]] = op[3];
                if (op[2] == kBinding) bindings[op[1]] = op[3];
                if (op[2] == kNonWritable) read_only.insert(op[1]);
                break;
            case kOpMemberDecorate:
                if (op[3] == kNonWritable) found.read_only_types.insert(op[1]);
                break;
            case kOpTypePointer: found.pointee[op[1]] = op[3]; break;
            case kOpVariable:
                if (op[3] == kStorageBuffer) found.variables[op[2]] = {op[1]};
                break;
            default: break;
        }
        i += length;
    }
    for (auto& [id, variable] : found.variables) {
        variable.set = sets[id];
        variable.binding = bindings[id];
        variable.read_only = read_only.contains(id) || found.read_only_types.contains(found.pointee[variable.type]);
    }
    return found;
}

}  // namespace

void add_shaders(std::span<const Shader> shaders) {
    for (const Shader& shader : shaders) registry()[shader.source] = &shader;
}

std::vector<ShaderBuffer> buffers_of(std::span<const uint32_t> words) {
    const Declarations found = read(words);
    std::vector<ShaderBuffer> buffers;
    for (const auto& [id, variable] : found.variables) {
        if (variable.set != 0) continue;
        const auto name = found.only_members.find(found.pointee.at(variable.type));
        buffers.push_back({name == found.only_members.end() ? std::string_view() : name->second, variable.binding,
                           variable.read_only});
    }
    std::sort(buffers.begin(), buffers.end(), [](const auto& a, const auto& b) { return a.binding < b.binding; });
    return buffers;
}

std::vector<uint32_t> constants_of(std::span<const uint32_t> words) {
    const Declarations found = read(words);
    return {found.constants.begin(), found.constants.end()};
}

bool uses_scene(std::span<const uint32_t> words) {
    const Declarations found = read(words);
    return std::any_of(found.variables.begin(), found.variables.end(), [](const auto& v) { return v.second.set == 1; });
}

std::span<const Shader> built_in_shaders();  // written by the build

const Shader& find_shader(std::string_view source) {
    static const bool kAdded = [] {
        add_shaders(built_in_shaders());
        return true;
    }();
    static_cast<void>(kAdded);
    const auto found = registry().find(source);
    if (found == registry().end())
        throw Error(ErrorCode::Internal, "there is no shader " + std::string(source) + " in this program");
    return *found->second;
}

}  // namespace photond::gpu
