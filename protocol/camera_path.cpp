#include "protocol/camera_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace photond {

using nlohmann::json;

namespace {

constexpr double kMostTurns = 1e6;
constexpr double kMostSeconds = 1e9;
constexpr size_t kMostKeys = 10'000;

std::vector<CameraKey> read_keys(const json& source, const std::string& pointer, BodyFaults& faults) {
    std::vector<CameraKey> keys;
    if (!source.is_array() || source.empty() || source.size() > kMostKeys) {
        faults.add(source.is_array() ? ErrorCode::OutOfRange : ErrorCode::WrongType, pointer,
                   "must be an array of 1 to " + std::to_string(kMostKeys) + " views");
        return keys;
    }
    for (size_t i = 0; i < source.size(); ++i) {
        const std::string at = pointer + "/" + std::to_string(i);
        if (!source[i].is_object()) {
            faults.add(ErrorCode::WrongType, at, "must be an object with a time, an eye and a target");
            continue;
        }
        CameraKey key;
        const size_t before = faults.size();
        json time = source[i].contains("time") ? json{{"time", source[i]["time"]}} : json::object();
        ObjectReader reader(time, at, faults);
        if (const auto seconds = reader.number("time", {-kMostSeconds, kMostSeconds, "s"}, true)) key.time = *seconds;
        json view = source[i];
        view.erase("time");
        key.view = read_look_at(view, at, faults);
        if (faults.size() == before && !keys.empty() && key.time <= keys.back().time)
            faults.add(ErrorCode::OutOfRange, at + "/time", "must be later than that of the key before it");
        keys.push_back(key);
    }
    return keys;
}

/// The numbers of a view that are moved, as one list. Of the angle that is the logarithm of the image's half height at
/// unit distance: whatever it comes to is an angle again, and a zoom of even speed magnifies evenly.
std::array<double, 10> numbers_of(const LookAt& view) {
    return {view.eye[0],    view.eye[1], view.eye[2], view.target[0], view.target[1],
            view.target[2], view.up[0],  view.up[1],  view.up[2],     std::log(std::tan(view.yfov / 2))};
}

LookAt view_of(const std::array<double, 10>& n) {
    LookAt view;
    view.eye = {n[0], n[1], n[2]}, view.target = {n[3], n[4], n[5]}, view.up = {n[6], n[7], n[8]};
    view.yfov = 2 * std::atan(std::exp(n[9]));
    return view;
}

LookAt along_keys(const std::vector<CameraKey>& keys, double time) {
    const auto after = std::upper_bound(keys.begin(), keys.end(), time,
                                        [](double moment, const CameraKey& key) { return moment < key.time; });
    if (after == keys.begin()) return keys.front().view;
    if (after == keys.end()) return keys.back().view;
    const auto k = static_cast<size_t>(after - keys.begin()) - 1;
    const double length = keys[k + 1].time - keys[k].time, t = (time - keys[k].time) / length;
    const std::array<double, 10> from = numbers_of(keys[k].view), to = numbers_of(keys[k + 1].view);
    // A key's speed is that of the straight way between its neighbours; the ends stand.
    const auto speed = [&](size_t key, size_t n) {
        if (key == 0 || key + 1 == keys.size()) return 0.0;
        return (numbers_of(keys[key + 1].view)[n] - numbers_of(keys[key - 1].view)[n]) /
               (keys[key + 1].time - keys[key - 1].time);
    };
    std::array<double, 10> result{};
    for (size_t n = 0; n < result.size(); ++n)
        result[n] = (2 * t * t * t - 3 * t * t + 1) * from[n] + (t * t * t - 2 * t * t + t) * length * speed(k, n) +
                    (3 * t * t - 2 * t * t * t) * to[n] + (t * t * t - t * t) * length * speed(k + 1, n);
    return view_of(result);
}

}  // namespace

std::optional<CameraPath> read_camera_path(const json& source, const std::string& pointer, BodyFaults& faults) {
    const size_t before = faults.size();
    ObjectReader reader(source, pointer, faults);
    CameraPath path;
    path.turns = reader.number("turns", {-kMostTurns, kMostTurns, ""});
    if (const json* keys = reader.member("keys")) path.keys = read_keys(*keys, reader.at("keys"), faults);
    reader.finish();
    if (faults.size() == before && path.turns.has_value() == !path.keys.empty())
        faults.add(ErrorCode::MissingField, pointer, "must have either turns or keys");
    return faults.size() == before ? std::optional(std::move(path)) : std::nullopt;
}

json to_json(const CameraPath& path) {
    if (path.turns) return {{"turns", *path.turns}};
    json keys = json::array();
    for (const CameraKey& key : path.keys) {
        keys.push_back(to_json(key.view));
        keys.back()["time"] = key.time;
    }
    return {{"keys", std::move(keys)}};
}

LookAt view_along(const CameraPath& path, const LookAt& start, double time_s, double share) {
    if (!path.turns) return along_keys(path.keys, time_s);
    const double angle = 2 * std::numbers::pi * *path.turns * share, c = std::cos(angle), s = std::sin(angle);
    LookAt view = start;
    const double x = start.eye[0] - start.target[0], z = start.eye[2] - start.target[2];
    view.eye[0] = start.target[0] + c * x + s * z;
    view.eye[2] = start.target[2] - s * x + c * z;
    return view;
}

}  // namespace photond
