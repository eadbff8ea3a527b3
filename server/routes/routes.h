#pragma once
// What is served: one table, filled by subject. Each handler parses, calls the service, and replies.

#include <vector>

#include "server/routes/exchange.h"
#include "server/service.h"

namespace photond::http {

// `service` is borrowed by the handlers.
void add_scene_routes(std::vector<Route>& routes, Service& service);
void add_job_routes(std::vector<Route>& routes, Service& service);
void add_artefact_routes(std::vector<Route>& routes, Service& service);
void add_render_routes(std::vector<Route>& routes, Service& service);
void add_comparison_routes(std::vector<Route>& routes, Service& service);
void add_sequence_routes(std::vector<Route>& routes, Service& service);
void add_image_routes(std::vector<Route>& routes, Service& service);
void add_backup_routes(std::vector<Route>& routes, Service& service);
void add_system_routes(std::vector<Route>& routes, Service& service);
void add_dashboard_routes(std::vector<Route>& routes);

}  // namespace photond::http
