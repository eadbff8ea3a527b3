#include "renderer/backends/gpu/device_scene.h"

#include <algorithm>

#include "renderer/backends/gpu/bvh.h"
#include "renderer/backends/gpu/scene_shared.h"
#include "renderer/core/srgb.h"
#include "renderer/scene/pose.h"
#include "renderer/transport/bsdf_albedo_table.h"
#include "renderer/transport/light_tables.h"
#include "renderer/transport/sobol.h"

namespace photond::gpu {

namespace {

/// Fills a buffer from its start with many small arrays, of which it holds a few together on the way.
class Filler {
public:
    Filler(Device& device, std::string structure, uint64_t bytes)
        : device_(device), buffer_(device, std::move(structure), std::max<uint64_t>(bytes, kLeastBytes)) {}

    void add(std::span<const std::byte> bytes) {
        if (held_.size() + bytes.size() > kHeldBytes) flush();
        if (bytes.size() > kHeldBytes) {
            upload(device_, buffer_, bytes, done_);
            done_ += bytes.size();
        } else {
            held_.insert(held_.end(), bytes.begin(), bytes.end());
        }
    }
    template <class T>
    void add(const std::vector<T>& elements) {
        add(std::as_bytes(std::span(elements)));
    }
    Buffer finish() {
        flush();
        return std::move(buffer_);
    }

private:
    static constexpr uint64_t kHeldBytes = 4ull << 20, kLeastBytes = 4;

    void flush() {
        upload(device_, buffer_, held_, done_);
        done_ += held_.size();
        held_.clear();
    }

