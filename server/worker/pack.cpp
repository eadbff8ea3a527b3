#include "server/worker/pack.h"

#include <zip.h>

#include <cerrno>
#include <memory>
#include <string>

#include "protocol/error.h"

namespace photond {

namespace {

Error failure(const std::string& what, zip_error_t* error) {
    const bool full = zip_error_code_system(error) == ENOSPC || zip_error_code_system(error) == EDQUOT;
    return {full ? ErrorCode::NoSpace : ErrorCode::Internal,
            "cannot " + what + " the archive: " + zip_error_strerror(error)};
}

/// Nothing is written of an archive that is let go without zip_close().
using Archive = std::unique_ptr<zip_t, decltype(&zip_discard)>;

void add(zip_t* archive, const PackRequest::Item& item) {
    zip_source_t* const source = zip_source_file(archive, item.file.c_str(), 0, -1);
    const zip_int64_t index =
        source == nullptr ? -1 : zip_file_add(archive, item.name.c_str(), source, ZIP_FL_ENC_UTF_8);
    if (index < 0 && source != nullptr) zip_source_free(source);
    const auto place = static_cast<zip_uint64_t>(index);
    // Images are compressed already. The time is the archive's first possible one: the same files, the same bytes.
    if (index < 0 || zip_set_file_compression(archive, place, ZIP_CM_STORE, 0) != 0 ||
        zip_file_set_dostime(archive, place, 0, 1 << 5 | 1, 0) != 0)
        throw failure("put " + item.name + " into", zip_get_error(archive));
}

}  // namespace

void pack_files(const PackRequest& asked) {
    int code = 0;
    Archive archive(zip_open(asked.out.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code), &zip_discard);
    if (!archive) {
        zip_error_t error;
        zip_error_init_with_code(&error, code);
        throw failure("create", &error);
    }
    for (const PackRequest::Item& item : asked.items) add(archive.get(), item);
    if (zip_close(archive.get()) != 0) throw failure("write", zip_get_error(archive.get()));
    (void)archive.release();
}

}  // namespace photond
