#pragma once
// The film on disk: the exact sums themselves, so that a job can be looked at while it runs, encoded by another process
// and continued bit for bit.

#include <filesystem>

#include "renderer/film/film.h"

namespace photond {

/// Format: a header (magic, version, size, layers, passes, counts), then each array of sums in blocks; a block holds
/// its sums with as many bytes each as its widest one needs, and ends with the first 16 bytes of its SHA-256.
/// Little-endian. Version 2 added a layer; files of version 1, which do not have it, are read all the same.
class FilmFile {
public:
    /// Writes beside, fsyncs and renames. Throws ErrorCode::NoSpace when the disk is full.
    static void save(const Film& film, const std::filesystem::path& path);
    /// Throws ErrorCode::Internal when the file is missing, cut short or damaged, ErrorCode::OutOfMemory when the film
    /// would take more than `limit_bytes`.
    static Film load(const std::filesystem::path& path, uint64_t limit_bytes = UINT64_MAX);

private:
    template <class FilmType, class Visitor>
    static void for_each_array(FilmType& film, const Visitor& visitor);
};

}  // namespace photond
