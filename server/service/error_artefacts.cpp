#include "server/service/error_artefacts.h"

#include <algorithm>

#include "protocol/object_reader.h"
#include "protocol/param_json.h"
#include "renderer/error/metric.h"
#include "renderer/film/layers.h"
#include "server/service/pixel_files.h"

namespace photond {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr size_t kMaxSourceBytes = 256;
constexpr size_t kMaxMetrics = 256;

std::vector<std::string> radiance_layers() {
    std::vector<std::string> layers{"beauty"};
    for (const LayerInfo& info : kLayers)
        if (info.radiance()) layers.emplace_back(info.name);
    return layers;
}

void check_layer(const std::string& layer, BodyFaults& faults) {
    const std::vector<std::string> known = radiance_layers();
    if (std::find(known.begin(), known.end(), layer) == known.end())
        faults.add(ErrorCode::UnknownName, "/layer",
                   "'" + layer + "' is no layer of radiance" + did_you_mean(layer, known));
}

void check_range(const std::string& range, BodyFaults& faults) {
    if (range != "ldr" && range != "hdr")
        faults.add(ErrorCode::OutOfRange, "/range", "range = '" + range + "' is neither ldr nor hdr");
}

void check_source_name(const std::string& name, const std::string& pointer, BodyFaults& faults) {
    const bool good = (name.starts_with("job:") && name.size() > 4) || (name.starts_with("image:") && name.size() > 6);
    if (!good) faults.add(ErrorCode::UnknownName, pointer, "'" + name + "' is neither \"job:ID\" nor \"image:ID\"");
}

/// The metrics of a body; all there are of the beauty where it names none.
std::vector<std::string> read_metrics(const json* source, BodyFaults& faults) {
    std::vector<std::string> names;
    std::vector<std::string> known;
    for (const MetricInfo& info : kMetrics)
        if (info.needs_reference) known.emplace_back(info.name);
    if (!source) return known;
    if (!source->is_array() || source->empty() || source->size() > kMaxMetrics) {
        faults.add(source->is_array() ? ErrorCode::OutOfRange : ErrorCode::WrongType, "/metrics",
                   "must be an array of 1 to " + std::to_string(kMaxMetrics) + " names");
        return names;
    }
    const std::vector<std::string> layers = radiance_layers();
    for (size_t i = 0; i < source->size(); ++i) {
        const json& name = (*source)[i];
        const std::string pointer = "/metrics/" + std::to_string(i);
        if (!name.is_string()) {
            faults.add(ErrorCode::WrongType, pointer, "must be a string");
            continue;
        }
        const auto text = name.get<std::string>();
        const auto metric = layer_metric_named(text);
        if (!metric || !metric_info(metric->metric).needs_reference)
            faults.add(
                ErrorCode::UnknownName, pointer,
                "'" + text + "' is no metric of two images" +
                    did_you_mean(text.substr(text.find(':') == std::string::npos ? 0 : text.find(':') + 1), known));
        else if (std::find(layers.begin(), layers.end(), metric->layer) == layers.end())
            faults.add(ErrorCode::UnknownName, pointer,
                       "'" + metric->layer + "' is no layer of radiance" + did_you_mean(metric->layer, layers));
        else if (std::find(names.begin(), names.end(), text) != names.end())
            faults.add(ErrorCode::Conflict, pointer, "'" + text + "' is named twice");
        names.push_back(text);
    }
    return names;
}

}  // namespace

