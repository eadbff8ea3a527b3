#pragma once
// Results of the daemon become files here.

#include <cstdint>
#include <iosfwd>
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
    std::vector<std::string> images;  // .exr, or .png for a preview; "-": standard output
    std::string format;               // of an image on standard output: exr or png; empty: exr
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

    /// Before anything is rendered. Throws Failure(Usage) for a name whose suffix is not of what is to be saved and for
    /// what standard output cannot take, Failure(LocalFile) where nothing could be written.
    void check(const Session& session) const;
    /// Throws Failure(Usage) for a preview of a layer that the image will not have, or that has no preview. `layers`:
    /// those asked for.
    void check_preview_layer(Session& session, const nlohmann::json& layers) const;
    bool to_standard_output() const;
    bool any_image() const { return !images.empty() || !preview.empty(); }
    bool any() const;
    bool needs_reference() const { return !difference.empty() || !flip.empty() || !error_map.empty(); }
};

/// Where the text goes that goes with them: standard output, unless that has one of them.
std::ostream& text_beside(const JobOutputs& outputs);

void save_job_outputs(Session& session, const std::string& job_id, const JobOutputs& outputs);

}  // namespace photond::cli
