// What can be downloaded of a job: encoded by the helper from the film on the disk, kept by content.

#include <algorithm>
#include <cmath>
#include <fstream>

#include "protocol/worker_messages.h"
#include "renderer/core/sha256.h"
#include "renderer/methods/registry.h"
#include "server/clock_text.h"
#include "server/row_text.h"
#include "server/service_impl.h"

namespace photond {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr uint32_t kLeastPreviewSide = 16, kGreatestPreviewSide = 4096;
constexpr auto kSnapshotPatience = std::chrono::seconds(20);   // for the pass at hand; then 202
constexpr auto kSnapshotAge = std::chrono::milliseconds(500);  // a film younger than this is "so far"

void require_precision(const std::string& precision) {
    BodyFaults faults;
    check_precision(precision, faults);
    faults.throw_if_any();
}

/// Of the beauty or a layer by its name; None where there is no such layer.
LayerPreview preview_of_name(const std::string& name) {
    if (name == "beauty") return LayerPreview::Light;
    const LayerInfo* info = find_layer(name);
    return info ? info->preview : LayerPreview::None;
}

void write_text(const fs::path& path, const std::string& text) {
    std::ofstream out(path, std::ios::binary);
    out << text;
    out.close();
    if (!out) throw Error(ErrorCode::NoSpace, "cannot write " + path.string());
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

Artefact pending() {
    Artefact artefact;
    artefact.pending = true;
    return artefact;
}

}  // namespace

void check_precision(const std::string& precision, BodyFaults& faults) {
    if (precision != "float" && precision != "half")
        faults.add(ErrorCode::OutOfRange, "/precision", "precision = '" + precision + "' is neither float nor half");
}

Artefact Service::Impl::artefact(const std::string& key, const std::string& media_type,
                                 const ArtefactCache::Make& make) {
    const auto file = artefacts.get(key, files.fresh_cache_path(), [&](const fs::path& path) {
        check_disk(0);
        return make(path);
    });
    return {false, file->path, media_type, file->etag, file->bytes, file, file->headers};
}

Artefact Service::Impl::linked(const std::string& key, const fs::path& file, const std::string& media_type) {
    const auto found = artefacts.get(key, files.fresh_cache_path(), [&](const fs::path& path) {
        link_or_copy(file, path);
        return std::map<std::string, std::string>();
    });
    return {false, found->path, media_type, found->etag, found->bytes, found, found->headers};
}

Artefact Service::Impl::text_artefact(const std::string& prefix, const std::string& text,
                                      const std::string& media_type) {
    return artefact(prefix + sha256_hex(text.data(), text.size()), media_type, [&](const fs::path& path) {
        write_text(path, text);
        return std::map<std::string, std::string>();
    });
}

void Service::Impl::pin(FilmSource& film) {
    auto held = std::make_shared<Snapshot>();
    const fs::path name = files.fresh_spool_path();
    link_or_copy(film.path, name);
    held->path = film.path = name;
    film.pin = std::move(held);
}

Service::Impl::FilmSource Service::Impl::film_source(const std::string& id) {
    std::unique_lock lock(mutex);
    const auto give_up = SteadyClock::now() + kSnapshotPatience;
    std::string asked_for;  // the snapshot under way for us
    while (true) {
        const JobRow row = require_job(id);
        const std::string prefix = "job/" + std::to_string(row.seq) + "/";
        if (row.state != JobState::Running) {
            if (!row.film.empty())
                return {false, files.films / row.film, prefix + row.film, parsed_or_null(row.statistics), nullptr};
            if (row.state == JobState::Queued) return {true, {}, {}, nullptr, nullptr};
            throw Error(ErrorCode::NotFound, "job " + id + " " + std::string(job_state_name(row.state)) +
                                                 " before its first pass was done: it has no film");
        }
        RunningAttempt* attempt = running_attempt(row.seq);
        if (!attempt || attempt->passes_done == 0) return {true, {}, {}, nullptr, nullptr};
        if (const auto& snapshot = attempt->snapshot;
            snapshot && (snapshot->passes_done >= attempt->passes_done || snapshot->path == asked_for ||
                         SteadyClock::now() - snapshot->saved < kSnapshotAge))
            return {false, snapshot->path, prefix + snapshot->path.filename().string(), nullptr, snapshot};
        if (asked_for.empty()) {
            asked_for = (files.films / (attempt->film + ".s" + std::to_string(++attempt->snapshots))).string();
            slot_of(row.seq)->process->send({{"type", "snapshot"}, {"job", id}, {"path", asked_for}});
        }
        if (stopping || attempt_changed.wait_until(lock, give_up) == std::cv_status::timeout)
            return {true, {}, {}, nullptr, nullptr};
    }
}

Artefact Service::Impl::encode(const std::string& id, const std::string& what, const std::string& media_type,
                               json request, bool with_statistics) {
    FilmSource film = film_source(id);
    if (film.pending) return pending();
    return artefact(film.cache_key + "/" + what, media_type, [&](const fs::path& path) {
        pin(film);
        request["film"] = film.path.string();
        request["out"] = path.string();
        if (with_statistics) request["statistics"] = film.statistics;
        return pixel_headers(helper->call(request));
    });
}

std::map<std::string, std::string> Service::Impl::pixel_headers(const json& result) {
    std::map<std::string, std::string> headers;
    const std::pair<const char*, const char*> shown[] = {{"width", "X-Image-Width"},
                                                         {"height", "X-Image-Height"},
                                                         {"channels", "X-Image-Channels"},
                                                         {"overflowed", "X-Image-Overflowed"},
                                                         {"mean", "X-Flip-Mean"}};
    for (const auto& [member, header] : shown)
        if (const auto found = result.find(member); found != result.end() && found->is_number())
            headers[header] = found->dump();
    return headers;
}

Artefact Service::image(const std::string& id, const std::string& precision) {
    require_precision(precision);
    return impl_->encode(id, "exr/" + precision, "image/x-exr", {{"type", "encode_exr"}, {"precision", precision}},
                         true);
}

Artefact Service::preview(const std::string& id, const PreviewWanted& wanted) {
    const LayerPreview preview = preview_of_name(wanted.layer);
    const double exposure = wanted.exposure_stops;
    BodyFaults faults;
    if (preview == LayerPreview::None) {
        std::string shown = "beauty";
        for (const LayerInfo& info : kLayers)
            if (info.preview != LayerPreview::None) shown.append(", ").append(info.name);
        faults.add(ErrorCode::UnknownName, "/layer",
                   "'" + wanted.layer + "' is no layer with a preview; those are " + shown);
    }
    if (!(std::abs(exposure) <= 32))
        faults.add(ErrorCode::OutOfRange, "/exposure",
                   "exposure = " + json(exposure).dump() + " is outside [-32, 32] stops");
    if (wanted.curve != "srgb" && wanted.curve != "filmic")
        faults.add(ErrorCode::OutOfRange, "/curve", "curve = '" + wanted.curve + "' is neither srgb nor filmic");
    if (wanted.max_size && (*wanted.max_size < kLeastPreviewSide || *wanted.max_size > kGreatestPreviewSide))
        faults.add(ErrorCode::OutOfRange, "/max_size",
                   "max_size = " + std::to_string(*wanted.max_size) + " is outside [" +
                       std::to_string(kLeastPreviewSide) + ", " + std::to_string(kGreatestPreviewSide) + "]");
    if (preview != LayerPreview::None && !has_exposure(preview) && (exposure != 0 || wanted.curve != "srgb"))
        faults.add(ErrorCode::Conflict, exposure != 0 ? "/exposure" : "/curve",
                   "the preview of " + wanted.layer + " has neither exposure nor tone curve");
    faults.throw_if_any();
    const json max_size = wanted.max_size ? json(*wanted.max_size) : json();
    return impl_->encode(
        id, "png/" + wanted.layer + "/" + wanted.curve + "/" + json(exposure).dump() + "/" + max_size.dump(),
        "image/png",
        {{"type", "encode_preview"},
         {"layer", wanted.layer},
         {"exposure", exposure},
         {"curve", wanted.curve},
         {"max_size", max_size}},
        false);
}

Artefact Service::pixels(const std::string& id, const std::string& layer, const std::string& precision) {
    require_precision(precision);
    const std::string name = layer.empty() ? "beauty" : layer;
    if (name != "beauty" && !find_layer(name))
        throw Error(ErrorCode::UnknownName, "/layer", "'" + name + "' is no layer");
    return impl_->encode(id, "raw/" + name + "/" + precision, "application/octet-stream",
                         {{"type", "encode_pixels"}, {"layer", name}, {"precision", precision}}, false);
}

Artefact Service::Impl::image_pixels(const std::string& id, const std::string& layer, const std::string& precision) {
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
    return artefact("image/" + id + "/raw/" + name + "/" + precision, "application/octet-stream",
                    [&](const fs::path& path) {
                        return pixel_headers(helper->call({{"type", "encode_pixels"},
                                                           {"image", (files.images / row.file).string()},
                                                           {"layer", name},
                                                           {"precision", precision},
                                                           {"out", path.string()}}));
                    });
}

Artefact Service::image_pixels(const std::string& id, const std::string& layer, const std::string& precision) {
    return impl_->image_pixels(id, layer, precision);
}

Artefact Service::Impl::statistics(const std::string& id) {
    JobRow row;
    {
        const std::lock_guard lock(mutex);
        row = require_job(id);
    }
    if (!is_over(row.state)) return pending();
    if (row.statistics.empty()) throw Error(ErrorCode::NotFound, "job " + id + " ended without statistics");
    return text_artefact("job/" + std::to_string(row.seq) + "/statistics/", row.statistics, "application/json");
}

Artefact Service::Impl::method_artefact(const std::string& id, const std::string& name) {
    JobRow row;
    {
        const std::lock_guard lock(mutex);
        row = require_job(id);
    }
    const auto known = all_artefacts();
    const auto info = std::find_if(known.begin(), known.end(), [&](const ArtefactInfo& a) { return a.name == name; });
    if (info == known.end()) throw Error(ErrorCode::NotFound, "there is no artefact '" + name + "'");
    const json kept = json::parse(row.artefacts);
    if (std::find(kept.begin(), kept.end(), json(name)) != kept.end()) {
        const fs::path file = artefact_path(files.films / row.film, name);
        return linked("job/" + std::to_string(row.seq) + "/" + file.filename().string(), file,
                      std::string(info->media_type));
    }
    const std::string what(info->text), parameter(info->parameter);
    const MethodInfo* method = find_method(row.method);
    if (!method || !method->find_artefact(name))
        throw Error(ErrorCode::NotFound, "job " + id + " has no " + what + ": " + row.method + " keeps none");
    if (!json::parse(row.request)["method"]["parameters"].value(parameter, false))
        throw Error(ErrorCode::NotFound,
                    "job " + id + " has no " + what + ": ask for it with method.parameters." + parameter);
    if (!is_over(row.state)) return pending();
    throw Error(ErrorCode::NotFound,
                "job " + id + " " + std::string(job_state_name(row.state)) + " without leaving its " + what);
}

Artefact Service::Impl::log(const std::string& id) {
    std::string text;
    int64_t seq = 0;
    {
        const std::lock_guard lock(mutex);
        seq = require_job(id).seq;
        for (const auto& [at_ms, line] : store.log(seq)) text += rfc3339(at_ms) + " " + line + "\n";
    }
    return text_artefact("job/" + std::to_string(seq) + "/log/", text, "text/plain; charset=utf-8");
}

}  // namespace photond
