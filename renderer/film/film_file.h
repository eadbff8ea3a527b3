#pragma once
// The film on disk: the exact sums themselves, so that a job can be looked at while it runs, encoded by another process
// and continued bit for bit.

#include <filesystem>

#include "renderer/film/film.h"

namespace photond {

/// What must be equal for two films to be parts of one image. Texts are opaque here and compared whole.
struct FilmIdentity {
    std::string scene;     // content of the scene
    std::string settings;  // of everything else that decides a pass's pixels
    std::string device;    // class of devices that give the same bits, and version of the program
    bool operator==(const FilmIdentity&) const = default;
};

/// A film as an artefact: it can be gone on with, and joined with others of its kind.
struct SavedFilm {
    Film film;
    FilmIdentity identity;
    std::string history;  // what its owner wants to find again with it (JSON); opaque here
    std::string state;    // what the method that goes on with it needs (Method::state()); opaque here
    std::string left;     // what the frame after it follows from (Method::left_to_next()); opaque here
};

/// What a film's file says of itself, without its sums.
struct FilmFacts {
    uint32_t passes = 0;
    std::string history;
    std::string origin;  // who rendered it for whom, as its owner wrote it down; empty of older files
};

/// Format: a header (magic, version, size, layers, passes, counts), identity, history, pass ranges, origin and pass
/// means, the method's state in pieces, what is left to the next frame likewise, then each array of sums in blocks; a
/// block holds its sums with as many bytes each as its widest one needs, and ends with the first 16 bytes of its
/// SHA-256. Little-endian. Files of versions 1 (without the layers added since), 2 (without identity, history and
/// ranges), 4 (without origin), 5 (without pass means) and 6 (without state) are read all the same: their identity is
/// empty and their passes begin at 0, their origin is empty, their pass means are of no pass, their state is empty.
/// Version 9 is written where something is left to the next frame, else 8 where there are layers beyond the first 32,
/// which programs of before would not know of, else 7.
class FilmFile {
public:
    /// Writes beside, fsyncs and renames. Throws ErrorCode::NoSpace when the disk is full.
    static void save(const Film& film, const FilmIdentity& identity, const std::string& history,
                     const std::filesystem::path& path, const std::string& origin = {}, const std::string& state = {},
                     const std::string& left = {});
    /// Throws ErrorCode::Internal when the file is missing, cut short or damaged, ErrorCode::OutOfMemory when the film
    /// and its state would take more than `limit_bytes`.
    static SavedFilm load(const std::filesystem::path& path, uint64_t limit_bytes = UINT64_MAX);
    /// SavedFilm::left, without the film's sums. Throws as load(), and ErrorCode::Conflict where scene or device are
    /// not those of `identity`.
    static std::string load_left(const std::filesystem::path& path, const FilmIdentity& identity,
                                 uint64_t limit_bytes = UINT64_MAX);
    /// Reads all of the file and holds it to its checksums, in little memory. Throws as load().
    static FilmFacts examine(const std::filesystem::path& path);

private:
    template <class FilmType, class Visitor>
    static void for_each_array(FilmType& film, const Visitor& visitor);
};

/// Throws ErrorCode::Conflict that names what differs (scene, settings, device) and both texts' beginnings. An empty
/// identity is like nothing, itself included.
void require_alike(const FilmIdentity& a, const FilmIdentity& b);

}  // namespace photond