ErrorArtefacts::MeasuredPair ErrorArtefacts::measured_pair(const std::string& id) {
    MeasuredPair pair;
    {
        const std::lock_guard lock(core_.mutex);
        const JobRow row = objects_.require_job(id);
        if (json::parse(row.request).value("reference", json()).is_null())
            throw Error(ErrorCode::NotFound, "job " + id + " has no reference to be compared with");
    }
    pair.film = films_.film_source(id);
    if (pair.film.pending) return pair;
    const std::lock_guard lock(core_.mutex);
    const JobRow row = objects_.require_job(id);
    if (references_.waits_for(row)) {
        pair.film.pending = true;
        return pair;
    }
    try {
        pair.reference = references_.reference_source(row).value();
    } catch (const Error& error) {
        throw Error(ErrorCode::NotFound, "job " + id + ": " + error.what());
    }
    pair.key = pair.film.cache_key + "/against/" + pair.reference.first.path().filename().string();
    const auto pin = [&](ImageSource& source) {
        if (!source.film) return;
        FilmSource& pinned = pair.pinned_references.emplace_back();
        pinned.path = *source.film;
        films_.pin(pinned);
        source.film = pinned.path;
    };
    if (pair.reference.second) {
        pair.key += "," + pair.reference.second->path().filename().string();
        pin(*pair.reference.second);
    }
    pin(pair.reference.first);
    return pair;
}

Artefact ErrorArtefacts::map_of_errors(const std::string& id, const std::string& what, const Encode& encode) {
    MeasuredPair pair = measured_pair(id);
    if (pair.film.pending) return pending_artefact();
    films_.pin(pair.film);
    return pictures_.picture(
        pair.film.subject + "/" + what, pair.key + "/" + what, "image/png",
        [pair, encode](const Draughtsman& by, const fs::path& path) {
            return pixel_headers(encode(by.helper, {.film = pair.film.path}, pair.reference, path));
        });
}

Artefact ErrorArtefacts::difference(const std::string& id) {
    MeasuredPair pair = measured_pair(id);
    if (pair.film.pending) return pending_artefact();
    return artefact_files_.artefact(pair.key + "/difference", "image/x-exr", [&](const fs::path& path) {
        films_.pin(pair.film);
        return pixel_headers(
            core_.helper->ask(EncodeDifferenceRequest{{.film = pair.film.path}, pair.reference, path}));
    });
}

Artefact ErrorArtefacts::flip(const std::string& id, const std::string& layer, const std::string& range) {
    BodyFaults faults;
    check_layer(layer, faults);
    check_range(range, faults);
    faults.throw_if_any();
    return map_of_errors(id, "flip/" + layer + "/" + range,
                         [layer, range](Helper& helper, const ImageSource& image, const ReferenceSource& reference,
                                        const fs::path& out) {
                             return helper.ask(EncodeFlipRequest{image, reference, layer, range, out});
                         });
}

Artefact ErrorArtefacts::error_map(const std::string& id, const std::string& layer) {
    BodyFaults faults;
    check_layer(layer, faults);
    faults.throw_if_any();
    return map_of_errors(
        id, "error/" + layer,
        [layer](Helper& helper, const ImageSource& image, const ReferenceSource& reference, const fs::path& out) {
            return helper.ask(EncodeErrorMapRequest{image, reference, layer, out});
        });
}

ErrorArtefacts::NamedSource ErrorArtefacts::source_named(const std::string& name, const std::string& pointer) {
    NamedSource named;
    if (name.starts_with("image:")) {
        const std::lock_guard lock(core_.mutex);
        const auto image = core_.store.image(name.substr(6));
        if (!image) throw Error(ErrorCode::UnknownName, pointer, "there is no image '" + name.substr(6) + "'");
        named.source.image = core_.files.images / image->file;
        named.key = named.subject = "image/" + image->id;
        return named;
    }
    const std::string id = name.substr(4);
    try {
        named.film = films_.film_source(id);
    } catch (const Error& error) {
        if (error.code != ErrorCode::NotFound) throw;
        throw Error(ErrorCode::UnknownName, pointer, error.what());
    }
    if (named.film.pending) return named;
    films_.pin(named.film);
    named.source.film = named.film.path;
    named.key = named.film.cache_key;
    named.subject = named.film.subject;
    return named;
}

