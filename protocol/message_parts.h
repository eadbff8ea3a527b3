#pragma once
// Parts that messages of workers and requests of the helper have in common.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "protocol/message_json.h"

namespace photond {

/// An Error on its way to the daemon.
struct Failure {
    struct Place {
        std::string code, pointer, detail;

        void visit(MessageVisitor& visitor) {
            visitor.member("code", code);
            visitor.member("pointer", pointer);
            visitor.member("detail", detail);
        }
    };
    std::string code;  // of kErrorKinds; one that is not there is read as Internal
    std::string detail;
    std::vector<Place> errors;

    static Failure of(const Error& error);
    void visit(MessageVisitor& visitor) {
        visitor.member("code", code);
        visitor.member("detail", detail);
        visitor.member("errors", errors);
    }
};

/// The Error that a failure stands for; Internal where no failure is given.
Error error_of(const std::optional<Failure>& failure);

/// Where a scene comes from.
struct SceneSource {
    std::string id;
    std::string builtin;         // empty: from a file
    std::filesystem::path root;  // folder that the file and all that it names are in; empty for a built-in scene
    std::filesystem::path file;  // .gltf or .glb; likewise

    void visit(MessageVisitor& visitor) {
        visitor.member("id", id);
        visitor.or_null("builtin", builtin);
        visitor.or_null("root", root);
        visitor.or_null("file", file);
    }
};

/// An image that is measured or measured against: exactly one of these.
struct ImageSource {
    std::optional<std::filesystem::path> film;
    std::optional<std::filesystem::path> image;  // EXR or Radiance HDR

    const std::filesystem::path& path() const { return film ? *film : *image; }
    void visit(MessageVisitor& visitor) {
        visitor.if_any("film", film);
        visitor.if_any("image", image);
    }
};

/// What an image is measured against: one image, or two films of one truth whose noise is independent.
struct ReferenceSource {
    static constexpr const char* kTwoFilms = "two_films";
    static constexpr const char* kFilm = "film";
    static constexpr const char* kImage = "image";

    ImageSource first;
    std::optional<ImageSource> second;

    /// One of these: how what is measured against it is measured. Two images count as two films.
    const char* form() const { return second ? kTwoFilms : first.film ? kFilm : kImage; }

    void visit(MessageVisitor& visitor) {
        first.visit(visitor);  // its member lies beside the other's name
        visitor.if_any("second", second);
    }
};

/// What bounds the files that a process of the daemon's may open.
struct FileAccess {
    static constexpr const char* kLandlock = "landlock";
    static constexpr const char* kMountNamespace = "mount_namespace";
    static constexpr const char* kNone = "none";

    std::string by = kNone;          // one of these
    std::optional<int64_t> version;  // Landlock's

    void visit(MessageVisitor& visitor) {
        visitor.member("by", by);
        visitor.or_null("version", version);
    }
};

}  // namespace photond
