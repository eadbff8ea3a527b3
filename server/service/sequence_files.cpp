#include "server/service/sequence_files.h"

#include <cstdio>

#include "protocol/helper_messages.h"
#include "renderer/core/sha256.h"

namespace photond {

using nlohmann::json;

Artefact SequenceFiles::frames_zip(const std::string& id, const std::string& images) {
    if (images != "exr" && images != "png")
        throw Error(ErrorCode::OutOfRange, "/images", "images = '" + images + "' is neither exr nor png");
    const json sequence = sequences_.get_sequence(id);
    PackRequest pack;
    std::vector<Artefact> held;  // so that no picture goes before it is packed
    std::string names;
    for (const json& frame : sequence.at("frames")) {
        if (frame.at("state") != "succeeded") continue;
        const auto job = frame.at("id").get<std::string>();
        Artefact image =
            images == "exr" ? jobs_.artefacts.image(job, "float") : jobs_.artefacts.preview(job, PreviewWanted());
        if (image.pending) continue;
        char name[32];
        std::snprintf(name, sizeof name, "%04d.%s", frame.at("frame").get<int>(), images.c_str());
        pack.items.push_back({image.path, name});
        names += name + (" " + image.etag) + "\n";
        held.push_back(std::move(image));
    }
    if (pack.items.empty()) return pending_artefact();
    // Goes with the sequence (Purges::finish_purge()).
    const std::string key = "comparison/" + std::to_string(group_seq(GroupKind::Sequence, id)) + "/" + images + "/" +
                            sha256_hex(names.data(), names.size());
    return artefact_files_.artefact(key, "application/zip", [&](const std::filesystem::path& path) {
        pack.out = path;
        core_.helper->ask(pack);
        return std::map<std::string, std::string>();
    });
}

}  // namespace photond
