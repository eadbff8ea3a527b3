#pragma once
// The four kinds of measurement of bench_list.h, as JSON. Milliseconds are the device's by its timestamps, on the CPU
// the wall's; the first passes are left out of all of them.

#include "tests/benchmarks/gpu_bench/bench_run.h"

namespace photond::bench {

/// Stage by stage, mean and median; whole passes, one after the other as a job runs them and alone; beside
/// `published_ms`.
nlohmann::json time_passes(const Entry& entry, Place& place, bool on_gpu);

/// Seconds on a job's clock, without what a job does before its first pass, and of these the device's alone: where
/// passes are short, their folding into the film takes the longer. Pipelines have been compiled before.
nlohmann::json time_to_error(const Entry& entry, Place& place, bool on_gpu);

/// The settings by rising error. One that fails says why.
nlohmann::json rank_by_quality(const Entry& entry, Place& place, bool on_gpu);

/// Median milliseconds of building, and bytes a voxel. Needs a GPU.
nlohmann::json time_voxels(const Entry& entry, Place& place);

}  // namespace photond::bench
