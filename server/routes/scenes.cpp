#include <filesystem>

#include "server/routes/file_reply.h"
#include "server/routes/multipart.h"
#include "server/routes/query.h"
#include "server/routes/routes.h"

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
    Spool folder;  // removed on every way out but success
    if (type == "multipart/form-data") {
        folder = Spool(service.make_spool_path());
        std::filesystem::create_directory(folder.path());
        const UploadedForm form =
            unpack_form(call.spool.path(), multipart_boundary(*call.head.header("content-type")), folder.path());
        if (form.files == 0) throw Error(ErrorCode::MissingField, "the form has no file");
        if (upload.name.empty()) upload.name = form.name;
        call.spool = {};  // frees its disk space before the scene is judged
        upload.kind = SceneUpload::Kind::Directory;
        upload.path = folder.release();
    } else {
        upload.kind = type == "application/zip" ? SceneUpload::Kind::Zip : SceneUpload::Kind::Glb;
        upload.path = call.spool.release();
    }
    const Added added = service.add_scene(std::move(upload));
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

}  // namespace

void add_scene_routes(std::vector<Route>& routes, Service& service) {
    routes.push_back({.method = "POST",
                      .pattern = "/v1/scenes",
                      .body = BodyKind::Upload,
                      .lane = Lane::Slow,
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
                      .lane = Lane::Slow,
                      .handle = [&service](Call& call) {
                          Query(call.query).finish();
                          return file_reply(call, service.thumbnail(call.path_parameters[0]));
                      }});
    routes.push_back(
        {.method = "GET", .pattern = "/v1/scenes/{scene}/baked", .lane = Lane::Slow, .handle = [&service](Call& call) {
             Query(call.query).finish();
             return file_reply(call, service.baked_scene(call.path_parameters[0]));
         }});
}

}  // namespace photond::http
