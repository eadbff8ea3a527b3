#include "renderer/scene/baked_scene.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <type_traits>

#include "protocol/error.h"
#include "renderer/core/atomic_file.h"
#include "renderer/scene/scene.h"

namespace photond {

namespace {

constexpr char kMagic[] = "photond baked scene, version 1\n";

/// What archive A is shown of a T: a reader fills it, others look.
template <class A, class T>
using Shown = std::conditional_t<A::kFills, T, const T>;

/// Visits what a file holds, in the file's order: the writer and the reader are the same list. `A` has value(), for
/// plain values, array(), for strings and vectors of them, and objects(), for vectors of what is visited itself.
template <class A>
void visit(A& archive, Shown<A, TextureRef>& reference) {
    archive.value(reference.texture), archive.value(reference.uv_set);
    archive.value(reference.row_u), archive.value(reference.row_v);
}

template <class A>
void visit(A& archive, Shown<A, Mesh>& mesh) {
    archive.array(mesh.positions), archive.array(mesh.normals), archive.array(mesh.tangents);
    archive.array(mesh.uv[0]), archive.array(mesh.uv[1]), archive.array(mesh.colors), archive.array(mesh.triangles);
    archive.value(mesh.material);
}

template <class A>
void visit(A& archive, Shown<A, Instance>& instance) {
    archive.value(instance.mesh), archive.value(instance.identity), archive.value(instance.to_world);
    archive.value(instance.normal_to_world), archive.value(instance.flips_orientation);
}

template <class A>
void visit(A& archive, Shown<A, Material>& m) {
    archive.array(m.name);
    archive.value(m.base_color), archive.value(m.alpha), archive.value(m.metallic), archive.value(m.roughness);
    archive.value(m.normal_scale), archive.value(m.emission), archive.value(m.ior), archive.value(m.specular);
    archive.value(m.specular_color), archive.value(m.transmission), archive.value(m.solid);
    archive.value(m.attenuation_color), archive.value(m.attenuation_distance), archive.value(m.alpha_mode);
    archive.value(m.alpha_cutoff), archive.value(m.double_sided), archive.value(m.unlit);
    for (auto* reference :
         {&m.base_color_texture, &m.metallic_roughness_texture, &m.normal_texture, &m.emission_texture,
          &m.specular_texture, &m.specular_color_texture, &m.transmission_texture})
        visit(archive, *reference);
}

template <class A>
void visit(A& archive, Shown<A, Texture>& texture) {
    archive.array(texture.name), archive.value(texture.size), archive.array(texture.texels);
    archive.value(texture.wrap_s), archive.value(texture.wrap_t), archive.value(texture.nearest);
}

template <class A>
void visit(A& archive, Shown<A, PunctualLight>& light) {
    archive.array(light.name), archive.value(light.kind), archive.value(light.intensity), archive.value(light.position);
    archive.value(light.direction), archive.value(light.cos_inner), archive.value(light.cos_outer);
    archive.value(light.range_m);
}

template <class A>
void visit(A& archive, Shown<A, Camera>& camera) {
    archive.array(camera.name), archive.value(camera.orthographic), archive.value(camera.yfov);
    archive.value(camera.ymag), archive.value(camera.position), archive.value(camera.right), archive.value(camera.up);
    archive.value(camera.forward), archive.value(camera.aperture_radius_m), archive.value(camera.focus_distance_m);
}

template <class A>
void visit(A& archive, Shown<A, Environment>& environment) {
    archive.value(environment.map.size), archive.array(environment.map.radiance);
    archive.value(environment.scale), archive.value(environment.rotation);
}

template <class A>
void visit(A& archive, Shown<A, Scene>& scene) {
    archive.array(scene.name), archive.value(scene.origin);
    archive.objects(scene.meshes), archive.objects(scene.instances), archive.objects(scene.materials);
    archive.objects(scene.textures), archive.objects(scene.punctual_lights), archive.objects(scene.cameras);
    bool lit_from_outside = scene.environment.has_value();
    archive.value(lit_from_outside);
    if (lit_from_outside) {
        if constexpr (A::kFills) scene.environment.emplace();
        visit(archive, *scene.environment);
    }
}

/// Adds up what a file takes.
class Meter {
public:
    static constexpr bool kFills = false;
    uint64_t bytes() const { return bytes_; }

