#include "server/service/images.h"

#include <algorithm>

#include "protocol/helper_messages.h"
#include "server/clock_text.h"
#include "server/service/pixel_files.h"
#include "server/service/uploads.h"

namespace photond {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr double kMostDecodingSeconds = 5;  // of a processor: 64 million pixels of four half channels take 3

json image_object(const ImageRow& row) {
    return {{"id", row.id},
            {"media_type", row.media_type},
            {"width", row.width},
            {"height", row.height},
            {"channels", row.channels},
            {"bytes", row.bytes},
            {"layers", row.layers.empty() ? json::array() : json::parse(row.layers)}};
}

/// As a row keeps them.
std::string layers_text(const JudgeImageReply& image) {
    return part_json(image.layers).dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace

Added Images::add_image(const fs::path& path, const std::string& media_type) {
    Spooled spooled{path};
    std::string extension;
    if (media_type == "image/x-exr" || media_type == "image/exr" || media_type == "image/aces")
        extension = ".exr";
    else if (media_type == "image/vnd.radiance" || media_type == "image/hdr" || media_type == "image/x-hdr")
        extension = ".hdr";
    else
        throw Error(ErrorCode::WrongMediaType,
                    "images are image/x-exr or image/vnd.radiance, not '" + media_type + "'");
    ImageRow row;
    row.id = hash_file(path).substr(0, kContentIdDigits);
    row.media_type = extension == ".exr" ? "image/x-exr" : "image/vnd.radiance";
    row.file = row.id + extension;
    if (const auto known = find_image(row.id)) return {image_object(*known), false};
    // The reader is chosen by the name's ending, so that what claims to be one format is not read as another.
    const fs::path named = path.string() + extension;
    fs::rename(path, named);
    spooled.path = named;
    const JudgeImageReply found = judged(
        ErrorCode::BadImage, [&] { return core_.bulk_helper->ask(JudgeImageRequest{named}, kMostDecodingSeconds); });
    row.width = found.width;
    row.height = found.height;
    row.channels = found.channels;
    row.layers = layers_text(found);
    row.bytes = static_cast<int64_t>(fs::file_size(named));
    row.created_ms = now_ms();

    const std::lock_guard publish_lock(core_.publish_mutex);
    {
        const std::lock_guard lock(core_.mutex);
        if (const auto known = core_.store.image(row.id)) return {image_object(*known), false};
    }
    const std::string place = path_of_image(row.file);
    core_.note_upload(place);
    sync_path(named);
    publish(named, core_.files.images / row.file);
    spooled.path.clear();
    const std::lock_guard lock(core_.mutex);
    auto transaction = core_.store.transaction();
    core_.store.forget_unnamed_file(place);
    core_.store.insert_image(row);
    transaction.commit();
    return {image_object(row), true};
}

std::optional<ImageRow> Images::find_image(const std::string& id) {
    std::optional<ImageRow> row;
    {
        const std::lock_guard lock(core_.mutex);
        row = core_.store.image(id);
    }
    if (!row || !row->layers.empty()) return row;
    row->layers = layers_text(core_.helper->ask(JudgeImageRequest{core_.files.images / row->file}));
    const std::lock_guard lock(core_.mutex);
    core_.store.set_image_layers(id, row->layers);
    return row;
}

ImageRow Images::require_image(const std::string& id) {
    if (auto row = find_image(id)) return *std::move(row);
    throw Error(ErrorCode::NotFound, "there is no image '" + id + "'");
}

json Images::get_image(const std::string& id) { return image_object(require_image(id)); }

Artefact Images::image_file(const std::string& id) {
    const ImageRow row = require_image(id);
    Artefact whole;
    whole.path = core_.files.images / row.file;
    whole.media_type = row.media_type;
    whole.etag = row.id;
    whole.bytes = static_cast<uint64_t>(row.bytes);
    return whole;
}

Artefact Images::image_pixels(const std::string& id, const std::string& layer, const std::string& precision) {
    require_precision(precision);
    const ImageRow row = require_image(id);
    const std::string name = layer.empty() ? "beauty" : layer;
    std::vector<std::string> known;
    std::string there;
    for (const json& one : json::parse(row.layers)) {
        known.push_back(one.at("name").get<std::string>());
        there += (there.empty() ? "it has " : ", ") + known.back();
    }
    if (std::find(known.begin(), known.end(), name) == known.end())
        throw Error(ErrorCode::UnknownName, "/layer",
                    "image " + id + " has no layer '" + name + "'; " + (there.empty() ? "it has none" : there));
    return artefact_files_.artefact(
        "image/" + id + "/raw/" + name + "/" + precision, "application/octet-stream", [&](const fs::path& path) {
            return pixel_headers(
                core_.helper->ask(EncodePixelsRequest{.source = {.image = core_.files.images / row.file},
                                                      .layer = name,
                                                      .precision = precision,
                                                      .out = path}));
        });
}

}  // namespace photond
