#include "server/service/artefact_files.h"

#include <fstream>

#include "renderer/core/sha256.h"

namespace photond {

namespace fs = std::filesystem;

namespace {

Artefact artefact_of(const std::shared_ptr<const CachedFile>& file, const std::string& media_type) {
    return {false, file->path, media_type, file->etag, file->bytes, file, file->headers};
}

}  // namespace

void write_text(const fs::path& path, const std::string& text) {
    std::ofstream out(path, std::ios::binary);
    out << text;
    out.close();
    if (!out) throw Error(ErrorCode::NoSpace, "cannot write " + path.string());
}

std::vector<uint8_t> bytes_of(const Artefact& artefact) {
    std::ifstream in(artefact.path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

Artefact pending_artefact() {
    Artefact artefact;
    artefact.pending = true;
    return artefact;
}

void link_or_copy(const fs::path& file, const fs::path& as) {
    std::error_code error;
    fs::create_hard_link(file, as, error);
    if (error == std::errc::no_such_file_or_directory)
        throw Error(ErrorCode::NotFound, "the job has just been removed");
    if (error && !fs::copy_file(file, as, error))
        throw Error(error == std::errc::no_space_on_device ? ErrorCode::NoSpace : ErrorCode::Internal,
                    "cannot copy " + file.string() + ": " + error.message());
}

Artefact ArtefactFiles::artefact(const std::string& key, const std::string& media_type,
                                 const ArtefactCache::Make& make) {
    const auto file = core_.artefacts.get(key, core_.files.fresh_cache_path(), [&](const fs::path& path) {
        core_.check_disk(0);
        return make(path);
    });
    return artefact_of(file, media_type);
}

std::optional<Artefact> ArtefactFiles::kept(const std::string& key, const std::string& media_type) {
    const auto file = core_.artefacts.find(key);
    if (!file) return std::nullopt;
    return artefact_of(file, media_type);
}

Artefact ArtefactFiles::linked(const std::string& key, const fs::path& file, const std::string& media_type) {
    const auto found = core_.artefacts.get(key, core_.files.fresh_cache_path(), [&](const fs::path& path) {
        link_or_copy(file, path);
        return std::map<std::string, std::string>();
    });
    return artefact_of(found, media_type);
}

Artefact ArtefactFiles::text_artefact(const std::string& prefix, const std::string& text,
                                      const std::string& media_type) {
    return artefact(prefix + sha256_hex(text.data(), text.size()), media_type, [&](const fs::path& path) {
        write_text(path, text);
        return std::map<std::string, std::string>();
    });
}

}  // namespace photond
