#pragma once
// What the house knows of a method: a room's row.cpp says it, methods/registry.h lists the rows, and the wire, the
// clients and the tests read it from there.

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/frame/left_out.h"
#include "renderer/frame/method.h"

namespace photond {

/// A file a method can leave beside the image (MethodArtefact), served as /v1/jobs/ID/NAME.
struct ArtefactInfo {
    std::string_view name;  // "photon_map.glb"; its link in a job is the part before the dot
    std::string_view media_type;
    std::string_view parameter;  // the flag of the method that asks for it
    std::string_view text;       // what it is: "photon map"
};

/// A publication that a method comes from.
struct Source {
    std::string_view author;
    unsigned year;  // 0: not known
    std::string_view title;

    std::string text() const;  // "Jensen 1996, Global Illumination using Photon Maps"
};

/// A parameter set to one of its words.
struct ParamSetting {
    std::string_view name, word;
};

/// Settings of a method that are worth a column of their own where methods are judged by scenes with known answers.
struct MethodVariant {
    std::string_view label;  // after the method's name: "final"
    std::vector<ParamSetting> settings;
};

/// Why a method, by its nature, misses a known answer: said beside the measured figure, and no excuse for another one.
struct KnownLimit {
    std::vector<ParamSetting> settings;  // with these alone; empty: with all
    std::string_view row;                // part of the hard case's row (scene/hard_cases.h); empty: any
    std::string_view text;
};

/// A hard case that a method cannot be asked, and why.
struct CaseRefusal {
    std::string_view row;  // part of the hard case's row
    std::string_view text;
};

struct TemporalParams;  // common_params.h

struct MethodInfo {
    std::string_view name;  // folder, `method.name`, row in every table
    std::string_view title;
    std::string_view line;  // for who does not know it: what it does, where it is good and where it is not
    std::string_view family;
    std::vector<Source> sources;
    bool mergeable = true;          // by default: see passes_stand_alone
    bool deterministic_cpu = true;  // same pixel hash for any number of threads
    bool deterministic_gpu = true;  // same pixel hash on one device and driver
    LayerSet layers;                // those it can fill
    std::vector<ArtefactInfo> artefacts;
    std::vector<MethodVariant> variants;  // empty: the method as it is by default
    std::vector<KnownLimit> limits;       // the first that fits is said
    std::vector<CaseRefusal> refusals;
    /// Parameters and their words with which, all together, its bias falls with the passes; an empty list: it always
    /// does; none: it never does.
    std::optional<std::vector<ParamSetting>> bias_falls_with;
    /// What stands for a parameter that a request kept since before lacks, where that is not the default of now: the
    /// request is of a time when there was no such parameter, or another default, and is done as it was then.
    std::vector<ParamSetting> settings_before;
    /// Whether its passes stand alone with these parameters: they can be rendered in any order and anywhere, and their
    /// films merged. Null: they do.
    bool (*passes_stand_alone)(const MethodParams& params) = nullptr;
    /// What a frame of an animation leaves, with these parameters, for the one after it to follow from: "indirect
    /// light". Null, or nothing: its frames stand alone.
    std::vector<std::string_view> (*left_to_next)(const MethodParams& params) = nullptr;
    /// With these parameters a method of the last frame's indirect light: see TemporalParams. Null: it has none.
    const TemporalParams* (*temporal)(const MethodParams& params) = nullptr;
    /// Kinds of path that it leaves out with these parameters in a scene with these needs, whatever its passes.
    PathsLeftOut (*left_out)(const MethodParams& params, const Needs& needs) = nullptr;
    std::unique_ptr<MethodParams> (*make_params)() = nullptr;
    std::unique_ptr<Method> (*make)(const MethodParams& params) = nullptr;      // null where it does not run on the CPU
    std::unique_ptr<Method> (*make_gpu)(const MethodParams& params) = nullptr;  // null where it does not run on a GPU
    /// Bytes the method itself will record in its budget: all but the film, the scene and its ray structure. Null where
    /// there is no make.
    uint64_t (*estimate_bytes)(const MethodParams& params, const Workload& workload) = nullptr;
    /// Likewise on a GPU: of the host's memory; null where there is no make_gpu.
    uint64_t (*estimate_bytes_gpu)(const MethodParams& params, const Workload& workload) = nullptr;
    /// Throws ErrorCode::Unsupported, with a pointer to the parameter, for what only the CPU has.
    void (*check_gpu)(const MethodParams& params) = nullptr;
    /// Whether on a GPU its passes trace rays on the host's cores too, so that the ray structure lies in the host's
    /// memory as well. Null: they never do.
    bool (*traces_on_host)(const MethodParams& params) = nullptr;
    /// Bytes of the GPU's memory the method will take beside the scene's; null where there is no make_gpu.
    uint64_t (*estimate_device_bytes)(const MethodParams& params, const Workload& workload) = nullptr;
    /// About the bytes it will leave on the disk beside image and history: artefacts, and what else the next frame
    /// follows from.
    uint64_t (*estimate_artefact_bytes)(const MethodParams& params, const Workload& workload) = nullptr;

    std::vector<std::string_view> devices() const;  // kinds: "cpu", "gpu"
    /// nullptr when it has no artefact of that name.
    const ArtefactInfo* find_artefact(std::string_view artefact_name) const;
    /// Names of the layers that a job has to ask for, those of them it can fill; in the order of kLayers.
    std::vector<std::string> layers_on_request() const;
};

}  // namespace photond
