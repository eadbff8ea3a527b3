#pragma once
// Files to be downloaded: made once, kept by what they hold as long as there is room, readable as long as somebody
// reads them.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "server/service/service_core.h"
#include "server/service/service_types.h"

namespace photond {

/// All without the lock.
class ArtefactFiles {
public:
    explicit ArtefactFiles(ServiceCore& core) : core_(core) {}

    /// The file under `key`, made by `make` where it is not there. Throws NoSpace, and what `make` throws.
    Artefact artefact(const std::string& key, const std::string& media_type, const ArtefactCache::Make& make);
    /// The same where it is there already.
    std::optional<Artefact> kept(const std::string& key, const std::string& media_type);
    /// A file of the store as it is: no copy, and a download that has begun outlives the job. Throws NotFound where the
    /// file has gone meanwhile.
    Artefact linked(const std::string& key, const std::filesystem::path& file, const std::string& media_type);
    /// Named by what it holds: a retried job has others.
    Artefact text_artefact(const std::string& prefix, const std::string& text, const std::string& media_type);

private:
    ServiceCore& core_;
};

/// Throws NoSpace.
void write_text(const std::filesystem::path& path, const std::string& text);
/// Empty of one that is pending.
std::vector<uint8_t> bytes_of(const Artefact& artefact);
/// Nothing is rendered yet: ask again.
Artefact pending_artefact();
/// Gives a file a second name. Throws NotFound where its job has just been removed, NoSpace where it had to be copied.
void link_or_copy(const std::filesystem::path& file, const std::filesystem::path& as);

}  // namespace photond
