#include "tests/benchmarks/gpu_bench/bench_list.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "protocol/error.h"

namespace photond::bench {

namespace {

using nlohmann::json;

/// The objects that `source` stands for, with the axes of its `vary` merged in.
std::vector<json> expand(json source) {
    const json axes = source.value("vary", json::array());
    source.erase("vary");
    std::vector<json> all{std::move(source)};
    for (const json& axis : axes) {
        std::vector<json> varied;
        for (const json& one : all) {
            for (const json& change : axis) {
                json merged = one;
                merged.merge_patch(change);
                if (change.contains("name"))
                    merged["name"] = one.at("name").get<std::string>() + ", " + change["name"].get<std::string>();
                varied.push_back(std::move(merged));
            }
        }
        all = std::move(varied);
    }
    return all;
}

void expect_known(const json& source, std::initializer_list<std::string_view> names) {
    for (const auto& [name, value] : source.items())
        if (std::find(names.begin(), names.end(), name) == names.end())
            throw Error(ErrorCode::UnknownField, "\"" + name + "\" is not known here");
}

class Reader {
public:
    explicit Reader(double scale) : scale_(scale) {}

    Entry entry(const json& source) const {
        expect_known(source, {"name", "scene", "method", "parameters", "width", "height", "camera", "devices", "passes",
                              "warm_up_passes", "published_ms", "time_to_error", "quality", "voxels"});
        Entry entry;
        entry.scene = source.at("scene");
        entry.rendering = rendering(source);
        entry.devices = source.value("devices", entry.devices);
        entry.passes = scaled(source.value("passes", 1.0));
        entry.warm_up_passes = scaled(source.value("warm_up_passes", 1.0));
        // Of a smaller image they would say nothing.
        if (scale_ == 1 || source.contains("voxels"))
            entry.published_ms = source.value("published_ms", entry.published_ms);
        if (source.contains("time_to_error")) entry.time_to_error = time_to_error(source["time_to_error"]);
        if (source.contains("quality")) entry.quality = quality(source["quality"], source);
        if (source.contains("voxels")) entry.voxels = voxels(source["voxels"]);
        const int kinds = source.contains("passes") + source.contains("time_to_error") + source.contains("quality") +
                          source.contains("voxels");
        if (kinds != 1) throw Error(ErrorCode::Conflict, "one of passes, time_to_error, quality and voxels is wanted");
        if (!entry.voxels && !(entry.rendering.size.pixels() > 0))
            throw Error(ErrorCode::MissingField, "width and height are wanted");
        if (!entry.voxels && !entry.quality && entry.rendering.method.empty())
            throw Error(ErrorCode::MissingField, "a method is wanted");
        return entry;
    }

private:
    uint32_t scaled(double x) const { return static_cast<uint32_t>(std::max(1.0, std::round(x * scale_))); }

    Rendering rendering(const json& source) const {
        Rendering rendering;
        rendering.name = source.at("name");
        rendering.method = source.value("method", "");
        rendering.parameters = source.value("parameters", rendering.parameters);
        rendering.camera = source.value("camera", "");
        if (source.contains("width"))
            rendering.size = {scaled(source["width"].get<double>()), scaled(source.at("height").get<double>())};
        if (rendering.parameters.contains("photons"))
            rendering.parameters["photons"] = scaled(rendering.parameters["photons"].get<double>());
        return rendering;
    }

    ReferenceWanted reference(const json& source) const {
        expect_known(source, {"passes", "parameters"});
        return {source.value("parameters", json::object()), scaled(source.at("passes").get<double>())};
    }

    TimeToError time_to_error(const json& source) const {
        expect_known(source, {"metric", "targets", "reference", "most_seconds"});
        TimeToError wanted;
        wanted.metric = metric(source.value("metric", "indirect:relative_mse"));
        wanted.targets = source.at("targets").get<std::vector<double>>();
        if (wanted.targets.empty()) throw Error(ErrorCode::MissingField, "a target is wanted");
        wanted.reference = reference(source.at("reference"));
        wanted.most_seconds = source.value("most_seconds", wanted.most_seconds) * scale_;
        return wanted;
    }

    /// `view`: the entry, whose camera and size its settings have.
    Quality quality(const json& source, const json& view) const {
        expect_known(source, {"milliseconds", "metrics", "reference", "repeats", "settings"});
        Quality wanted;
        wanted.milliseconds = source.value("milliseconds", wanted.milliseconds);
        for (const json& name : source.at("metrics")) wanted.metrics.push_back(metric(name));
        if (wanted.metrics.empty()) throw Error(ErrorCode::MissingField, "a metric is wanted");
        wanted.reference = reference(source.at("reference"));
        wanted.repeats = source.value("repeats", wanted.repeats);
        for (const json& setting : source.at("settings")) {
            for (json one : expand(setting)) {
                expect_known(one, {"name", "method", "parameters"});
                for (const char* of_view : {"width", "height", "camera"})
                    if (view.contains(of_view)) one[of_view] = view[of_view];
                wanted.settings.push_back(rendering(one));
            }
        }
        return wanted;
    }

    Voxels voxels(const json& source) const {
        expect_known(source, {"resolution", "builds", "surfaces"});
        Voxels wanted;
        wanted.resolution = source.at("resolution");
        wanted.builds = scaled(source.value("builds", 1.0 * wanted.builds));
        wanted.surfaces = source.value("surfaces", wanted.surfaces);
        return wanted;
    }

    static LayerMetric metric(const std::string& name) {
        const std::optional<LayerMetric> metric = layer_metric_named(name);
        if (!metric) throw Error(ErrorCode::UnknownName, "there is no metric " + name);
        if (!metric_info(metric->metric).needs_reference || metric_info(metric->metric).values != 1)
            throw Error(ErrorCode::Unsupported, name + " is not one number against a reference");
        return *metric;
    }

    const double scale_;
};

}  // namespace

std::vector<Entry> read_list(const json& list, double scale) {
    const Reader reader(scale);
    std::vector<Entry> entries;
    for (const json& source : list) {
        std::string name = "an entry";
        try {
            name = source.at("name");
            for (const json& one : expand(source)) {
                name = one.at("name");
                entries.push_back(reader.entry(one));
            }
        } catch (const json::exception& error) {
            throw Error(ErrorCode::WrongType, name + ": " + error.what());
        } catch (const Error& error) {
            throw Error(error.code, name + ": " + error.what());
        }
    }
    return entries;
}

}  // namespace photond::bench
