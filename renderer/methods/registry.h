#pragma once
// The one list of methods. Only methods that work are in it.

#include <span>

#include "renderer/frame/method_info.h"

namespace photond {

std::span<const MethodInfo> all_methods();  // by name
/// What frames hold of the host's memory for MethodInfo::temporal, beside what their method takes; 0 where they take
/// nothing over by it.
uint64_t history_bytes(const MethodInfo& method, const MethodParams& params, Size2 film_size);
/// The same of a device's memory, where they are rendered on one.
uint64_t history_device_bytes(const MethodInfo& method, const MethodParams& params, Size2 film_size);
/// nullptr when there is none of that name.
const MethodInfo* find_method(std::string_view name);
/// Of all methods, each name once.
std::span<const ArtefactInfo> all_artefacts();

}  // namespace photond
