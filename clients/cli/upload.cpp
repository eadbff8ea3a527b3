#include "clients/cli/upload.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <random>
#include <set>

#include "clients/cli/failure.h"

namespace photond::cli {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr uint64_t kGltfTextLimitBytes =
    1'000'000'000;  // a .gltf with data URIs may be large, one larger than this is a mistake

std::string suffix_of(const fs::path& path) {
    std::string suffix = path.extension().string();
    std::transform(suffix.begin(), suffix.end(), suffix.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return suffix;
}

bool is_scene_suffix(const std::string& suffix) { return suffix == ".glb" || suffix == ".gltf" || suffix == ".zip"; }

/// Text that no file contains but by a chance of 2^-128.
std::string random_boundary() {
    std::random_device device;
    std::string boundary = "photonctl-";
    constexpr std::string_view kDigits = "0123456789abcdef";
    for (int i = 0; i < 32; ++i) boundary += kDigits[device() & 15U];
    return boundary;
}

/// A file name inside quotes; the backslash form is what the daemon and curl use.
std::string quoted_file_name(const std::string& name) {
    std::string quoted;
    for (const char c : name) {
        if (c == '"' || c == '\\') quoted += '\\';
        quoted += c;
    }
    return quoted;
}

/// Every `uri` of the buffers and images that names a file, decoded, each once.
std::vector<std::string> referenced_files(const json& gltf) {
    std::vector<std::string> files;
    std::set<std::string> seen;
    for (const char* list : {"buffers", "images"}) {
        if (!gltf.contains(list) || !gltf[list].is_array()) continue;
        for (const json& item : gltf[list]) {
            if (!item.is_object() || !item.contains("uri") || !item["uri"].is_string()) continue;
            const std::string uri = item["uri"].get<std::string>();
            if (uri.starts_with("data:")) continue;
            const std::string file = fs::path(percent_decode(uri)).lexically_normal().string();
            if (seen.insert(file).second) files.push_back(file);
        }
    }
    return files;
}

/// `relative` in its normal form.
bool stays_inside(const fs::path& relative) {
    if (relative.is_absolute() || relative.string().find(":/") != std::string::npos) return false;
    return !relative.empty() && *relative.begin() != "..";
}

Upload plan_gltf_upload(const fs::path& gltf_file) {
    std::error_code ignored;
    if (fs::file_size(gltf_file, ignored) > kGltfTextLimitBytes)
        throw Failure(ExitCode::Usage, gltf_file.string() + " is larger than 1 GB, too large for a .gltf",
                      "store its buffers in .bin files or make it a .glb");
    std::ifstream in(gltf_file, std::ios::binary);
    const json gltf = json::parse(in, nullptr, false);
    if (!gltf.is_object())
        throw Failure(ExitCode::Usage, gltf_file.string() + " is not a JSON object, so it is no .gltf");

    Upload upload;
    upload.files.push_back(gltf_file.filename().string());
    std::string faults;
    const fs::path root = gltf_file.parent_path();
    for (const std::string& file : referenced_files(gltf)) {
        if (!stays_inside(file))
            faults += "\n  " + file + ": lies outside the folder of the .gltf";
        else if (!fs::is_regular_file(root / file))
            faults += "\n  " + file + ": no such file in " + (root.empty() ? "." : root.string());
        upload.files.push_back(file);
    }
    if (!faults.empty())
        throw Failure(ExitCode::Usage, gltf_file.string() + " refers to files that cannot be sent:" + faults);

    const std::string boundary = random_boundary();
    upload.content_type = "multipart/form-data; boundary=" + boundary;
    upload.body = std::make_unique<SegmentedBody>();
    for (const std::string& file : upload.files) {
        upload.body->add_text("--" + boundary + "\r\nContent-Disposition: form-data; name=\"file\"; filename=\"" +
                              quoted_file_name(file) + "\"\r\nContent-Type: " +
                              (file == upload.files.front() ? "model/gltf+json" : "application/octet-stream") +
                              "\r\n\r\n");
        upload.body->add_file(root / file);
        upload.body->add_text("\r\n");
    }
    upload.body->add_text("--" + boundary + "--\r\n");
    return upload;
}

/// The one scene file of a folder: a .gltf before a .glb before a .zip; two of the foremost kind are a question back.
fs::path scene_file_in(const fs::path& folder) {
    for (const char* suffix : {".gltf", ".glb", ".zip"}) {
        std::vector<fs::path> found;
        for (const fs::directory_entry& entry : fs::directory_iterator(folder))
            if (entry.is_regular_file() && suffix_of(entry.path()) == suffix) found.push_back(entry.path());
        std::sort(found.begin(), found.end());
        if (found.size() == 1) return found.front();
        if (found.size() > 1)
            throw Failure(ExitCode::Usage,
                          folder.string() + " holds " + std::to_string(found.size()) + " files *" + suffix +
                              ": which one is meant?",
                          "give the file itself, for example " + found.front().string());
    }
    throw Failure(ExitCode::Usage, folder.string() + " holds no .gltf, .glb or .zip");
}

}  // namespace

void SegmentedBody::add_text(std::string text) {
    const uint64_t size = text.size();
    segments_.push_back({size_bytes_, size, std::move(text), {}});
    size_bytes_ += size;
}

void SegmentedBody::add_file(const fs::path& file) {
    std::error_code error;
    const uint64_t size = fs::is_regular_file(file, error) ? fs::file_size(file, error) : 0;
    if (error || !fs::is_regular_file(file) || !std::ifstream(file, std::ios::binary))
        throw Failure(ExitCode::Usage, "cannot read " + file.string() + (error ? ": " + error.message() : ""));
    segments_.push_back({size_bytes_, size, {}, file});
    size_bytes_ += size;
}

size_t SegmentedBody::read(uint64_t offset, char* buffer, size_t capacity) {
    const auto after = std::upper_bound(segments_.begin(), segments_.end(), offset,
                                        [](uint64_t at, const Segment& segment) { return at < segment.begin; });
    const Segment& segment =
        *std::prev(after);  // an empty segment shares its begin with the next, which is found instead
    const uint64_t inside = offset - segment.begin;
    const size_t count = static_cast<size_t>(std::min<uint64_t>(capacity, segment.size_bytes - inside));
    if (segment.file.empty()) {
        segment.text.copy(buffer, count, static_cast<size_t>(inside));
        return count;
    }
    if (open_segment_ != &segment) {
        open_file_ = std::ifstream(segment.file, std::ios::binary);
        open_segment_ = &segment;
    }
    if (static_cast<uint64_t>(open_file_.tellg()) != inside) open_file_.seekg(static_cast<std::streamoff>(inside));
    open_file_.read(buffer, static_cast<std::streamsize>(count));
    if (static_cast<size_t>(open_file_.gcount()) != count)
        throw Failure(ExitCode::Usage, segment.file.string() + " became shorter, or unreadable, while it was sent");
    return count;
}

bool looks_like_scene_path(const std::string& argument) {
    std::error_code ignored;
    // Built-in scenes of a family have one slash within their names.
    const bool of_family = std::count(argument.begin(), argument.end(), '/') == 1 && !argument.ends_with('/') &&
                           std::string("./~").find(argument.front()) == std::string::npos &&
                           !fs::exists(argument, ignored);
    return is_scene_suffix(suffix_of(argument)) || (argument.find('/') != std::string::npos && !of_family) ||
           fs::is_directory(argument, ignored);
}

Upload plan_scene_upload(const fs::path& path) {
    std::error_code ignored;
    if (!fs::exists(path, ignored)) throw Failure(ExitCode::Usage, path.string() + ": no such file or folder");
    const bool folder = fs::is_directory(path, ignored);
    const fs::path file = folder ? scene_file_in(path) : path;
    const std::string suffix = suffix_of(file);
    if (!is_scene_suffix(suffix))
        throw Failure(ExitCode::Usage, file.string() + " is no scene: .glb, .gltf, .zip or a folder with one is");

    Upload upload;
    if (suffix == ".gltf") {
        upload = plan_gltf_upload(file);
    } else {
        upload.body = std::make_unique<SegmentedBody>();
        upload.body->add_file(file);
        upload.content_type = suffix == ".glb" ? "model/gltf-binary" : "application/zip";
        upload.files.push_back(file.filename().string());
    }
    upload.name = file.stem().string();
    return upload;
}

Upload plan_image_upload(const fs::path& path) {
    const std::string suffix = suffix_of(path);
    if (suffix != ".exr" && suffix != ".hdr")
        throw Failure(ExitCode::Usage, path.string() + " is no image the daemon takes: .exr or .hdr is");
    Upload upload;
    upload.body = std::make_unique<SegmentedBody>();
    upload.body->add_file(path);
    upload.content_type = suffix == ".exr" ? "image/x-exr" : "image/vnd.radiance";
    upload.name = path.stem().string();
    upload.files.push_back(path.filename().string());
    return upload;
}

}  // namespace photond::cli
