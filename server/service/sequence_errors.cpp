#include "server/service/sequence_errors.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <vector>

#include "protocol/helper_messages.h"
#include "renderer/error/motion_errors.h"
#include "renderer/film/layers.h"

namespace photond {

using nlohmann::json;

namespace {

constexpr const char* kFigures[] = {"relative_mse", "flicker", "lag", "change"};

/// What has to be the same of two sequences for one to be the other's reference.
constexpr const char* kSameOfBoth[] = {"scene",  "animation",   "from",  "fps",         "shutter",
                                       "camera", "camera_path", "image", "environment", "glass"};

[[noreturn]] void conflict(const std::string& member, const std::string& text) {
    throw Error(ErrorCode::Conflict, "/" + member, text);
}

[[noreturn]] void differ(const json& sequence, const json& reference, const std::string& member,
                         const std::string& what) {
    conflict(member, "sequences " + sequence["id"].get<std::string>() + " and " + reference["id"].get<std::string>() +
                         " differ in their " + what);
}

void check_same_frames(const json& sequence, const json& reference, const std::string& member) {
    for (const char* same : kSameOfBoth)
        if (sequence["request"].value(same, json()) != reference["request"].value(same, json()))
            differ(sequence, reference, member, same);
    // Frame i of n has gone i / n of the way.
    const json path = sequence["request"].value("camera_path", json());
    if (path.is_object() && path.contains("turns") && sequence["request"]["frames"] != reference["request"]["frames"])
        differ(sequence, reference, member, "frames, of which each turns by its share");
}

std::string frame_name(const json& sequence, const json& frame) {
    return "frame " + std::to_string(frame["frame"].get<uint64_t>()) + " of " + sequence["id"].get<std::string>();
}

/// Whose seeds are whose. Noise that two of the references' frames share would look like something that both show, and
/// noise that an image shares with a reference like none.
class ReferenceSeeds {
public:
    /// Throws Conflict where a frame shares its seed with another one.
    void add(const json& reference, const std::string& member) {
        for (const json& frame : reference["frames"]) {
            const Owner owner{frame_name(reference, frame), member};
            const auto [known, added] = owners_.emplace(frame["seed"].get<uint64_t>(), owner);
            if (!added) shared(member, known->second, owner.frame, known->first);
        }
    }
    /// Throws Conflict where an image shares its seed with a reference.
    void check(const json& sequence) const {
        for (const json& frame : sequence["frames"])
            if (const auto known = owners_.find(frame["seed"].get<uint64_t>()); known != owners_.end())
                shared(known->second.member, known->second, frame_name(sequence, frame), known->first);
    }

private:
    struct Owner {
        std::string frame, member;
    };
    [[noreturn]] static void shared(const std::string& member, const Owner& known, const std::string& other,
                                    uint64_t seed) {
        conflict(member, known.frame + " and " + other + " have the seed " + std::to_string(seed) +
                             ": their noise is not independent. References want noise fresh and seeds that are "
                             "further apart than they have frames");
    }

