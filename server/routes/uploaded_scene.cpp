#include "server/routes/uploaded_scene.h"

#include <iterator>
#include <optional>

namespace photond::http {

UploadedScene::UploadedScene(Service& service, Call& call, const std::map<std::string, size_t>& fields)
    : folder_(service.make_spool_path()) {
    std::filesystem::create_directory(folder_.path());
    form_ =
        unpack_form(call.spool.path(), multipart_boundary(*call.head.header("content-type")), folder_.path(), fields);
    call.spool = {};
}

Added UploadedScene::add(Service& service, const std::string& name) {
    if (form_.files == 0) throw Error(ErrorCode::MissingField, "the form has no file");
    SceneUpload upload;
    upload.name = name;
    if (const auto named = form_.fields.find("name"); upload.name.empty() && named != form_.fields.end())
        upload.name = named->second;
    const std::filesystem::directory_iterator first(folder_.path());
    const std::string extension = form_.files == 1 ? first->path().extension().string() : "";
    if (extension != ".glb" && extension != ".zip") {
        upload.kind = SceneUpload::Kind::Directory;
        upload.path = folder_.release();
        return service.add_scene(std::move(upload));
    }
    upload.kind = extension == ".zip" ? SceneUpload::Kind::Zip : SceneUpload::Kind::Glb;
    Spool file(service.make_spool_path());
    std::filesystem::rename(first->path(), file.path());
    upload.path = file.release();
    return service.add_scene(std::move(upload));
}

}  // namespace photond::http
