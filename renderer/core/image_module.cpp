#include "renderer/core/image_module.h"

#include <dlfcn.h>

#include <filesystem>
#include <string>

#include "protocol/error.h"

namespace photond {

namespace {

void* load() {
    const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe");
    void* module = dlopen((program.parent_path() / "photond-images.so").c_str(), RTLD_LAZY | RTLD_LOCAL);
    if (!module) throw Error(ErrorCode::Internal, std::string("the image module cannot be loaded: ") + dlerror());
    return module;
}

}  // namespace

void* find_image_function(const char* name) {
    static void* const module = load();
    void* const function = dlsym(module, name);
    if (!function)
        throw Error(ErrorCode::Internal, std::string("the image module has no function ") + name + ": " + dlerror());
    return function;
}

}  // namespace photond
