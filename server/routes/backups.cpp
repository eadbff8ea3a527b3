#include "server/routes/file_reply.h"
#include "server/routes/query.h"
#include "server/routes/routes.h"

namespace photond::http {
namespace {

/// A backup is everything, of everybody.
void require_write(const Call& call) {
    if (call.grant && call.grant->role == Role::Read)
        throw Error(ErrorCode::Forbidden, "a backup needs a token that may write");
}

}  // namespace

void add_backup_routes(std::vector<Route>& routes, Service& service) {
    routes.push_back({.method = "POST", .pattern = "/v1/backups", .lane = Lane::Long, .handle = [&service](Call& call) {
                          Query(call.query).finish();
                          const nlohmann::json backup = service.make_backup();
                          Reply reply = json_reply(201, backup);
                          reply.headers["Location"] = "/v1/backups/" + backup.at("id").get<std::string>();
                          return reply;
                      }});
    routes.push_back({.method = "GET", .pattern = "/v1/backups/{id}", .handle = [&service](Call& call) {
                          Query(call.query).finish();
                          require_write(call);
                          return json_reply(200, service.get_backup(call.path_parameters[0]));
                      }});
    routes.push_back({.method = "GET", .pattern = "/v1/backups/{id}/file", .handle = [&service](Call& call) {
                          Query query(call.query);
                          const std::string path = query.text("path");
                          query.finish();
                          require_write(call);
                          return file_reply(call, service.backup_file(call.path_parameters[0], path));
                      }});
    routes.push_back({.method = "DELETE", .pattern = "/v1/backups/{id}", .handle = [&service](Call& call) {
                          Query(call.query).finish();
                          return json_reply(200, service.remove_backup(call.path_parameters[0]));
                      }});
}

}  // namespace photond::http
