#include "protocol/object_reader.h"
#include "server/routes/file_reply.h"
#include "server/routes/query.h"
#include "server/routes/routes.h"
#include "server/routes/uploaded_scene.h"

namespace photond::http {
namespace {

Reply post_scene(Service& service, Call& call) {
    Query query(call.query);
    SceneUpload upload;
    upload.name = query.text("name");
    query.finish();
    if (const std::string* header = call.head.header("x-scene-name"); header && upload.name.empty())
        upload.name = *header;

    const std::string type = call.head.media_type();
    const Added added = [&] {
        if (type == "multipart/form-data") return UploadedScene(service, call, {}).add(service, upload.name);
        upload.kind = type == "application/zip" ? SceneUpload::Kind::Zip : SceneUpload::Kind::Glb;
        upload.path = call.spool.release();
        return service.add_scene(std::move(upload));
    }();
    Reply reply = json_reply(added.created ? 201 : 200, added.object);
    reply.headers["Location"] = "/v1/scenes/" + added.object.at("id").get<std::string>();
    return reply;
}

Reply list_scenes(Service& service, Call& call) {
    Query query(call.query);
    const uint32_t limit = query.integer("limit", 100);
    const std::string cursor = query.text("cursor");
    const std::string family = query.text("family");
    query.finish();
    return json_reply(200, service.list_scenes(family, limit, cursor));
}

constexpr uint32_t kLeastSide = 16, kGreatestSide = 512, kMostPasses = 16;

ScenePreview read_scene_preview(Query& query) {
    ScenePreview wanted;
    wanted.camera = query.text("camera");
    nlohmann::json look_at = nlohmann::json::object();
    for (const char* member : {"eye", "target", "up"})
        if (const auto point = query.point(member)) look_at[member] = *point;
    if (const auto yfov = query.number("yfov")) look_at["yfov"] = *yfov;
    wanted.width = query.integer("width", wanted.width);
    wanted.height = query.integer("height", wanted.height);
    wanted.passes = query.integer("passes", wanted.passes);
    query.finish();

    BodyFaults faults;
    if (!look_at.empty()) wanted.look_at = read_look_at(look_at, "", faults);
    if (!look_at.empty() && !wanted.camera.empty())
        faults.add(ErrorCode::Conflict, "/camera", "a view is a camera or an eye and its target, not both");
    const auto check = [&](const char* name, uint32_t value, uint32_t least, uint32_t most) {
        if (value < least || value > most)
            faults.add(ErrorCode::OutOfRange, std::string("/") + name,
                       std::string(name) + " = " + std::to_string(value) + " is outside [" + std::to_string(least) +
                           ", " + std::to_string(most) + "]");
    };
    check("width", wanted.width, kLeastSide, kGreatestSide);
    check("height", wanted.height, kLeastSide, kGreatestSide);
    check("passes", wanted.passes, 1, kMostPasses);
    faults.throw_if_any();
    return wanted;
}

Reply scene_preview(Service& service, Call& call) {
    Query query(call.query);
    const ScenePreview wanted = read_scene_preview(query);
    Reply reply;
    DrawnPreview drawn = service.scene_preview(call.path_parameters[0], wanted);
    reply.body = std::move(drawn.png);
    reply.media_type = "image/png";
    reply.headers["Cache-Control"] = "no-store";
    reply.headers["X-Exposure-Stops"] = drawn.exposure_stops;
    return reply;
}

}  // namespace

void add_scene_routes(std::vector<Route>& routes, Service& service) {
    routes.push_back({.method = "POST",
                      .pattern = "/v1/scenes",
                      .body = BodyKind::Upload,
                      .lane = Lane::Bulk,
                      .media_types = {"model/gltf-binary", "application/zip", "multipart/form-data"},
                      .handle = [&service](Call& call) { return post_scene(service, call); }});
    routes.push_back({.method = "GET", .pattern = "/v1/scenes", .handle = [&service](Call& call) {
                          return list_scenes(service, call);
                      }});
    routes.push_back({.method = "GET", .pattern = "/v1/scenes/{scene}", .handle = [&service](Call& call) {
                          Query(call.query).finish();
                          return json_reply(200, service.get_scene(call.path_parameters[0]));
                      }});
    routes.push_back({.method = "DELETE", .pattern = "/v1/scenes/{scene}", .handle = [&service](Call& call) {
                          Query(call.query).finish();
                          return json_reply(200, service.delete_scene(call.path_parameters[0]));
                      }});
    routes.push_back({.method = "GET",
                      .pattern = "/v1/scenes/{scene}/thumbnail.png",
                      .lane = Lane::Helper,
                      .handle = [&service](Call& call) {
                          Query(call.query).finish();
                          return file_reply(call, service.thumbnail(call.path_parameters[0]));
                      }});
    routes.push_back({.method = "GET",
                      .pattern = "/v1/scenes/{scene}/preview.png",
                      .lane = Lane::Helper,
                      .handle = [&service](Call& call) { return scene_preview(service, call); }});
    routes.push_back(
        {.method = "GET", .pattern = "/v1/scenes/{scene}/baked", .lane = Lane::Bulk, .handle = [&service](Call& call) {
             Query(call.query).finish();
             return file_reply(call, service.baked_scene(call.path_parameters[0]));
         }});
}

}  // namespace photond::http
