#include "renderer/methods/visibility_filtering/point_proxies_gpu.h"

#include <algorithm>
#include <cmath>

#include "renderer/scene/scene.h"
#include "renderer/scene/surface_area.h"
#include "renderer/voxels/voxel_grid.h"

namespace photond {

namespace {

std::string proxy_shader(const char* name) { return "renderer/methods/visibility_filtering/" + std::string(name); }

/// Most proxies there will be: each triangle has one more or one fewer than its area says, by a hash.
uint32_t room_for_proxies(uint64_t proxies, uint64_t triangles) {
    constexpr double kStandardDeviations = 6;
    const double deviation = std::sqrt(static_cast<double>(triangles) / 4);
    return static_cast<uint32_t>(static_cast<double>(proxies) + kStandardDeviations * deviation) + PROXY_GROUP;
}

}  // namespace

PointProxiesGpu::PointProxiesGpu(const gpu::DeviceScene& scene, LightDepthMapsGpu* depth_maps, gpu::Buffer& counters,
                                 uint64_t seed, uint32_t proxies, float glossy_threshold)
    : scene_(scene),
      device_(scene.device()),
      depth_maps_(depth_maps),
      counters_(counters),
      seed_(seed),
      glossy_threshold_(glossy_threshold),
      triangles_(std::max<uint32_t>(first_triangles_of(scene.scene()).back(), 1)),
      capacity_(room_for_proxies(proxies, triangles_)),
      per_m2_(static_cast<float>(proxies / surface_area_m2(scene.scene()))),
      first_triangles_(
          gpu::make_buffer(device_, "proxies", std::span<const uint32_t>(first_triangles_of(scene.scene())))),
      starts_(device_, "proxies", uint64_t{triangles_} * sizeof(uint32_t)),
      state_(device_, "proxies", PROXY_STATE_WORDS * sizeof(uint32_t)),
      host_state_(device_, "readback", PROXY_STATE_WORDS * sizeof(uint32_t), gpu::MemoryKind::Readback),
      unsorted_(device_, capacity_),
      running_sums_(device_, "proxies", uint64_t{capacity_} * sizeof(float)),
      prefix_sum_(device_, triangles_),
      hash_grid_(device_),
      counts_(device_, proxy_shader("proxy_counts.comp"), sizeof(gpu::ProxyPush), &scene.set(),
              scene.specialization({})),
      places_(device_, proxy_shader(depth_maps ? "proxy_places_depth_maps.comp" : "proxy_places.comp"),
              sizeof(gpu::ProxyPush), &scene.set(), scene.specialization({})),
      voxel_sums_(device_, proxy_shader("proxy_voxels.comp"), sizeof(gpu::ProxyVoxelsPush)) {}

uint64_t PointProxiesGpu::device_bytes(uint32_t proxies, uint32_t voxels_along, uint64_t triangles) {
    const uint64_t capacity = room_for_proxies(proxies, triangles);
    const uint64_t slots = guess_voxels(voxels_along);
    return triangles * sizeof(uint32_t) + UnsortedPhotons::bytes_for(capacity) +
           GridPhotons::bytes_for(slots + 1, capacity) + capacity * sizeof(float) + slots * sizeof(gpu::ProxyVoxel);
}

void PointProxiesGpu::cut_voxels(uint32_t along) {
    const Bounds3& bounds = scene_.scene().bounds;
    const vec3 size_m = bounds.diagonal();
    const float longest_m = std::max({size_m.x, size_m.y, size_m.z});
    cell_m_ = longest_m / static_cast<float>(along);
    grid_ = {};
    grid_.origin = bounds.min;
    grid_.cell_m = cell_m_;
    grid_.cells_per_m = vec3(1 / cell_m_);
    uint64_t slots = 1;
    for (int axis = 0; axis < 3; ++axis) {
        const float cells = std::ceil(size_m[axis] / cell_m_ - 1e-3f);
        grid_.cells[axis] = static_cast<int32_t>(std::clamp(cells, 1.0f, static_cast<float>(along)));
        slots *= static_cast<uint64_t>(grid_.cells[axis]);
    }
    grid_.slots = static_cast<uint32_t>(slots);
    grid_.capacity = capacity_;
    if (grid_.slots <= most_slots_) return;
    most_slots_ = grid_.slots;
    sorted_.reset();
    voxels_ = {}, lit_words_ = {};
    sorted_.emplace(device_, uint64_t{most_slots_} + 1, capacity_);
    voxels_ = gpu::Buffer(device_, "proxy_voxels", uint64_t{most_slots_} * sizeof(gpu::ProxyVoxel));
    lit_words_ = gpu::Buffer(device_, "proxy_voxels", uint64_t{words()} * sizeof(uint32_t));
}

uint32_t PointProxiesGpu::proxies_a_piece() const { return std::max(device_.paths_per_submit(), 1024u); }

uint32_t PointProxiesGpu::pieces() const { return (capacity_ + proxies_a_piece() - 1) / proxies_a_piece(); }

void PointProxiesGpu::record(gpu::CommandList& commands, uint32_t pass, uint32_t piece) {
    const uint32_t first = piece * proxies_a_piece(), end = std::min(first + proxies_a_piece(), capacity_);
    const gpu::ProxyPush push{.seed = seed_,
                              .pass = pass,
                              .instances = static_cast<uint32_t>(scene_.scene().instances.size()),
                              .capacity = capacity_,
                              .first_proxy = first,
                              .per_m2 = per_m2_,
                              .glossy_threshold = glossy_threshold_};
    {
        const gpu::Scope scope(commands, "vpl_generation");
        if (piece == 0) {
            commands.update(state_, std::array<uint32_t, PROXY_STATE_WORDS>{0, triangles_, 0});
            commands.bind(counts_, {gpu::read("state", state_), gpu::read("svo_first_triangles", first_triangles_),
                                    gpu::write("counts", starts_)});
            commands.push(push);
            commands.dispatch_threads(triangles_, PROXY_GROUP);
            prefix_sum_.record(commands, starts_, starts_, {state_, PROXY_TRIANGLES_WORD}, {state_, PROXIES_WORD});
        }
        std::vector<gpu::Binding> bindings = {gpu::read_write("state", state_),
                                              gpu::read("svo_first_triangles", first_triangles_),
                                              gpu::read("starts", starts_),
                                              gpu::write("places", unsorted_.places),
                                              gpu::write("powers", unsorted_.powers),
                                              gpu::write("order", unsorted_.order),
                                              gpu::read_write("device_counters", counters_)};
        if (depth_maps_)
            bindings.insert(bindings.end(), {gpu::read("light_depth_constants", depth_maps_->constants()),
                                             gpu::read("light_depth_maps", depth_maps_->maps()),
                                             gpu::read("light_depths_m", depth_maps_->depths())});
        commands.bind(places_, bindings);

        commands.push(push);
        commands.dispatch_threads(end - first, PROXY_GROUP);
    }
    if (end < capacity_) return;
    const gpu::Scope scope(commands, "voxelise");
    hash_grid_.record_ordered(commands, grid_, state_, unsorted_, *sorted_);
    commands.fill(lit_words_, 0);
    commands.bind(voxel_sums_, {gpu::read("grid_starts", sorted_->starts), gpu::read("grid_places", sorted_->places),
                                gpu::read("powers", sorted_->powers), gpu::write("voxels", voxels_),
                                gpu::read_write("lit_words", lit_words_), gpu::write("running_sums", running_sums_)});
    commands.push(gpu::ProxyVoxelsPush{grid_, per_m2_});
    commands.dispatch_threads(uint64_t{grid_.slots} * PROXY_GROUP, PROXY_GROUP);
    commands.copy(state_, 0, host_state_, 0, PROXY_STATE_WORDS * sizeof(uint32_t));
    commands.host_reads(host_state_);
}

}  // namespace photond
