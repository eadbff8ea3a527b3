#include "server/service/job_artefacts.h"

#include <algorithm>
#include <cmath>

#include "protocol/object_reader.h"
#include "protocol/worker_messages.h"
#include "renderer/methods/registry.h"
#include "server/clock_text.h"
#include "server/service/pixel_files.h"

namespace photond {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr uint32_t kLeastPreviewSide = 16, kGreatestPreviewSide = 4096;

/// Of the beauty or a layer by its name; None where there is no such layer.
LayerPreview preview_of_name(const std::string& name) {
    if (name == "beauty") return LayerPreview::Light;
    const LayerInfo* info = find_layer(name);
    return info ? info->preview : LayerPreview::None;
}

std::string curve_csv(const json& curve) {
    std::vector<std::string> metrics;  // in the order in which they were first measured
    for (const json& point : curve) {
        const json values = point.value("metrics", json::object());
        for (const auto& [metric, value] : values.items())
            if (std::find(metrics.begin(), metrics.end(), metric) == metrics.end()) metrics.push_back(metric);
    }
    std::string text = "seconds,passes,photons";
    for (const std::string& metric : metrics) text += "," + metric;
    text += "\n";
    const auto cell = [](const json& value) { return value.is_null() ? std::string() : value.dump(); };
    for (const json& point : curve) {
        text += cell(point.value("seconds", json())) + "," + cell(point.value("passes", json())) + "," +
                cell(point.value("photons", json()));
        const json values = point.value("metrics", json::object());
        for (const std::string& metric : metrics) text += "," + cell(values.value(metric, json()));
        text += "\n";
    }
    return text;
}

}  // namespace

Artefact JobArtefacts::encoded(const std::string& id, const std::string& what, const std::string& media_type,
                               const Encode& encode) {
    FilmSource film = films_.film_source(id);
    if (film.pending) return pending_artefact();
    return artefact_files_.artefact(film.cache_key + "/" + what, media_type, [&](const fs::path& path) {
        films_.pin(film);
        return pixel_headers(encode(film, path));
    });
}

Artefact JobArtefacts::image(const std::string& id, const std::string& precision) {
    require_precision(precision);
    // What such a file says is in its key: a cache may hold those of an older version.
    return encoded(
        id, "exr-with-request/" + precision, "image/x-exr", [&](const FilmSource& film, const fs::path& out) {
            return core_.helper->ask(EncodeExrRequest{film.path, film.statistics, film.request, precision, out});
        });
}

void JobArtefacts::check_look(const PreviewWanted& wanted) {
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
}

Artefact JobArtefacts::preview(const std::string& id, const PreviewWanted& wanted) {
    check_look(wanted);
    const double exposure = wanted.exposure_stops;
    const json max_size = wanted.max_size ? json(*wanted.max_size) : json();
    return encoded(id, "png/" + wanted.layer + "/" + wanted.curve + "/" + json(exposure).dump() + "/" + max_size.dump(),
                   "image/png", [&](const FilmSource& film, const fs::path& out) {
                       return core_.helper->ask(
                           EncodePreviewRequest{film.path, wanted.layer, exposure, wanted.curve, wanted.max_size, out});
                   });
}

Artefact JobArtefacts::pixels(const std::string& id, const std::string& layer, const std::string& precision) {
    require_precision(precision);
    const std::string name = layer.empty() ? "beauty" : layer;
    if (name != "beauty" && !find_layer(name))
        throw Error(ErrorCode::UnknownName, "/layer", "'" + name + "' is no layer");
    return encoded(id, "raw/" + name + "/" + precision, "application/octet-stream",
                   [&](const FilmSource& film, const fs::path& out) {
                       return core_.helper->ask(EncodePixelsRequest{{.film = film.path}, name, precision, out});
                   });
}

Artefact JobArtefacts::statistics(const std::string& id) {
    JobRow row;
    {
        const std::lock_guard lock(core_.mutex);
        row = objects_.require_job(id);
    }
    if (!is_over(row.state)) return pending_artefact();
    if (row.statistics.empty()) throw Error(ErrorCode::NotFound, "job " + id + " ended without statistics");
    return artefact_files_.text_artefact("job/" + std::to_string(row.seq) + "/statistics/", row.statistics,
                                         "application/json");
}

Artefact JobArtefacts::method_artefact(const std::string& id, const std::string& name) {
    JobRow row;
    fs::path file;  // where it was kept
    {
        const std::lock_guard lock(core_.mutex);
        row = objects_.require_job(id);
        const json kept = is_over(row.state) ? json::parse(row.artefacts) : json::array();
        if (std::find(kept.begin(), kept.end(), json(name)) != kept.end())
            file = require_kept(artefact_path(core_.files.films / row.film, name), id);
    }
    const auto known = all_artefacts();
    const auto info = std::find_if(known.begin(), known.end(), [&](const ArtefactInfo& a) { return a.name == name; });
    if (info == known.end()) throw Error(ErrorCode::NotFound, "there is no artefact '" + name + "'");
    if (!file.empty())
        return artefact_files_.linked("job/" + std::to_string(row.seq) + "/" + file.filename().string(), file,
                                      std::string(info->media_type));
    const std::string what(info->text), parameter(info->parameter);
    const MethodInfo* method = find_method(row.method);
    if (!method || !method->find_artefact(name))
        throw Error(ErrorCode::NotFound, "job " + id + " has no " + what + ": " + row.method + " keeps none");
    if (!json::parse(row.request)["method"]["parameters"].value(parameter, false))
        throw Error(ErrorCode::NotFound,
                    "job " + id + " has no " + what + ": ask for it with method.parameters." + parameter);
    if (!is_over(row.state)) return pending_artefact();
    throw Error(ErrorCode::NotFound,
                "job " + id + " " + std::string(job_state_name(row.state)) + " without leaving its " + what);
}

Artefact JobArtefacts::log(const std::string& id) {
    std::string text;
    int64_t seq = 0;
    {
        const std::lock_guard lock(core_.mutex);
        seq = objects_.require_job(id).seq;
        for (const auto& [at_ms, line] : core_.store.log(seq)) text += rfc3339(at_ms) + " " + line + "\n";
    }
    return artefact_files_.text_artefact("job/" + std::to_string(seq) + "/log/", text, "text/plain; charset=utf-8");
}

Artefact JobArtefacts::curve_file(const std::string& id) {
    json curve;
    JobRow row;
    {
        const std::lock_guard lock(core_.mutex);
        row = objects_.require_job(id);
        curve = objects_.job_object(row)["curve"];
    }
    if (curve.is_null()) {
        if (is_over(row.state)) throw Error(ErrorCode::NotFound, "job " + id + " ended without a point of a curve");
        return pending_artefact();
    }
    const std::string text = curve_csv(curve);
    return artefact_files_.text_artefact("job/" + std::to_string(row.seq) + "/curve/", text, "text/csv");
}

Artefact JobArtefacts::film(const std::string& id) {
    const FilmSource film = films_.film_source(id);
    if (film.pending) return pending_artefact();
    return artefact_files_.linked(film.cache_key + "/film", film.path, "application/octet-stream");
}

}  // namespace photond
