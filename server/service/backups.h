#pragma once
// A backup is a copy of the store and second names of the files that its rows name, all of one moment, in the spool;
// who asked for it fetches them one by one. Second names take no room, whatever becomes of the first ones meanwhile.

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>

#include "server/service/service_core.h"
#include "server/service/service_types.h"

namespace photond {

/// All take the lock where they need it.
class Backups {
public:
    explicit Backups(ServiceCore& core) : core_(core) {}

    /// Takes the place of an earlier one.
    nlohmann::json make();
    nlohmann::json get(const std::string& id);
    Artefact file(const std::string& id, const std::string& path);
    nlohmann::json remove(const std::string& id);

private:
    struct Backup;

    std::shared_ptr<const Backup> require(const std::string& id);
    /// Second names of what rows name now, under the lock, which is given up in between but for the last time. Those
    /// that are there are not made again, unless a running job may have written its film anew.
    void add_files(Backup& backup, bool last, std::unique_lock<std::mutex>& lock);

    ServiceCore& core_;
    std::mutex making_;  // one at a time
    std::mutex mutex_;   // of what follows
    std::shared_ptr<const Backup> newest_;
};

}  // namespace photond
