#pragma once
// multipart/form-data from a spooled file into a folder, with memory of one window whatever the size.

#include <filesystem>
#include <map>
#include <string>

namespace photond::http {

struct UploadedForm {
    size_t files = 0;
    std::map<std::string, std::string> fields;
};

/// The boundary of a Content-Type header. Throws Error (BadRequest) when there is no good one.
std::string multipart_boundary(const std::string& content_type);

/// Throws Error (OutOfRange, `pointer` empty) unless `name` is a relative path that stays inside its folder: no "..",
/// no
/// ".", no empty part, no backslash, no control character, at most 16 levels of at most 255 bytes.
void check_relative_path(const std::string& name);

/// Writes each part that has a file name into the existing, empty `folder`, below which parts may name sub-folders.
/// `fields`: those that the form may have beside, with the most bytes of each; "name", which names a scene, is always
/// among them. A part of such a field is no file, whatever its file name.
/// Throws Error: BadRequest for a malformed body, OutOfRange or Conflict for a bad or repeated name, UnknownField,
/// NoSpace.
UploadedForm unpack_form(const std::filesystem::path& body, const std::string& boundary,
                         const std::filesystem::path& folder, const std::map<std::string, size_t>& fields = {});

}  // namespace photond::http
