#pragma once
// Results of the daemon become files here.

#include <cstdint>
#include <string>
#include <vector>

#include "clients/cli/session.h"

namespace photond::cli {

/// Streams a resource into a file; its bytes. Throws Failure.
uint64_t download(Session& session, const std::string& path_and_query, const std::string& file);
/// The same, and says so; "-" is standard output.
void save_resource(Session& session, const std::string& path_and_query, const std::string& file);

/// What `render` and `jobs fetch` can save of a job.
struct JobOutputs {
    std::vector<std::string> images;  // .exr, or .png for a preview
    std::string preview;              // PNG
    std::string preview_layer;        // what the PNG shows; empty: the beauty
    std::string statistics;           // JSON
    std::string log;                  // text
    std::string photon_map;           // glTF, where the method kept it
    std::string precision;            // of the EXR: half or float; empty: float
    double exposure_stops = 0;        // of the preview
    std::string tone_curve;           // of the preview; empty: the daemon's default
    std::string error_curve;          // CSV
    std::string difference;           // EXR, against the reference
    std::string flip;                 // PNG, against the reference
    std::string error_map;            // PNG, against the reference
    std::string film;                 // the daemon's own format: what `merge` and `extend` go on from

    /// Throws Failure(Usage) for a file name whose suffix says nothing, before anything is rendered.
    void check() const;
    bool any_image() const { return !images.empty() || !preview.empty(); }
    bool any() const;
    bool needs_reference() const { return !difference.empty() || !flip.empty() || !error_map.empty(); }
};

void save_job_outputs(Session& session, const std::string& job_id, const JobOutputs& outputs);

}  // namespace photond::cli