    template <class T>
    void value(const T& plain) {
        bytes_ += sizeof plain;
    }
    template <class Array>
    void array(const Array& elements) {
        bytes_ += sizeof(uint64_t) + elements.size() * sizeof(elements[0]);
    }
    template <class T>
    void objects(const std::vector<T>& all) {
        bytes_ += sizeof(uint64_t);
        for (const T& object : all) visit(*this, object);
    }

private:
    uint64_t bytes_ = 0;
};

class Writer {
public:
    static constexpr bool kFills = false;
    explicit Writer(const std::filesystem::path& file) : file_(file) { file_.write(kMagic, sizeof kMagic - 1); }
    void commit() { file_.commit(); }

    template <class T>
    void value(const T& plain) {
        static_assert(std::is_trivially_copyable_v<T>);
        file_.write(&plain, sizeof plain);
    }
    template <class Array>
    void array(const Array& elements) {
        value(uint64_t{elements.size()});
        file_.write(elements.data(), elements.size() * sizeof(elements[0]));
    }
    template <class T>
    void objects(const std::vector<T>& all) {
        value(uint64_t{all.size()});
        for (const T& object : all) visit(*this, object);
    }

private:
    AtomicFile file_;
};

/// What a plain value is made of: itself, or the components of a vector or matrix.
template <class T>
struct ScalarOf {
    using type = T;
};
template <class T>
requires requires { typename T::value_type; }
struct ScalarOf<T> {
    using type = typename T::value_type;
};

/// Whether `holds` is true of every floating-point number in `plain`.
template <class T, class Predicate>
bool all_numbers(const T& plain, const Predicate& holds) {
    using Scalar = typename ScalarOf<T>::type;
    if constexpr (std::is_floating_point_v<Scalar>) {
        Scalar numbers[sizeof plain / sizeof(Scalar)];  // NOLINT(bugprone-sizeof-expression): T may be its own scalar
        std::memcpy(numbers, &plain, sizeof plain);
        return std::ranges::all_of(numbers, holds);
    }
    return true;
}

class Reader {
public:
    static constexpr bool kFills = true;
    explicit Reader(const std::filesystem::path& path) : path_(path), file_(path, std::ios::binary | std::ios::ate) {
        if (!file_ || !std::filesystem::is_regular_file(path)) fail("cannot be opened as a file");
        left_ = static_cast<uint64_t>(file_.tellg());
        file_.seekg(0);
        char magic[sizeof kMagic - 1];
        if (left_ < sizeof magic) fail("is not a baked scene of this version");
        read(magic, sizeof magic);
        if (std::memcmp(magic, kMagic, sizeof magic) != 0) fail("is not a baked scene of this version");
    }

    template <class T>
    void value(T& plain) {
        static_assert(std::is_trivially_copyable_v<T>);
        if constexpr (std::is_same_v<T, bool>) {
            uint8_t byte;
            read(&byte, 1);
            if (byte > 1) fail("holds a flag that is neither 0 nor 1");
            plain = byte != 0;
        } else {
            read(&plain, sizeof plain);
            // Infinity is a range or a distance without end.
            if (!all_numbers(plain, [](auto number) { return !std::isnan(number); })) fail("holds what is no number");
        }
    }
    template <class Array>
    void array(Array& elements) {
        const uint64_t count = length(sizeof(elements[0]));
        elements.resize(count);
        read(elements.data(), count * sizeof(elements[0]));
        for (const auto& element : elements)
            if (!all_numbers(element, [](auto number) { return std::isfinite(number); }))
                fail("holds a coordinate or colour that is not finite");
    }
    template <class T>
    void objects(std::vector<T>& all) {
        Meter least;
        visit(least, T());
        all.resize(length(least.bytes()));
        for (T& object : all) visit(*this, object);
    }

