#include "renderer/methods/registry.h"

#include <algorithm>

#include "renderer/gbuffer/temporal_reprojection.h"

// A method is a line here: the name of its room, whose row.cpp says the rest.
#define PHOTOND_METHODS(METHOD)                      \
    METHOD(bidirectional_path_tracing)               \
    METHOD(image_based_lighting)                     \
    METHOD(image_space_photon_mapping)               \
    METHOD(imperfect_shadow_maps)                    \
    METHOD(light_propagation_volumes)                \
    METHOD(path_tracing)                             \
    METHOD(photon_mapping)                           \
    METHOD(photon_splatting)                         \
    METHOD(probabilistic_progressive_photon_mapping) \
    METHOD(progressive_photon_mapping)               \
    METHOD(radiance_cache)                           \
    METHOD(reflective_shadow_maps)                   \
    METHOD(reverse_photon_mapping)                   \
    METHOD(stochastic_progressive_photon_mapping)    \
    METHOD(svo_many_lights)                          \
    METHOD(vertex_connection_and_merging)            \
    METHOD(visibility_filtering)                     \
    METHOD(voxel_cone_tracing)

namespace photond {

#define PHOTOND_DECLARE_ROW(room) MethodInfo room##_row();
PHOTOND_METHODS(PHOTOND_DECLARE_ROW)

std::span<const MethodInfo> all_methods() {
#define PHOTOND_CALL_ROW(room) room##_row(),
    static const MethodInfo kMethods[] = {PHOTOND_METHODS(PHOTOND_CALL_ROW)};
    return kMethods;
}

const MethodInfo* find_method(std::string_view name) {
    for (const MethodInfo& method : all_methods())
        if (method.name == name) return &method;
    return nullptr;
}

namespace {

bool takes_light_over(const MethodInfo& method, const MethodParams& params) {
    return method.temporal && method.temporal(params)->reuse != TemporalReuse::None;
}

}  // namespace

uint64_t history_bytes(const MethodInfo& method, const MethodParams& params, Size2 film_size) {
    return takes_light_over(method, params) ? TemporalReprojection::estimate_bytes(film_size) : 0;
}

uint64_t history_device_bytes(const MethodInfo& method, const MethodParams& params, Size2 film_size) {
    return takes_light_over(method, params) ? TemporalReprojection::estimate_device_bytes(film_size) : 0;
}

std::span<const ArtefactInfo> all_artefacts() {
    static const std::vector<ArtefactInfo> kArtefacts = [] {
        std::vector<ArtefactInfo> all;
        for (const MethodInfo& method : all_methods())
            for (const ArtefactInfo& artefact : method.artefacts)
                if (std::none_of(all.begin(), all.end(),
                                 [&](const auto& known) { return known.name == artefact.name; }))
                    all.push_back(artefact);
        return all;
    }();
    return kArtefacts;
}

}  // namespace photond
