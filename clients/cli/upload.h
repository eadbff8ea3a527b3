#pragma once
// What is sent for a scene or an image named by path. Files are streamed, never held.

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "clients/cli/http_client.h"

namespace photond::cli {

/// Texts and files one after the other, as one body.
class SegmentedBody final : public BodySource {
public:
    void add_text(std::string text);
    /// Throws Failure(Usage) when it is no readable regular file.
    void add_file(const std::filesystem::path& file);

    uint64_t size_bytes() const override { return size_bytes_; }
    size_t read(uint64_t offset, char* buffer, size_t capacity) override;

private:
    struct Segment {
        uint64_t begin;  // in the whole body
        uint64_t size_bytes;
        std::string text;
        std::filesystem::path file;  // empty for a text
    };
    std::vector<Segment> segments_;
    uint64_t size_bytes_ = 0;
    std::ifstream open_file_;
    const Segment* open_segment_ = nullptr;
};

struct Upload {
    std::unique_ptr<SegmentedBody> body;
    std::string content_type;
    std::string name;                // the path's stem
    std::vector<std::string> files;  // as sent, the scene's own first
};

/// True when the argument is meant as a path: something lies there, or it is written like one (a scene's suffix, a
/// '/').
bool looks_like_scene_path(const std::string& argument);

/// `path`: .glb, .zip, .gltf (sent with every file it refers to), or a folder that holds one of these. Throws
/// Failure(Usage) naming every file that is missing or lies outside the .gltf's own folder.
Upload plan_scene_upload(const std::filesystem::path& path);

/// `path`: .exr or .hdr.
Upload plan_image_upload(const std::filesystem::path& path);

}  // namespace photond::cli