    std::map<uint64_t, Owner> owners_;
};

void check_layer(const std::string& layer) {
    const LayerInfo* info = find_layer(layer);
    if (layer != "beauty" && !(info && info->radiance()))
        throw Error(ErrorCode::UnknownName, "/layer", "'" + layer + "' is no layer of radiance");
}

std::string job_of(const json& sequence, size_t frame) { return sequence["frames"][frame]["id"].get<std::string>(); }

bool has_succeeded(const json& sequence, size_t frame) {
    return frame < sequence["frames"].size() && sequence["frames"][frame]["state"] == "succeeded";
}

CrossError error_of(const json& figure) {
    return {figure["value"].get<double>(), figure["standard_error"].get<double>()};
}

json figure_of(const CrossError& error) {
    const Interval interval = error.interval();
    return {{"value", error.value}, {"interval", {interval.least, interval.greatest}}};
}

/// Over the frames that have a figure. A reference's noise is in its frame's figure alone or, of what is measured
/// between two frames, in the next one's too: such a sum has twice the variance of independent ones at most.
std::optional<CrossError> mean_of(const std::vector<json>& frames, const char* name) {
    double sum = 0, variance = 0;
    size_t count = 0;
    for (const json& frame : frames) {
        if (frame[name].is_null()) continue;
        const CrossError error = error_of(frame[name]);
        sum += error.value, variance += error.standard_error * error.standard_error, ++count;
    }
    if (count == 0) return std::nullopt;
    const double shared = name == std::string("relative_mse") ? 1 : 2;
    const auto n = static_cast<double>(count);
    return CrossError{sum / n, std::sqrt(shared * variance) / n};
}

}  // namespace

json SequenceErrors::measured_frame(const json (&sequences)[3], size_t frame, const std::string& layer) {
    std::vector<FilmSource> held;
    std::string names = layer;
    const auto films_of = [&](size_t index) {
        MeasureFrameRequest::Films films;
        std::filesystem::path* const paths[] = {&films.film, &films.first, &films.second};
        for (size_t i = 0; i < 3; ++i) {
            FilmSource film = films_.film_source(job_of(sequences[i], index));
            if (film.pending) throw Error(ErrorCode::ResultLost, "the film of a frame that had succeeded is gone");
            films_.pin(film);
            *paths[i] = film.path;
            names += " " + film.cache_key;
            held.push_back(std::move(film));
        }
        return films;
    };
    MeasureFrameRequest request;
    request.frame = films_of(frame);
    const auto before = [&](const json& sequence) { return has_succeeded(sequence, frame - 1); };
    if (frame > 0 && std::all_of(std::begin(sequences), std::end(sequences), before))
        request.before = films_of(frame - 1);
    request.layer = layer;
    const std::string key = sequence_key(sequences[0], "errors", names);
    const Artefact measured = pictures_.picture(
        key, key, "application/json", [request, held](const Draughtsman& by, const std::filesystem::path& path) {
            write_text(path, by.helper.ask(request).figures.dump());
            return std::map<std::string, std::string>();
        });
    std::ifstream in(measured.path, std::ios::binary);
    return json::parse(in);
}

json SequenceErrors::errors(const std::string& id, const std::string& first, const std::string& second,
                            const std::string& layer) {
    check_layer(layer);
    for (const auto& [name, reference] : {std::pair("/first", &first), std::pair("/second", &second)})
        if (reference->empty()) throw Error(ErrorCode::MissingField, name, "names no sequence as the reference");
    const json sequences[3] = {sequences_.get_sequence(id), sequences_.get_sequence(first),
                               sequences_.get_sequence(second)};
    check_same_frames(sequences[0], sequences[1], "first");
    check_same_frames(sequences[0], sequences[2], "second");
    ReferenceSeeds seeds;
    seeds.add(sequences[1], "first"), seeds.add(sequences[2], "second");
    seeds.check(sequences[0]);
    std::vector<json> figures;
    json frames = json::array();
    for (size_t frame = 0; frame < sequences[0]["frames"].size(); ++frame) {
        const auto succeeded = [&](const json& sequence) { return has_succeeded(sequence, frame); };
        if (!std::all_of(std::begin(sequences), std::end(sequences), succeeded)) continue;
        const json& measured = figures.emplace_back(measured_frame(sequences, frame, layer));
        json shown = {{"frame", frame}, {"time", sequences[0]["frames"][frame]["time"]}};
        for (const char* name : kFigures)
            shown[name] = measured[name].is_null() ? json() : figure_of(error_of(measured[name]));
        frames.push_back(std::move(shown));
    }
    json mean = json::object();
    std::map<std::string, std::optional<CrossError>> means;
    for (const char* name : kFigures) {
        means[name] = mean_of(figures, name);
        mean[name] = means[name] ? figure_of(*means[name]) : json();
    }
    const std::optional<double> late =
        means["lag"] ? MotionErrors::frames_late(*means["lag"], *means["change"]) : std::nullopt;
    return {{"sequence", id},          {"references", {first, second}},
            {"layer", layer},          {"frames", std::move(frames)},
            {"mean", std::move(mean)}, {"frames_late", late ? json(*late) : json()}};
}

}  // namespace photond
