#pragma once
// From a request to what renders it.

#include <memory>
#include <string>
#include <vector>

#include "protocol/job.h"
#include "renderer/frame/method.h"

namespace photond {

/// The method a request asks for, for a device of that kind ("cpu", "gpu"), its parameters checked. Throws
/// photond::Error with every fault's pointer.
std::unique_ptr<Method> make_method(const JobRequest& request, const std::string& device_kind = "cpu");

/// The view a request asks for, its camera found in the scene. Throws photond::Error with pointers into the request.
View resolve_view(const JobRequest& request, const Scene& scene);

/// Those of that name, and the ones that are always there.
LayerSet layers_named(const std::vector<std::string>& names);

}  // namespace photond
