#include "clients/cli/scene_upload.h"

#include "clients/cli/units.h"
#include "clients/cli/upload.h"

namespace photond::cli {

namespace {

using nlohmann::json;

/// Sending the same bytes again is harmless, as ids are made from the content: safe to repeat.
HttpReply post_upload(Session& session, const std::string& path, const Upload& upload) {
    HttpRequest request;
    request.method = "POST";
    request.path = path;
    request.source = upload.body.get();
    request.content_type = upload.content_type;
    return session.daemon().ask(request, Repeat::Safely);
}

}  // namespace

UploadedScene upload_scene(Session& session, const std::string& path, const std::string& name) {
    const Upload upload = plan_scene_upload(path);
    const std::string scene_name = name.empty() ? upload.name : name;
    const size_t others = upload.files.size() - 1;
    session.remark("sending " + path + (others > 0 ? " with " + counted(others, "more file") : "") + ", " +
                   human_bytes(static_cast<double>(upload.body->size_bytes())));
    const HttpReply reply = post_upload(session, "/v1/scenes?name=" + percent_encode(scene_name), upload);
    UploadedScene uploaded{json_of(reply), reply.status == 200};
    const json triangles = uploaded.scene.value("triangles", json());
    session.remark("scene " + plain_text(uploaded.scene.value("id", json())) +
                   (uploaded.known_before ? " (known already)" : "") + ": " +
                   (triangles.is_number() ? human_count(triangles.get<double>()) : "?") + " triangles");
    return uploaded;
}

std::string upload_image(Session& session, const std::string& path) {
    const Upload upload = plan_image_upload(path);
    session.remark("sending " + path + ", " + human_bytes(static_cast<double>(upload.body->size_bytes())));
    const json image = json_of(post_upload(session, "/v1/images", upload));
    return image.at("id").get<std::string>();
}

}  // namespace photond::cli
