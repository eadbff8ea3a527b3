#pragma once
// Which files a worker may open in the sandbox: those the daemon names, and those its libraries and drivers open by
// themselves.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace photond {

enum class FileUse : uint8_t {
    Read,     // files are read, folders listed
    Execute,  // and a file becomes this process
    Write,    // files are read, made, written, renamed and removed
    Device,   // a device's node is read, written and steered by ioctl
};

/// A file, or a folder with all that lies below it.
struct FileRule {
    std::filesystem::path path;
    FileUse use = FileUse::Read;
    bool needed = false;  // one that is not there is a failure and no matter of course
};

/// What the C library, the image library's modules, TBB and this service's own meters read. Of /proc the kernel shows a
/// process in the sandbox nothing of another's memory, descriptors or environment.
std::vector<FileRule> library_files();
/// What Vulkan's loader, its layers and the drivers of AMD, Intel, Mesa and NVIDIA open: their folders, the nodes of
/// their devices, the caches of compiled shaders, and what the loader's variables name (VK_DRIVER_FILES and the like).
std::vector<FileRule> driver_files();

/// Has the drivers keep what they compile in this folder, unless the environment names another: the home that they
/// would take may be nobody's to write.
void keep_shader_caches_in(const std::filesystem::path& folder);

/// The rules with absolute paths, links resolved, those that are not there left out, one for each path: the widest
/// use. Sorted, so that a folder comes before what lies in it. Throws photond::Error (Internal) for one that is needed
/// and not there.
std::vector<FileRule> resolved(const std::vector<FileRule>& rules);

}  // namespace photond
