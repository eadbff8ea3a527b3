#include "server/worker/pack.h"

#include <zip.h>

#include <cerrno>

#include "protocol/error.h"

namespace photond {

namespace {

[[noreturn]] void fail(const std::string& what, zip_error_t* error) {
    const bool full = zip_error_code_system(error) == ENOSPC || zip_error_code_system(error) == EDQUOT;
    throw Error(full ? ErrorCode::NoSpace : ErrorCode::Internal,
                "cannot " + what + " the archive: " + zip_error_strerror(error));
}

}  // namespace

void pack_files(const PackRequest& asked) {
    int code = 0;
    zip_t* const archive = zip_open(asked.out.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code);
    if (archive == nullptr) {
        zip_error_t error;
        zip_error_init_with_code(&error, code);
        fail("create", &error);
    }
    for (const PackRequest::Item& item : asked.items) {
        zip_source_t* const source = zip_source_file(archive, item.file.c_str(), 0, -1);
        const zip_int64_t index =
            source == nullptr ? -1 : zip_file_add(archive, item.name.c_str(), source, ZIP_FL_ENC_UTF_8);
        if (index < 0 && source != nullptr) zip_source_free(source);
        // Images are compressed already. The time is the archive's first possible one: the same files, the same bytes.
        if (index < 0 || zip_set_file_compression(archive, static_cast<zip_uint64_t>(index), ZIP_CM_STORE, 0) != 0 ||
            zip_file_set_dostime(archive, static_cast<zip_uint64_t>(index), 0, 1 << 5 | 1, 0) != 0) {
            const std::string name = item.name;
            zip_error_t* const error = zip_get_error(archive);
            try {
                fail("put " + name + " into", error);
            } catch (...) {
                zip_discard(archive);
                throw;
            }
        }
    }
    if (zip_close(archive) != 0) try {
            fail("write", zip_get_error(archive));
        } catch (...) {
            zip_discard(archive);
            throw;
        }
}

}  // namespace photond
