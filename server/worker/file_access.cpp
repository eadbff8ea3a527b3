#include "server/worker/file_access.h"

#include <spdlog/spdlog.h>

#include <string>

#include "server/worker/landlock.h"
#include "server/worker/mount_namespace.h"

namespace photond {

FileAccess bound_file_access(const std::vector<FileRule>& rules) {
    if (const int version = landlock_version(); version > 0) {
        enter_landlock(version, resolved(rules));
        return {FileAccess::kLandlock, version};
    }
    const std::string reason = enter_mount_namespace(rules);
    if (reason.empty()) return {FileAccess::kMountNamespace, std::nullopt};
    spdlog::warn("this process may open any file of its user: the kernel has no Landlock, and {}", reason);
    return {FileAccess::kNone, std::nullopt};
}

}  // namespace photond
