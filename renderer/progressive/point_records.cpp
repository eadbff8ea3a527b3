#include "renderer/progressive/point_records.h"

#include "renderer/core/copy_elements.h"

#include <cstring>

#include "protocol/error.h"

namespace photond {

namespace {

/// Before the points in a saved state.
struct StateHeader {
    uint32_t version = 1;
    uint32_t point_bytes = 0;
    uint32_t sets = 0;
    uint32_t reserved = 0;
    uint64_t pixels = 0;
    PerMap<uint64_t> points{};

    bool operator==(const StateHeader&) const = default;
};
static_assert(sizeof(StateHeader) == SavedPoints::kHeaderBytes);

template <class Bytes>
StateHeader header_of(const SavedPoints& kind, const PerMap<Bytes>& points) {
    StateHeader header{.point_bytes = static_cast<uint32_t>(kind.point_bytes),
                       .sets = static_cast<uint32_t>(kind.sets),
                       .pixels = kind.pixels};
    for (size_t map = 0; map < points.size(); ++map) header.points[map] = points[map].size() / kind.point_bytes;
    return header;
}

}  // namespace

std::string save_points(const SavedPoints& kind, const PerMap<std::span<const std::byte>>& points) {
    const StateHeader header = header_of(kind, points);
    std::string state(reinterpret_cast<const char*>(&header), sizeof header);
    for (const std::span<const std::byte> bytes : points)
        state.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return state;
}

void restore_points(const std::string& state, const SavedPoints& kind, const PerMap<std::span<std::byte>>& points) {
    size_t bytes = sizeof(StateHeader);
    for (const std::span<std::byte> of_map : points) bytes += of_map.size();
    StateHeader saved;
    if (state.size() >= sizeof saved) std::memcpy(&saved, state.data(), sizeof saved);
    if (state.size() != bytes || !(saved == header_of(kind, points)))
        throw Error(ErrorCode::Conflict, "the radii kept with the film are not of this job");
    size_t at = sizeof saved;
    for (const std::span<std::byte> of_map : points) {
        copy_elements(state.data() + at, of_map);
        at += of_map.size();
    }
}

void check_points_to_go_on_from(const ProgressiveParams& params, const std::string& state) {
    if (state.empty() != params.passes_stand_alone())
        throw Error(ErrorCode::Conflict, state.empty() ? "the film lacks the radii that its passes left"
                                                       : "the film has radii that its passes have no need of");
}

}  // namespace photond