    void finish() const {
        if (left_ > 0) fail("goes on after its end");
    }
    [[noreturn]] void fail(const std::string& what) const {
        throw Error(ErrorCode::BadScene, path_.string() + " " + what);
    }

private:
    /// A count that what is left of the file can hold: nothing is allocated for more.
    uint64_t length(uint64_t element_bytes) {
        uint64_t count;
        value(count);
        if (count > left_ / element_bytes) fail("is cut off");
        return count;
    }
    void read(void* to, uint64_t bytes) {
        if (bytes > left_) fail("is cut off");
        if (!file_.read(static_cast<char*>(to), static_cast<std::streamsize>(bytes))) fail("cannot be read");
        left_ -= bytes;
    }

    const std::filesystem::path path_;
    std::ifstream file_;
    uint64_t left_ = 0;
};

/// Every reference is to something that is there.
void check_references(const Scene& scene, const Reader& reader) {
    for (const Mesh& mesh : scene.meshes) {
        const size_t vertices = mesh.positions.size();
        const auto fits = [&](size_t count) { return count == 0 || count == vertices; };
        if (mesh.material >= scene.materials.size()) reader.fail("has a mesh of a material that is not there");
        if (!fits(mesh.normals.size()) || !fits(mesh.tangents.size()) || !fits(mesh.uv[0].size()) ||
            !fits(mesh.uv[1].size()) || !fits(mesh.colors.size()))
            reader.fail("has a mesh whose attributes do not fit its vertices");
        for (const uvec3& corner : mesh.triangles)
            if (std::max({corner.x, corner.y, corner.z}) >= vertices)
                reader.fail("has a triangle of a vertex that is not there");
    }
    for (const Instance& instance : scene.instances)
        if (instance.mesh >= scene.meshes.size()) reader.fail("has an instance of a mesh that is not there");
    for (const Texture& texture : scene.textures)
        if (texture.texels.empty() || texture.texels.size() != texture.size.pixels() ||
            texture.wrap_s > Wrap::ClampToEdge || texture.wrap_t > Wrap::ClampToEdge)
            reader.fail("has a texture that is not whole");
    for (const Material& m : scene.materials) {
        if (m.alpha_mode > AlphaMode::Blend) reader.fail("has a material of no alpha mode");
        for (const TextureRef* reference :
             {&m.base_color_texture, &m.metallic_roughness_texture, &m.normal_texture, &m.emission_texture,
              &m.specular_texture, &m.specular_color_texture, &m.transmission_texture})
            if (reference->uv_set > 1 || reference->texture < kNoTexture ||
                (reference->used() && static_cast<size_t>(reference->texture) >= scene.textures.size()))
                reader.fail("has a material of a texture that is not there");
    }
    for (const PunctualLight& light : scene.punctual_lights)
        if (light.kind > PunctualLight::Kind::Directional) reader.fail("has a light of no kind");
    if (!scene.environment) return;
    const EnvironmentMap& map = scene.environment->map;
    if (map.radiance.empty() || map.radiance.size() != map.size.pixels())
        reader.fail("has an environment that is not whole");
}

}  // namespace

uint64_t baked_scene_bytes(const Scene& scene) {
    Meter meter;
    visit(meter, scene);
    return sizeof kMagic - 1 + meter.bytes();
}

void write_baked_scene(const Scene& scene, const std::filesystem::path& file) {
    Writer writer(file);
    visit(writer, scene);
    writer.commit();
}

Scene read_baked_scene(const std::filesystem::path& file) {
    Reader reader(file);
    Scene scene;
    visit(reader, scene);
    reader.finish();
    check_references(scene, reader);
    finish_scene(scene);
    return scene;
}

}  // namespace photond