    Device& device_;
    Buffer buffer_;
    std::vector<std::byte> held_;
    uint64_t done_ = 0;
};

/// Floats of one vertex, and where each attribute is among them.
struct AttributeLayout {
    explicit AttributeLayout(const Mesh& mesh) {
        const auto place = [&](bool there, uint32_t floats) {
            const uint32_t at = there ? stride : NO_ATTRIBUTE;
            if (there) stride += floats;
            return at;
        };
        normals = place(!mesh.normals.empty(), 3);
        tangents = place(!mesh.tangents.empty(), 4);
        for (int i = 0; i < 2; ++i) uv[i] = place(!mesh.uv[i].empty(), 2);
        colors = place(!mesh.colors.empty(), 4);
    }
    uint32_t stride = 0;
    uint32_t normals, tangents, uv[2], colors;
};

std::vector<float> interleave(const Mesh& mesh, const AttributeLayout& layout) {
    std::vector<float> floats(mesh.positions.size() * layout.stride);
    const auto put = [&](const auto& attribute, uint32_t at) {
        for (size_t vertex = 0; vertex < attribute.size(); ++vertex)
            std::copy_n(&attribute[vertex].x, attribute[vertex].length(), &floats[vertex * layout.stride + at]);
    };
    put(mesh.normals, layout.normals);
    put(mesh.tangents, layout.tangents);
    for (int i = 0; i < 2; ++i) put(mesh.uv[i], layout.uv[i]);
    put(mesh.colors, layout.colors);
    return floats;
}

uint32_t first_of(uint64_t count) {
    if (count > UINT32_MAX) throw Error(ErrorCode::OutOfMemory, "the scene is too large for a GPU's 32-bit indices");
    return static_cast<uint32_t>(count);
}

std::vector<MeshRecord> mesh_records(const Scene& scene) {
    std::vector<MeshRecord> records;
    uint64_t vertices = 0, triangles = 0, floats = 0;
    for (const Mesh& mesh : scene.meshes) {
        const AttributeLayout layout(mesh);
        const uint32_t first_float = first_of(floats);
        const auto at = [&](uint32_t offset) { return offset == NO_ATTRIBUTE ? NO_ATTRIBUTE : first_float + offset; };
        records.push_back({.first_vertex = first_of(vertices),
                           .first_triangle = first_of(triangles),
                           .triangle_count = first_of(mesh.triangles.size()),
                           .material = mesh.material,
                           .attribute_stride = layout.stride,
                           .normals = at(layout.normals),
                           .tangents = at(layout.tangents),
                           .uv = {at(layout.uv[0]), at(layout.uv[1])},
                           .colors = at(layout.colors)});
        vertices += mesh.positions.size();
        triangles += mesh.triangles.size();
        floats += mesh.positions.size() * layout.stride;
    }
    return records;
}

/// Where a mesh's attributes begin among all floats.
uint64_t first_attribute_of(const MeshRecord& record, const AttributeLayout& layout) {
    const uint32_t places[][2] = {{layout.normals, record.normals},
                                  {layout.tangents, record.tangents},
                                  {layout.uv[0], record.uv[0]},
                                  {layout.uv[1], record.uv[1]},
                                  {layout.colors, record.colors}};
    for (const auto& [offset, place] : places)
        if (offset == 0) return place;  // the first of a vertex's
    return 0;
}

std::vector<InstanceRecord> instance_records(const Scene& scene) {
    std::vector<InstanceRecord> records;
    for (const photond::Instance& instance : scene.instances)
        records.push_back({.to_world = instance.to_world,
                           .normal_to_world = instance.normal_to_world,
                           .mesh = instance.mesh,
                           .flags = (instance.identity ? INSTANCE_IDENTITY : 0) |
                                    (instance.flips_orientation ? INSTANCE_FLIPS_ORIENTATION : 0)});
    return records;
}

TextureRefRecord reference_record(const TextureRef& reference) {
    return {reference.texture, reference.uv_set, reference.row_u, reference.row_v};
}

std::vector<MaterialRecord> material_records(const Scene& scene) {
    static_assert(kNoTexture == NO_TEXTURE);
    static_assert(static_cast<uint32_t>(AlphaMode::Opaque) == ALPHA_OPAQUE &&
                  static_cast<uint32_t>(AlphaMode::Mask) == ALPHA_MASK &&
                  static_cast<uint32_t>(AlphaMode::Blend) == ALPHA_BLEND);
    std::vector<MaterialRecord> records;
    for (const Material& material : scene.materials)
        records.push_back({.base_color = material.base_color,
                           .alpha = material.alpha,
                           .emission = material.emission,
                           .metallic = material.metallic,
                           .roughness = material.roughness,
                           .normal_scale = material.normal_scale,
                           .ior = material.ior,
                           .specular = material.specular,
                           .specular_color = material.specular_color,
                           .transmission = material.transmission,
                           .attenuation_color = material.attenuation_color,
                           .attenuation_distance = material.attenuation_distance,
                           .alpha_mode = static_cast<uint32_t>(material.alpha_mode),
                           .alpha_cutoff = material.alpha_cutoff,
                           .flags = (material.solid ? MATERIAL_SOLID : 0) |
                                    (material.double_sided ? MATERIAL_DOUBLE_SIDED : 0) |
                                    (material.unlit ? MATERIAL_UNLIT : 0),
                           .base_color_texture = reference_record(material.base_color_texture),
                           .metallic_roughness_texture = reference_record(material.metallic_roughness_texture),
                           .normal_texture = reference_record(material.normal_texture),
                           .emission_texture = reference_record(material.emission_texture),
                           .specular_texture = reference_record(material.specular_texture),
                           .specular_color_texture = reference_record(material.specular_color_texture),
                           .transmission_texture = reference_record(material.transmission_texture)});
    return records;
}

std::vector<TextureRecord> texture_records(const Scene& scene) {
    static_assert(static_cast<uint32_t>(Wrap::Repeat) == WRAP_REPEAT &&
                  static_cast<uint32_t>(Wrap::MirroredRepeat) == WRAP_MIRRORED_REPEAT &&
                  static_cast<uint32_t>(Wrap::ClampToEdge) == WRAP_CLAMP_TO_EDGE);
    std::vector<TextureRecord> records;
    uint64_t texels = 0;
    for (const Texture& texture : scene.textures) {
        records.push_back({.first_texel = first_of(texels),
                           .width = texture.size.width,
                           .height = texture.size.height,
                           .wrap_s = static_cast<uint32_t>(texture.wrap_s),
                           .wrap_t = static_cast<uint32_t>(texture.wrap_t),
                           .nearest = texture.nearest});
        texels += texture.texels.size();
    }
    return records;
}

SceneConstants scene_constants(const Scene& scene) {
    SceneConstants constants{.bounds_min = scene.bounds.empty() ? vec3(0) : scene.bounds.min,
                             .bounds_max = scene.bounds.empty() ? vec3(0) : scene.bounds.max,
                             .instance_count = static_cast<uint32_t>(scene.instances.size()),
                             .material_count = static_cast<uint32_t>(scene.materials.size())};
    for (size_t code = 0; code < std::size(constants.srgb_to_linear); ++code)  // as in scene/texture.cpp
        constants.srgb_to_linear[code] = static_cast<float>(srgb_decode(static_cast<double>(code) / 255.0));
    return constants;
}

template <class Elements>
Buffer upload_elements(Device& device, const std::string& structure, const Elements& elements) {
    return make_buffer(device, structure, std::span<const typename Elements::value_type>(elements));
}

/// One array of every mesh, one after the other.
template <class Array>
Buffer upload_of_meshes(Device& device, const std::string& structure, const Scene& scene, const Array& array) {
    uint64_t bytes = 0;
    for (const Mesh& mesh : scene.meshes) bytes += std::span(array(mesh)).size_bytes();
    Filler filler(device, structure, bytes);
    for (const Mesh& mesh : scene.meshes) filler.add(array(mesh));
    return filler.finish();
}

Buffer upload_triangles(Device& device, const Scene& scene) {
    return upload_of_meshes(
        device, "scene_triangles", scene, [](const Mesh& m) -> auto& { return m.triangles; });
}

Buffer upload_attributes(Device& device, const Scene& scene) {
    uint64_t floats = 0;
    for (const Mesh& mesh : scene.meshes) floats += mesh.positions.size() * AttributeLayout(mesh).stride;
    Filler filler(device, "scene_attributes", floats * sizeof(float));
    for (const Mesh& mesh : scene.meshes) filler.add(interleave(mesh, AttributeLayout(mesh)));
    return filler.finish();
}

Buffer upload_texels(Device& device, const Scene& scene) {
    uint64_t bytes = 0;
    for (const Texture& texture : scene.textures) bytes += texture.bytes();
    Filler filler(device, "scene_texels", bytes);
    for (const Texture& texture : scene.textures) filler.add(texture.texels);
    return filler.finish();
}

/// The host's copy of the ray structure is gone before anything else is uploaded.
void upload_rays(Device& device, const Scene& scene, Stats& stats, std::array<Buffer, SCENE_BINDINGS>& buffers) {
    const BvhData bvh = [&] {
        const StageTimer timer(stats, "acceleration_build");
        return build_bvh(scene);
    }();
    const StageTimer timer(stats, "scene_upload");
    buffers[BVH_NODES_BINDING] = upload_elements(device, "bvh_nodes", bvh.nodes);
    buffers[BVH_TRIANGLES_BINDING] = upload_elements(device, "bvh_triangles", bvh.triangles);
}

void upload_lights(Device& device, const LightTables& lights, std::array<Buffer, SCENE_BINDINGS>& buffers) {
    buffers[EMITTERS_BINDING] = upload_elements(device, "light_emitters", lights.emitters);
    buffers[LIGHT_NODES_BINDING] = upload_elements(device, "light_nodes", lights.nodes);
    buffers[LIGHT_WORDS_BINDING] = upload_elements(device, "light_words", lights.words);
    buffers[PUNCTUAL_LIGHTS_BINDING] = upload_elements(device, "punctual_lights", lights.punctual_lights);
    buffers[LIGHT_FLOATS_BINDING] = upload_elements(device, "light_floats", lights.floats);
    buffers[ENVIRONMENT_BINDING] = upload_elements(device, "environment_map", lights.environment);
    buffers[LIGHT_CONSTANTS_BINDING] = upload_elements(device, "light_constants", std::array{lights.constants});
}

/// Constants 0 to 17 of scene.glsl, 18 of bvh.glsl.
std::vector<Specialization> needs_of(const Scene& scene) {
    const Needs& needs = scene.needs;
    const bool transforms = std::any_of(scene.instances.begin(), scene.instances.end(), [](const auto& instance) {
        return !instance.identity || instance.flips_orientation;
    });
    const bool directional =
        std::any_of(scene.punctual_lights.begin(), scene.punctual_lights.end(),
                    [](const PunctualLight& light) { return light.kind == PunctualLight::Kind::Directional; });
    const bool smooth_normals =
        std::any_of(scene.meshes.begin(), scene.meshes.end(), [](const Mesh& mesh) { return !mesh.normals.empty(); });
    std::vector<Specialization> constants;
    for (const bool value :
         {transforms, needs.alpha, needs.normal_maps, needs.base_color_textures, needs.material_textures,
          needs.emission_textures, needs.vertex_colors, needs.only_lambert(), needs.transmission, needs.solid_glass,
          needs.environment, needs.area_lights, needs.punctual_lights, needs.unlit, needs.delta, needs.glossy,
          directional || needs.environment, smooth_normals, has_two_levels(scene)})
        constants.push_back(specialize(static_cast<uint32_t>(constants.size()), value));
    return constants;
}

}  // namespace

std::array<Buffer, SCENE_BINDINGS> DeviceScene::upload_all(Device& device, const Scene& scene, Stats& stats) {
    std::array<Buffer, SCENE_BINDINGS> buffers;
    upload_rays(device, scene, stats, buffers);
    const StageTimer timer(stats, "scene_upload");
    buffers[SCENE_CONSTANTS_BINDING] = upload_elements(device, "scene_constants", std::vector{scene_constants(scene)});
    buffers[TRIANGLES_BINDING] = upload_triangles(device, scene);
    buffers[POSITIONS_BINDING] = upload_of_meshes(
        device, "scene_positions", scene, [](const Mesh& m) -> auto& { return m.positions; });
    buffers[ATTRIBUTES_BINDING] = upload_attributes(device, scene);
    buffers[MESHES_BINDING] = upload_elements(device, "scene_meshes", mesh_records(scene));
    buffers[INSTANCES_BINDING] = upload_elements(device, "scene_instances", instance_records(scene));
    buffers[MATERIALS_BINDING] = upload_elements(device, "scene_materials", material_records(scene));
    buffers[TEXTURES_BINDING] = upload_elements(device, "scene_textures", texture_records(scene));
    buffers[TEXELS_BINDING] = upload_texels(device, scene);
    upload_lights(device, make_light_tables(scene), buffers);
    buffers[TABLES_BINDING] = upload_elements(device, "albedo_table", AlbedoTable::get().device_data());
    buffers[SOBOL_BINDING] = upload_elements(device, "sobol_directions", sobol_directions());
    return buffers;
}

void DeviceScene::bind_all() {
    std::array<Buffer*, SCENE_BINDINGS> all;
    for (size_t i = 0; i < all.size(); ++i) all[i] = &buffers_[i];
    set_.emplace(device_, "scene", all);
}

DeviceScene::DeviceScene(Device& device, const Scene& scene, Stats& stats)
    : device_(device), scene_(scene), buffers_(upload_all(device, scene, stats)), specialization_(needs_of(scene)) {
    bind_all();
}

void DeviceScene::follow(const SceneChange& change, Stats& stats) {
    for (const uint32_t binding : {BVH_NODES_BINDING, BVH_TRIANGLES_BINDING}) buffers_[binding] = {};
    upload_rays(device_, scene_, stats, buffers_);
    const StageTimer timer(stats, "scene_upload");
    // Meshes keep their vertices, however many triangles are left of them.
    const std::vector<MeshRecord> records = mesh_records(scene_);
    for (const auto* meshes : {&change.moved, &change.reshaped})
        for (const uint32_t m : *meshes) {
            const Mesh& mesh = scene_.meshes[m];
            upload(device_, buffers_[POSITIONS_BINDING], std::as_bytes(std::span(mesh.positions)),
                   records[m].first_vertex * sizeof(vec3));
            const AttributeLayout layout(mesh);
            const std::vector<float> attributes = interleave(mesh, layout);
            if (!attributes.empty())
                upload(device_, buffers_[ATTRIBUTES_BINDING], std::as_bytes(std::span(attributes)),
                       first_attribute_of(records[m], layout) * sizeof(float));
        }
    if (!change.reshaped.empty()) {
        buffers_[TRIANGLES_BINDING] = {};
        buffers_[TRIANGLES_BINDING] = upload_triangles(device_, scene_);
        buffers_[MESHES_BINDING] = upload_elements(device_, "scene_meshes", records);
    }
    if (change.materials)
        buffers_[MATERIALS_BINDING] = upload_elements(device_, "scene_materials", material_records(scene_));
    buffers_[SCENE_CONSTANTS_BINDING] =
        upload_elements(device_, "scene_constants", std::vector{scene_constants(scene_)});
    upload_lights(device_, make_light_tables(scene_), buffers_);
    bind_all();
    specialization_ = needs_of(scene_);
}

std::vector<Specialization> DeviceScene::specialization(std::span<const Specialization> more) const {
    std::vector<Specialization> all = specialization_;
    all.insert(all.end(), more.begin(), more.end());
    return all;
}

uint64_t DeviceScene::bytes() const {
    uint64_t bytes = 0;
    for (const Buffer& buffer : buffers_) bytes += buffer.memory_bytes();
    return bytes;
}

std::map<std::string, uint64_t> DeviceScene::structures() const {
    std::map<std::string, uint64_t> structures;
    for (const Buffer& buffer : buffers_) structures[buffer.structure()] += buffer.memory_bytes();
    return structures;
}

}  // namespace photond::gpu
