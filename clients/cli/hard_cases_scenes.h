#pragma once
// The hard cases as the daemon lists them (GET /v1/scenes?family=hard-cases, `known_answer` of each).

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "clients/cli/daemon_client.h"
#include "clients/cli/hard_cases_verdict.h"

namespace photond::cli {

/// A part of an image in fractions of it, row 0 at the top.
struct ImageRegion {
    double x0 = 0, y0 = 0, x1 = 1, y1 = 1;
    bool operator==(const ImageRegion&) const = default;
};

struct ImageSize {
    uint32_t width = 0, height = 0;
    bool operator==(const ImageSize&) const = default;
};

struct HardCheck {
    Relation relation = Relation::Finite;
    std::string layer;
    ImageRegion region;
    std::optional<Radiance> value;    // of equals and at_most
    std::string other_scene;          // of same_as
    double scale = 1;                 // of same_as: factor on the other's radiance
    std::optional<uint32_t> bounces;  // of the indirect light the answer is for; none: all
    double tolerance = 0;
};

struct HardCase {
    std::string row;    // of the table of hard cases; several scenes may belong to one
    std::string scene;  // its name; empty where a test takes its place
    std::string test;   // the program that covers it; empty for a scene
    std::string strains, text;
    std::vector<HardCheck> checks;
    uint32_t passes = 0;                                // suggested
    ImageSize size;                                     // suggested
    std::map<std::string, std::string> not_applicable;  // method -> why

    /// What a table calls it: the scene without its family, else the row.
    std::string name() const;
};

/// All that the daemon has: its scenes, and behind those of the same row what tests cover. Throws Failure.
std::vector<HardCase> hard_cases_of(DaemonClient& daemon);

/// One item of the list: of `items`, or of `tests`. Throws Failure(Refused) where it is not what the protocol says.
HardCase hard_case_from(const nlohmann::json& scene);

/// Those that a name given on the command line means: whole scene names, with or without "hard-case/", or a part of a
/// row's name. Empty `names`: all. Throws Failure(Usage) for a name that means none.
std::vector<HardCase> chosen_cases(const std::vector<HardCase>& all, const std::vector<std::string>& names);

/// The smallest image, down to a quarter of the suggested one and 8 pixels, in which every region that had whole pixels
/// still has: an answer that is a mean over a region holds for that region only.
ImageSize small_image(const HardCase& hard_case);

}  // namespace photond::cli
