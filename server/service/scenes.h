#pragma once
// Scenes, uploaded and built-in: spooled by the routes, judged by the helper, moved into place, and only then named by
// a row.

#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "protocol/message_parts.h"
#include "server/service/artefact_files.h"
#include "server/service/pictures.h"
#include "server/service/service_core.h"
#include "server/service/service_types.h"

namespace photond {

struct SceneRef {
    std::string id;
    bool builtin = false;
    std::optional<SceneRow> row;  // of an uploaded one
};

/// Functions take the lock where they need it and say nothing else; those that wait for the helper do so without it.
class Scenes {
public:
    Scenes(ServiceCore& core, ArtefactFiles& artefact_files, Pictures& pictures)
        : core_(core), artefact_files_(artefact_files), pictures_(pictures) {}

    /// Waits for the helper's verdict. Throws BadScene with JSON pointers into the glTF; OutOfRange and Conflict for
    /// its name.
    Added add_scene(SceneUpload upload);
    /// Waits for the helper the first time. Throws NotFound, as all do that are given a name.
    nlohmann::json get_scene(const std::string& id_or_name);
    /// Throws WrongState while a job that is not over uses it, and for a built-in one. Returns the object deleted.
    nlohmann::json delete_scene(const std::string& id_or_name);
    /// Uploaded scenes, then built-in ones; or the built-in ones of a family. Waits for the helper the first time.
    /// Throws OutOfRange, UnknownName.
    Page list_scenes(const std::string& family, uint32_t limit, const std::string& cursor);
    /// Waits for the helper the first time. Throws TryLater (Pictures::picture).
    Artefact thumbnail(const std::string& id_or_name);
    /// A PNG; kept only where it is drawn while a job renders. Waits for the helper. Throws UnknownName at /camera, and
    /// TryLater.
    DrawnPreview scene_preview(const std::string& id_or_name, const ScenePreview& wanted);
    /// Waits for the helper the first time. Throws OutOfMemory, NoSpace and TimedOut where it is too large to be made.
    Artefact baked_scene(const std::string& id_or_name);

    /// A built-in scene as clients see it. Without the lock: waits for the helper the first time.
    nlohmann::json builtin_object(const std::string& name);
    /// Has it judged if it is a built-in one, so that a job of it is estimated by what it is, and its summary read;
    /// without the lock. Where the helper cannot, the job is estimated without.
    void know_scene(const std::string& id_or_name);

    /// Under the lock.
    std::optional<SceneRef> find_scene(const std::string& id_or_name);

    // With the lock or without it:
    /// What the helper said of the scene; an empty object for a built-in one that is not judged yet. Does not wait.
    /// That of the uploaded scene asked for last is there at once: it may be long, and is asked for several times in a
    /// row.
    std::shared_ptr<const nlohmann::json> summary_of(const SceneRef& scene);
    /// Where processes of ours find it.
    SceneSource scene_source(const SceneRef& scene) const;

private:
    SceneRef require_scene(const std::string& id_or_name);  // takes the lock
    Page list_family(const std::string& family, uint32_t limit, const std::string& cursor);

    ServiceCore& core_;
    ArtefactFiles& artefact_files_;
    Pictures& pictures_;
    std::mutex summaries_mutex_;  // taken after the lock where both are held
    std::map<std::string, std::shared_ptr<const nlohmann::json>> builtin_summaries_;
    std::string last_text_;  // of the uploaded scene asked for last
    std::shared_ptr<const nlohmann::json> last_summary_;
};

}  // namespace photond
