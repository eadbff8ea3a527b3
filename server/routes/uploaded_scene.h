#pragma once
// A scene that came as a form: a .gltf with its files, or one .glb or .zip.

#include <filesystem>
#include <map>
#include <string>

#include "server/routes/exchange.h"
#include "server/routes/multipart.h"
#include "server/service.h"

namespace photond::http {

class UploadedScene {
public:
    /// Unpacks the form of a request of multipart/form-data, whose fields beside its files may have so many bytes, and
    /// frees the disk space of its body.
    UploadedScene(Service& service, Call& call, const std::map<std::string, size_t>& fields);

    const UploadedForm& form() const { return form_; }
    /// Service::add_scene(). Throws MissingField where the form has no file.
    Added add(Service& service, const std::string& name = "");

private:
    Spool folder_;  // removed unless it was handed on
    UploadedForm form_;
};

}  // namespace photond::http
