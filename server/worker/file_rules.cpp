#include "server/worker/file_rules.h"

#include <algorithm>
#include <cstdlib>
#include <map>
#include <string_view>

#include "protocol/error.h"

namespace photond {

namespace fs = std::filesystem;

namespace {

constexpr const char* kShaderCaches[] = {"MESA_SHADER_CACHE_DIR", "__GL_SHADER_DISK_CACHE_PATH"};  // of Mesa, of NVIDIA

void add(std::vector<FileRule>& rules, FileUse use, std::initializer_list<const char*> paths) {
    for (const char* path : paths) rules.push_back({path, use});
}

/// The paths that a variable names, separated by colons.
void add_named_by(std::vector<FileRule>& rules, FileUse use, std::initializer_list<const char*> variables) {
    for (const char* variable : variables) {
        const char* value = std::getenv(variable);
        for (std::string_view rest = value ? value : ""; !rest.empty();) {
            const std::string_view path = rest.substr(0, rest.find(':'));
            if (!path.empty()) rules.push_back({path, use});
            rest.remove_prefix(std::min(rest.size(), path.size() + 1));
        }
    }
}

/// The entries of a folder whose names begin so.
void add_entries(std::vector<FileRule>& rules, FileUse use, const fs::path& folder, std::string_view beginning) {
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
        if (entry.path().filename().string().starts_with(beginning)) rules.push_back({entry.path(), use});
}

}  // namespace

std::vector<FileRule> library_files() {
    std::vector<FileRule> rules;
    std::error_code error;
    rules.push_back({fs::read_symlink("/proc/self/exe", error).parent_path()});  // photond-images.so lies there
    add(rules, FileUse::Read,
        {"/usr", "/lib", "/lib32", "/lib64", "/opt", "/nix/store", "/etc/alternatives", "/etc/ld.so.cache",
         "/etc/ld.so.preload", "/etc/localtime", "/etc/ssl/openssl.cnf", "/proc", "/sys/devices", "/sys/fs/cgroup",
         "/sys/kernel/mm", "/dev/zero", "/dev/random", "/dev/urandom"});
    add(rules, FileUse::Device, {"/dev/null"});
    add_named_by(rules, FileUse::Read, {"LD_LIBRARY_PATH"});
    return rules;
}

std::vector<FileRule> driver_files() {
    std::vector<FileRule> rules;
    add(rules, FileUse::Read,
        {"/etc/vulkan", "/etc/glvnd", "/etc/drirc", "/etc/nvidia", "/etc/OpenCL", "/etc/ld.so.conf", "/sys/bus",
         "/sys/class", "/sys/dev", "/sys/module", "/run/nvidia-persistenced", "/run/opengl-driver"});
    add(rules, FileUse::Device, {"/dev/dri", "/dev/kfd", "/dev/nvidia-caps", "/dev/udmabuf", "/dev/dma_heap"});
    add_entries(rules, FileUse::Device, "/dev", "nvidia");
    add_named_by(rules, FileUse::Read,
                 {"VK_DRIVER_FILES", "VK_ADD_DRIVER_FILES", "VK_ICD_FILENAMES", "VK_LAYER_PATH", "VK_ADD_LAYER_PATH",
                  "VK_LAYER_SETTINGS_PATH", "XDG_DATA_DIRS", "XDG_CONFIG_DIRS", "LIBGL_DRIVERS_PATH"});
    add_named_by(rules, FileUse::Write, {kShaderCaches[0], kShaderCaches[1], "CUDA_CACHE_PATH"});
    if (const char* home = std::getenv("HOME"); home && *home) {
        for (const char* folder : {".config/vulkan", ".local/share/vulkan"})
            rules.push_back({fs::path(home) / folder, FileUse::Read});
        rules.push_back({fs::path(home) / ".nv", FileUse::Write});
        const char* cache = std::getenv("XDG_CACHE_HOME");
        add_entries(rules, FileUse::Write, cache && *cache ? fs::path(cache) : fs::path(home) / ".cache",
                    "shader_validation_cache");  // of the validation layer
    }
    return rules;
}

void keep_shader_caches_in(const fs::path& folder) {
    for (const char* variable : kShaderCaches) setenv(variable, folder.c_str(), 0);
}

std::vector<FileRule> resolved(const std::vector<FileRule>& rules) {
    std::map<fs::path, FileUse> widest;
    for (const FileRule& rule : rules) {
        std::error_code error;
        const fs::path path = fs::canonical(rule.path, error);
        if (error && rule.needed) throw Error(ErrorCode::Internal, rule.path.string() + ": " + error.message());
        if (error) continue;
        FileUse& use = widest.try_emplace(path, rule.use).first->second;
        use = std::max(use, rule.use);
    }
    std::vector<FileRule> all;
    all.reserve(widest.size());
    for (const auto& [path, use] : widest) all.push_back({path, use, true});
    return all;
}

}  // namespace photond
