#pragma once
// multipart/form-data from a spooled file into a folder, with memory of one window whatever the size.

#include <filesystem>
#include <string>

namespace photond::http {

struct UploadedForm {
    size_t files = 0;
    std::string name;  // of the form's field "name", which names the scene; empty when there is none
};

/// The boundary of a Content-Type header. Throws Error (BadRequest) when there is no good one.
std::string multipart_boundary(const std::string& content_type);

/// Throws Error (OutOfRange, `pointer` empty) unless `name` is a relative path that stays inside its folder: no "..",
/// no
/// ".", no empty part, no backslash, no control character, at most 16 levels of at most 255 bytes.
void check_relative_path(const std::string& name);

/// Writes each part that has a file name into the existing, empty `folder`, below which parts may name sub-folders.
/// Throws Error: BadRequest for a malformed body, OutOfRange or Conflict for a bad or repeated name, NoSpace.
UploadedForm unpack_form(const std::filesystem::path& body, const std::string& boundary,
                         const std::filesystem::path& folder);

}  // namespace photond::http
