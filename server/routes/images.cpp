#include "protocol/strict_json.h"
#include "server/routes/file_reply.h"
#include "server/routes/query.h"
#include "server/routes/routes.h"

namespace photond::http {

void add_image_routes(std::vector<Route>& routes, Service& service) {
    routes.push_back({.method = "POST",
                      .pattern = "/v1/images",
                      .body = BodyKind::Upload,
                      .lane = Lane::Bulk,
                      .media_types = {"image/x-exr", "image/exr", "application/x-exr", "image/vnd.radiance",
                                      "image/x-hdr", "image/hdr"},
                      .handle = [&service](Call& call) {
                          Query(call.query).finish();
                          const Added added = service.add_image(call.spool.path(), call.head.media_type());
                          Reply reply = json_reply(added.created ? 201 : 200, added.object);
                          reply.headers["Location"] = "/v1/images/" + added.object.at("id").get<std::string>();
                          return reply;
                      }});
    routes.push_back({.method = "POST",
                      .pattern = "/v1/metrics",
                      .body = BodyKind::Json,
                      .lane = Lane::Helper,
                      .handle = [&service](Call& call) {
                          Query(call.query).finish();
                          return json_reply(200, service.measure(parse_strict_json(call.body)));
                      }});
    routes.push_back(
        {.method = "GET", .pattern = "/v1/images/{id}/pixels", .lane = Lane::Helper, .handle = [&service](Call& call) {
             Query query(call.query);
             const std::string layer = query.text("layer");
             const std::string precision = query.text("precision", "float");
             query.finish();
             return file_reply(call, service.image_pixels(call.path_parameters[0], layer, precision));
         }});
    routes.push_back({.method = "GET", .pattern = "/v1/flip", .lane = Lane::Helper, .handle = [&service](Call& call) {
                          Query query(call.query);
                          const std::string image = query.text("image"), reference = query.text("reference");
                          const std::string layer = query.text("layer", "beauty");
                          const std::string range = query.text("range", "hdr");
                          const std::string precision = query.text("precision", "float");
                          query.finish();
                          return file_reply(call, service.flip_map(image, reference, layer, range, precision));
                      }});
    routes.push_back({.method = "GET", .pattern = "/v1/images/{id}", .handle = [&service](Call& call) {
                          Query(call.query).finish();
                          return json_reply(200, service.get_image(call.path_parameters[0]));
                      }});
    routes.push_back({.method = "GET", .pattern = "/v1/images/{id}/file", .handle = [&service](Call& call) {
                          Query(call.query).finish();
                          return file_reply(call, service.image_file(call.path_parameters[0]));
                      }});
}

}  // namespace photond::http
