#pragma once
// What photond-gpu-bench is to measure: a JSON array of entries, as in renderer/methods/*/gpu_bench.json.
//
// An entry has a `name`, a `scene` (a built-in one's name, or a file that `photonctl bake` wrote) and what is measured
// of it; `devices` are "gpu" where it says nothing. Methods have `method`, `parameters` as in a job, `width`, `height`
// and, where it is not the scene's first, `camera`. An entry is one of four kinds:
//
//   passes         so many are timed, after `warm_up_passes` that are not, stage by stage.
//   time_to_error  seconds until `metric` comes to each of `targets` for good; passes end after `most_seconds`.
//   quality        of every one of `settings` (each a method of its own): the passes that fit in `milliseconds`, and
//   the
//                  error of so many by `metrics`, the mean of `repeats` images; sorted by the first metric.
//   voxels         a tree of `resolution` is built anew `builds` times, with `surfaces` or without.
//
// Errors are against `reference`: so many `passes` of path tracing with its `parameters`. `published_ms` are another's
// milliseconds of stages (several joined by "+" are added up; "frame" is all of them), beside which ours are put.
// `vary` is a list of axes, each a list of objects: the entry stands once for each combination, with those objects
// merged into it (RFC 7396) and their names behind its own. So do settings.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "renderer/core/geometry.h"
#include "renderer/error/metric.h"

namespace photond::bench {

/// A method, and how the scene is looked at.
struct Rendering {
    std::string name, method;
    nlohmann::json parameters = nlohmann::json::object();
    std::string camera;  // empty: the scene's first
    Size2 size;
};

struct ReferenceWanted {
    nlohmann::json parameters = nlohmann::json::object();  // of path tracing
    uint32_t passes = 1;
};

struct TimeToError {
    LayerMetric metric;
    std::vector<double> targets;
    ReferenceWanted reference;
    double most_seconds = 60;
};

struct Quality {
    double milliseconds = 16;
    std::vector<LayerMetric> metrics;
    ReferenceWanted reference;
    uint32_t repeats = 4;
    std::vector<Rendering> settings;
};

struct Voxels {
    uint32_t resolution = 128, builds = 32;
    bool surfaces = false;
};

struct Entry {
    std::string scene;
    Rendering rendering;  // its name is the entry's
    std::vector<std::string> devices{"gpu"};
    uint32_t passes = 1, warm_up_passes = 1;
    nlohmann::json published_ms = nlohmann::json::object();
    // At most one of these; none: passes.
    std::optional<TimeToError> time_to_error;
    std::optional<Quality> quality;
    std::optional<Voxels> voxels;
};

/// `scale` multiplies photons, passes, builds, seconds and the image's sides. Throws Error, with the entry's name, for
/// what is missing, of the wrong type, or not known.
std::vector<Entry> read_list(const nlohmann::json& list, double scale);

}  // namespace photond::bench
