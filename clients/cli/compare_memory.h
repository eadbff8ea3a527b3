#pragma once
// What each entry of a comparison keeps in memory, structure by structure.

#include <iosfwd>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "clients/cli/compare_presets.h"
#include "clients/cli/compare_statistics.h"

namespace photond::cli {

struct RowStructures {
    std::string label, name;              // of the entry; of the row, with what its sweep gave
    std::map<std::string, double> bytes;  // statistics.memory: structures, and device_structures as "device: NAME"
};

std::vector<RowStructures> structures_of(std::span<const RowStatistics> statistics);

/// A line a row, largest first; what every row has of the same size (the scene, the image) is said once.
void print_structures(std::ostream& out, const std::vector<RowStructures>& rows);
/// Of each published structure ours, in the row of its entry that needs most.
void print_published(std::ostream& out, const std::vector<RowStructures>& rows, const PublishedStructures& published);

}  // namespace photond::cli
