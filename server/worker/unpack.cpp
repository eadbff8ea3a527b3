#include "server/worker/unpack.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zip.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "protocol/error.h"

namespace photond {

namespace {

constexpr size_t kMaxNameBytes = 1024;
constexpr size_t kMaxFolders = 32;  // inside each other

struct Entry {
    zip_uint64_t index = 0;
    std::string name;
    uint64_t bytes = 0;
};

[[noreturn]] void refuse(const std::string& why) {
    throw Error(ErrorCode::BadScene, "the archive cannot be taken: " + why);
}

/// For messages: what cannot be printed is replaced, what is long is cut.
std::string shown(const std::string& name) {
    std::string text = name.substr(0, 80);
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
    return "\"" + text + "\"";
}

/// A relative path of plain names, no "." or "..", nothing a file system or a shell would read otherwise.
void judge_name(const std::string& name) {
    if (name.empty() || name.size() > kMaxNameBytes) refuse("a name of " + std::to_string(name.size()) + " bytes");
    for (const char c : name)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f || c == '\\' || c == ':')
            refuse(shown(name) + " holds a control character, a backslash or a colon");
    if (name.front() == '/') refuse(shown(name) + " is an absolute path");
    size_t folders = 0;
    for (size_t start = 0; start < name.size();) {
        const size_t slash = std::min(name.find('/', start), name.size());
        const std::string part = name.substr(start, slash - start);
        if (part.empty() || part == "." || part == ".." || part.size() > 255)
            refuse(shown(name) + " has a part that is empty, \".\", \"..\" or too long");
        if (++folders > kMaxFolders)
            refuse(shown(name) + " lies in more than " + std::to_string(kMaxFolders) + " folders");
        start = slash + 1;
    }
}

void judge_kind(zip_t* archive, const zip_stat_t& stat, const std::string& name) {
    if (!(stat.valid & ZIP_STAT_SIZE) || !(stat.valid & ZIP_STAT_COMP_SIZE)) refuse(shown(name) + " states no size");
    if ((stat.valid & ZIP_STAT_ENCRYPTION_METHOD) && stat.encryption_method != ZIP_EM_NONE)
        refuse(shown(name) + " is encrypted");
    if (!(stat.valid & ZIP_STAT_COMP_METHOD) ||
        (stat.comp_method != ZIP_CM_STORE && stat.comp_method != ZIP_CM_DEFLATE))
        refuse(shown(name) + " is packed by another method than deflate");
    zip_uint8_t system = 0;
    zip_uint32_t attributes = 0;
    if (zip_file_get_external_attributes(archive, stat.index, 0, &system, &attributes) == 0 &&
        system == ZIP_OPSYS_UNIX) {
        const unsigned kind = (attributes >> 16) & S_IFMT;
        if (kind != 0 && kind != S_IFREG && kind != S_IFDIR) refuse(shown(name) + " is neither a file nor a folder");
    }
}

std::vector<Entry> judge_directory(zip_t* archive, const UnpackLimits& limits) {
    const zip_int64_t count = zip_get_num_entries(archive, 0);
    if (count <= 0) refuse("it is empty");
    if (static_cast<uint64_t>(count) > limits.max_entries)
        refuse("it has " + std::to_string(count) + " entries; the limit is " + std::to_string(limits.max_entries));
    std::vector<Entry> files;
    std::set<std::string> names;
    uint64_t total = 0;
    for (zip_uint64_t i = 0; i < static_cast<zip_uint64_t>(count); ++i) {
        zip_stat_t stat;
        if (zip_stat_index(archive, i, ZIP_FL_ENC_RAW, &stat) != 0 || !(stat.valid & ZIP_STAT_NAME))
            refuse("entry " + std::to_string(i) + " cannot be read");
        std::string name = stat.name;
        const bool folder = !name.empty() && name.back() == '/';
        judge_kind(archive, stat, name);
        if (folder) name.pop_back();
        judge_name(name);
        if (!names.insert(name).second) refuse("two entries are named " + shown(name));
        if (folder) continue;  // made when a file lies in it
        if (stat.size > limits.ratio_free_bytes && stat.size / limits.max_ratio > stat.comp_size)
            refuse(shown(name) + " unpacks " + std::to_string(stat.comp_size) + " bytes to " +
                   std::to_string(stat.size) + "; the limit is a ratio of " + std::to_string(limits.max_ratio));
        if (stat.size > limits.max_total_bytes || (total += stat.size) > limits.max_total_bytes)
            throw Error(ErrorCode::PayloadTooLarge, "the archive unpacks to more than the limit of " +
                                                        std::to_string(limits.max_total_bytes) + " bytes");
        files.push_back({i, std::move(name), stat.size});
    }
    return files;
}

size_t depth_of(const std::string& name) { return static_cast<size_t>(std::count(name.begin(), name.end(), '/')); }

bool is_scene(const std::string& name) {
    const size_t dot = name.rfind('.');
    if (dot == std::string::npos) return false;
    std::string extension = name.substr(dot);
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension == ".gltf" || extension == ".glb";
}

std::string find_scene(const std::vector<Entry>& files) {
    std::vector<std::string> scenes;
    for (const Entry& file : files) {
        if (!is_scene(file.name)) continue;
        if (!scenes.empty() && depth_of(file.name) < depth_of(scenes.front())) scenes.clear();
        if (scenes.empty() || depth_of(file.name) == depth_of(scenes.front())) scenes.push_back(file.name);
    }
    if (scenes.empty()) refuse("it holds no .gltf or .glb");
    if (scenes.size() > 1)
        refuse("it holds " + std::to_string(scenes.size()) + " scenes side by side, among them " + shown(scenes[0]) +
               " and " + shown(scenes[1]) + "; exactly one is expected");
    return scenes.front();
}

[[noreturn]] void fail_writing(const std::string& name, int error) {
    const bool full = error == ENOSPC || error == EDQUOT || error == EFBIG;
    throw Error(full ? ErrorCode::NoSpace : ErrorCode::Internal,
                "cannot write " + shown(name) + ": " + std::strerror(error));
}

struct Descriptor {
    int value;
    ~Descriptor() {
        if (value >= 0) close(value);
    }
};

void unpack_file(zip_t* archive, const Entry& entry, const std::filesystem::path& root) {
    const std::filesystem::path path = root / entry.name;
    std::error_code error;
    std::filesystem::create_directories(path.parent_path(), error);  // of plain names below an empty root
    if (error) refuse(shown(entry.name) + ": a folder on its way cannot be made: " + error.message());
    const Descriptor file{open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644)};
    if (file.value < 0) fail_writing(entry.name, errno);
    const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> in(zip_fopen_index(archive, entry.index, 0), &zip_fclose);
    if (!in) refuse(shown(entry.name) + ": " + zip_strerror(archive));
    std::vector<char> chunk(1 << 18);
    uint64_t written = 0;
    for (;;) {
        const zip_int64_t got = zip_fread(in.get(), chunk.data(), chunk.size());
        if (got < 0) refuse(shown(entry.name) + " is damaged: " + zip_file_strerror(in.get()));
        if (got == 0) break;
        if ((written += static_cast<uint64_t>(got)) > entry.bytes)
            refuse(shown(entry.name) + " unpacks to more than the " + std::to_string(entry.bytes) + " bytes it states");
        for (zip_int64_t done = 0; done < got;) {
            const ssize_t n = write(file.value, chunk.data() + done, static_cast<size_t>(got - done));
            if (n < 0 && errno != EINTR) fail_writing(entry.name, errno);
            if (n > 0) done += n;
        }
    }
    if (written != entry.bytes)
        refuse(shown(entry.name) + " unpacks to " + std::to_string(written) + " bytes, not the " +
               std::to_string(entry.bytes) + " it states");
    if (fsync(file.value) != 0) fail_writing(entry.name, errno);
}

}  // namespace

std::filesystem::path unpack_scene(const std::filesystem::path& zip, const std::filesystem::path& root,
                                   const UnpackLimits& limits) {
    int code = 0;
    const std::unique_ptr<zip_t, void (*)(zip_t*)> archive(zip_open(zip.c_str(), ZIP_RDONLY | ZIP_CHECKCONS, &code),
                                                           &zip_discard);
    if (!archive) {
        zip_error_t error;
        zip_error_init_with_code(&error, code);
        const std::string reason = zip_error_strerror(&error);
        zip_error_fini(&error);
        refuse(reason);
    }
    const std::vector<Entry> files = judge_directory(archive.get(), limits);
    const std::string scene = find_scene(files);
    for (const Entry& file : files) unpack_file(archive.get(), file, root);
    return root / scene;
}

}  // namespace photond