Artefact ErrorArtefacts::flip_map(const std::string& image, const std::string& reference, const std::string& layer,
                                  const std::string& range, const std::string& precision) {
    BodyFaults faults;
    const std::pair<const char*, const std::string*> names[] = {{"/image", &image}, {"/reference", &reference}};
    for (const auto& [pointer, name] : names) {
        if (name->empty())
            faults.add(ErrorCode::MissingField, pointer, "must name a job or an image: \"job:ID\" or \"image:ID\"");
        else
            check_source_name(*name, pointer, faults);
    }
    check_layer(layer, faults);
    check_range(range, faults);
    check_precision(precision, faults);
    faults.throw_if_any();
    const NamedSource shown = source_named(image, "/image"), against = source_named(reference, "/reference");
    if (shown.film.pending || against.film.pending) return pending_artefact();
    const std::string what = "/flip-map/" + layer + "/" + range + "/" + precision + "/against/";
    return pictures_.picture(
        shown.subject + what + against.subject, shown.key + what + against.key, "application/octet-stream",
        [shown, against, layer, range, precision](const Draughtsman& by, const fs::path& path) {
            return pixel_headers(
                by.helper.ask(EncodeFlipMapRequest{shown.source, {against.source, {}}, layer, range, precision, path}));
        });
}

void ErrorArtefacts::check_independent(const std::string& first, const std::string& second) {
    const std::string pointer = "/references/1";
    if (first == second) throw Error(ErrorCode::Conflict, pointer, "'" + second + "' is named twice");
    if (!first.starts_with("job:") || !second.starts_with("job:")) return;
    const std::lock_guard lock(core_.mutex);
    const auto seed_of = [&](const std::string& name) {
        return json::parse(objects_.require_job(name.substr(4)).request).value("seed", uint64_t{1});
    };
    if (const uint64_t seed = seed_of(first); seed == seed_of(second))
        throw Error(ErrorCode::Conflict, pointer,
                    "both jobs have the seed " + std::to_string(seed) + ": their noise is not independent");
}

json ErrorArtefacts::measure(const json& body) {
    BodyFaults faults;
    ObjectReader reader(body, "", faults);
    struct Named {
        std::string name, pointer;
    };
    std::vector<Named> named;  // the image, and what it is measured against
    const auto add = [&](const std::optional<std::string>& name, const std::string& pointer) {
        if (!name) return;
        check_source_name(*name, pointer, faults);
        named.push_back({*name, pointer});
    };
    add(reader.string("image", kMaxSourceBytes, true), "/image");
    const json* const pair = reader.member("references");
    add(reader.string("reference", kMaxSourceBytes, !pair), "/reference");
    if (pair && named.size() > 1) {
        faults.add(ErrorCode::Conflict, "/references", "reference and references exclude each other");
    } else if (pair && (!pair->is_array() || pair->size() != 2)) {
        faults.add(pair->is_array() ? ErrorCode::OutOfRange : ErrorCode::WrongType, "/references",
                   "must be an array of two: \"job:ID\" or \"image:ID\"");
    } else if (pair) {
        for (size_t i = 0; i < 2; ++i) {
            const std::string pointer = "/references/" + std::to_string(i);
            if ((*pair)[i].is_string())
                add((*pair)[i].get<std::string>(), pointer);
            else
                faults.add(ErrorCode::WrongType, pointer, "must be a string");
        }
    }
    const std::vector<std::string> metrics = read_metrics(reader.member("metrics"), faults);
    reader.finish();
    faults.throw_if_any();
    std::vector<NamedSource> sources;
    for (const auto& [name, pointer] : named) {
        sources.push_back(source_named(name, pointer));
        if (sources.back().film.pending)
            throw Error(ErrorCode::WrongState, pointer, "job " + name.substr(4) + " has no film yet");
    }
    MeasureRequest request{sources[0].source, {sources[1].source, {}}, metrics};
    if (pair) {
        check_independent(named[1].name, named[2].name);
        request.reference.second = sources[2].source;
    }
    return part_json(core_.helper->ask(request));
}

}  // namespace photond
