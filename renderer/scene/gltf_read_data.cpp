// Buffers, buffer views, accessors, images and textures of a document: where bytes are, checked in 64-bit arithmetic.

#include <map>

#include "renderer/scene/gltf_document.h"

namespace photond {

namespace {

// Offsets and lengths are kept below 2^48, so that sums and products with strides and counts cannot overflow 64 bits.
constexpr uint64_t kMaxBytes = uint64_t{1} << 48;
constexpr uint64_t kMaxCount = UINT32_MAX;

uint32_t count_of(const JsonRef& root, std::string_view key) {
    const auto array = root.find(key);
    return array ? array->array_size() : 0;
}

void check_inside(const JsonRef& place, uint64_t offset, uint64_t length, uint64_t available,
                  const std::string& holder) {
    if (offset + length > available)
        place.fail("bytes [" + std::to_string(offset) + ", " + std::to_string(offset + length) + ") lie outside the " +
                   std::to_string(available) + " bytes of " + holder);
}

GltfBuffer read_buffer(const JsonRef& place) {
    GltfBuffer buffer;
    buffer.byte_length = place.require("byteLength").whole(1, kMaxBytes);
    if (const auto uri = place.find("uri")) buffer.uri = uri->text();
    if (const auto meshopt = place.extension("EXT_meshopt_compression"))
        buffer.meshopt_fallback = meshopt->boolean_or("fallback", false);
    return buffer;
}

GltfByteRange read_range(const JsonRef& place, const std::vector<GltfBuffer>& buffers) {
    GltfByteRange range;
    range.buffer = place.require("buffer").index(buffers.size(), "buffers");
    range.offset = place.whole_or("byteOffset", 0, 0, kMaxBytes);
    range.length = place.require("byteLength").whole(1, kMaxBytes);
    check_inside(place, range.offset, range.length, buffers[range.buffer].byte_length,
                 "buffer " + std::to_string(range.buffer));
    return range;
}

template <class Enum>
Enum read_word(const JsonRef& place, const std::map<std::string_view, Enum>& words) {
    const std::string_view word = place.text();
    const auto found = words.find(word);
    if (found == words.end()) {
        std::string known;
        for (const auto& entry : words) known += (known.empty() ? "" : ", ") + std::string(entry.first);
        place.fail("\"" + std::string(word.substr(0, 60)) + "\" is none of " + known);
    }
    return found->second;
}

GltfMeshopt read_meshopt(const JsonRef& place, const std::vector<GltfBuffer>& buffers, uint64_t view_length) {
    using Mode = GltfMeshopt::Mode;
    using Filter = GltfMeshopt::Filter;
    GltfMeshopt meshopt;
    meshopt.source = read_range(place, buffers);
    const JsonRef stride = place.require("byteStride");
    meshopt.stride = static_cast<uint32_t>(stride.whole(1, 256));
    const JsonRef count = place.require("count");
    meshopt.count = count.whole(1, kMaxCount);
    meshopt.mode =
        read_word<Mode>(place.require("mode"),
                        {{"ATTRIBUTES", Mode::Attributes}, {"TRIANGLES", Mode::Triangles}, {"INDICES", Mode::Indices}});
    if (const auto filter = place.find("filter"))
        meshopt.filter = read_word<Filter>(*filter, {{"NONE", Filter::None},
                                                     {"OCTAHEDRAL", Filter::Octahedral},
                                                     {"QUATERNION", Filter::Quaternion},
                                                     {"EXPONENTIAL", Filter::Exponential}});
    if (meshopt.mode == Mode::Attributes) {
        if (meshopt.stride % 4 != 0) stride.fail("must be a multiple of 4 for ATTRIBUTES");
        if (meshopt.filter == Filter::Octahedral && meshopt.stride != 4 && meshopt.stride != 8)
            stride.fail("must be 4 or 8 for the OCTAHEDRAL filter");
        if (meshopt.filter == Filter::Quaternion && meshopt.stride != 8)
            stride.fail("must be 8 for the QUATERNION filter");
    } else {
        if (meshopt.stride != 2 && meshopt.stride != 4) stride.fail("must be 2 or 4 for indices");
        if (meshopt.mode == Mode::Triangles && meshopt.count % 3 != 0)
            count.fail("must be a multiple of 3 for TRIANGLES");
        if (meshopt.filter != Filter::None) place.require("filter").fail("filters belong to ATTRIBUTES only");
    }
    if (meshopt.count * meshopt.stride != view_length)
        count.fail("count x byteStride is " + std::to_string(meshopt.count * meshopt.stride) +
                   ", but the buffer view is " + std::to_string(view_length) + " bytes long");
    // The codecs spend at least a bit on each four bytes that come out, plus headers: what promises more cannot decode,
    // and is refused before memory is taken for it.
    if (view_length > 64 * meshopt.source.length + 65536)
        place.fail(std::to_string(meshopt.source.length) + " compressed bytes cannot hold " +
                   std::to_string(view_length));
    return meshopt;
}

GltfBufferView read_view(const JsonRef& place, const std::vector<GltfBuffer>& buffers) {
    GltfBufferView view;
    view.bytes = read_range(place, buffers);
    if (const auto stride = place.find("byteStride")) {
        view.stride = static_cast<uint32_t>(stride->whole(4, 252));
        if (view.stride % 4 != 0) stride->fail("must be a multiple of 4, not " + std::to_string(view.stride));
    }
    if (const auto meshopt = place.extension("EXT_meshopt_compression"))
        view.meshopt = read_meshopt(*meshopt, buffers, view.bytes.length);
    else if (buffers[view.bytes.buffer].meshopt_fallback)
        place.fail("the buffer is a fallback without data, and the view has no EXT_meshopt_compression");
    return view;
}

ComponentType read_component_type(const JsonRef& place) {
    const uint64_t code = place.whole(0, 65535);
    switch (code) {
        case 5120:
        case 5121:
        case 5122:
        case 5123:
        case 5125:
        case 5126: return static_cast<ComponentType>(code);
        default: place.fail(std::to_string(code) + " is no component type (5120, 5121, 5122, 5123, 5125, 5126)");
    }
}

GltfSparse read_sparse(const JsonRef& place, const GltfAccessor& accessor, const std::vector<GltfBufferView>& views) {
    GltfSparse sparse;
    sparse.count = place.require("count").whole(1, accessor.count);
    const JsonRef indices = place.require("indices");
    const JsonRef index_type = indices.require("componentType");
    sparse.index_view = indices.require("bufferView").index(views.size(), "buffer views");
    sparse.index_offset = indices.whole_or("byteOffset", 0, 0, kMaxBytes);
    sparse.index_type = read_component_type(index_type);
    if (sparse.index_type != ComponentType::U8 && sparse.index_type != ComponentType::U16 &&
        sparse.index_type != ComponentType::U32)
        index_type.fail("sparse indices must be unsigned (5121, 5123 or 5125)");
    check_inside(indices, sparse.index_offset, sparse.count * component_bytes(sparse.index_type),
                 views[sparse.index_view].bytes.length, "buffer view " + std::to_string(sparse.index_view));
    const JsonRef values = place.require("values");
    sparse.value_view = values.require("bufferView").index(views.size(), "buffer views");
    sparse.value_offset = values.whole_or("byteOffset", 0, 0, kMaxBytes);
    check_inside(values, sparse.value_offset, sparse.count * accessor.element_bytes(),
                 views[sparse.value_view].bytes.length, "buffer view " + std::to_string(sparse.value_view));
    for (const uint32_t view : {sparse.index_view, sparse.value_view})
        if (views[view].stride != 0) place.fail("sparse data must be tightly packed, without byteStride");
    return sparse;
}

GltfAccessor read_accessor(const JsonRef& place, const std::vector<GltfBufferView>& views) {
    struct Shape {
        uint32_t columns, rows;
    };
    static const std::map<std::string_view, Shape> kShapes = {{"SCALAR", {1, 1}}, {"VEC2", {1, 2}}, {"VEC3", {1, 3}},
                                                              {"VEC4", {1, 4}},   {"MAT2", {2, 2}}, {"MAT3", {3, 3}},
                                                              {"MAT4", {4, 4}}};
    GltfAccessor accessor;
    accessor.type = read_component_type(place.require("componentType"));
    const Shape shape = read_word<Shape>(place.require("type"), kShapes);
    accessor.columns = shape.columns;
    accessor.rows = shape.rows;
    accessor.count = place.require("count").whole(1, kMaxCount);
    accessor.normalized = place.boolean_or("normalized", false);
    if (accessor.normalized && (accessor.type == ComponentType::F32 || accessor.type == ComponentType::U32))
        place.require("normalized").fail("only 8 and 16 bit integers can be normalized");
    accessor.offset = place.whole_or("byteOffset", 0, 0, kMaxBytes);
    std::vector<double> bounds(accessor.components());
    place.numbers("min", bounds, -JsonRef::kAnyNumber, JsonRef::kAnyNumber);
    place.numbers("max", bounds, -JsonRef::kAnyNumber, JsonRef::kAnyNumber);
    accessor.view = place.index_or_none("bufferView", views.size(), "buffer views");
    if (accessor.view) {
        const GltfBufferView& view = views[*accessor.view];
        const uint64_t size = accessor.element_bytes();
        const uint64_t stride = view.stride == 0 ? size : view.stride;
        if (stride < size)
            place.fail("elements of " + std::to_string(size) + " bytes do not fit the buffer view's byteStride " +
                       std::to_string(stride));
        check_inside(place, accessor.offset, (accessor.count - 1) * stride + size, view.bytes.length,
                     "buffer view " + std::to_string(*accessor.view));
    }
    if (const auto sparse = place.find("sparse")) accessor.sparse = read_sparse(*sparse, accessor, views);
    return accessor;
}

GltfImage read_image(const JsonRef& place, const std::vector<GltfBufferView>& views) {
    GltfImage image;
    image.name = place.text_or("name", "");
    if (const auto uri = place.find("uri")) image.uri = uri->text();
    image.view = place.index_or_none("bufferView", views.size(), "buffer views");
    if (image.uri && image.view) place.fail("has both uri and bufferView");
    if (!image.uri && !image.view) place.fail("has neither uri nor bufferView");
    place.text_or("mimeType", "");  // its type; the image's own header decides
    return image;
}

struct Sampler {
    Wrap wrap_s = Wrap::Repeat;
    Wrap wrap_t = Wrap::Repeat;
    bool nearest = false;
};

Wrap read_wrap(const JsonRef& sampler, std::string_view key) {
    const auto wrap = sampler.find(key);
    if (!wrap) return Wrap::Repeat;
    switch (wrap->whole(0, 65535)) {
        case 10497: return Wrap::Repeat;
        case 33648: return Wrap::MirroredRepeat;
        case 33071: return Wrap::ClampToEdge;
        default: wrap->fail("is no wrap mode (10497, 33648, 33071)");
    }
}

Sampler read_sampler(const JsonRef& place) {
    Sampler sampler{read_wrap(place, "wrapS"), read_wrap(place, "wrapT")};
    if (const auto filter = place.find("magFilter")) {
        const uint64_t code = filter->whole(0, 65535);
        if (code != 9728 && code != 9729) filter->fail("is no magnification filter (9728, 9729)");
        sampler.nearest = code == 9728;
    }
    if (const auto filter = place.find("minFilter")) {
        const uint64_t code = filter->whole(0, 65535);
        if (code != 9728 && code != 9729 && (code < 9984 || code > 9987))
            filter->fail("is no minification filter (9728, 9729, 9984 to 9987)");
    }
    return sampler;
}

GltfTexture read_texture(const JsonRef& place, size_t image_count, const std::vector<Sampler>& samplers) {
    GltfTexture texture;
    texture.name = place.text_or("name", "");
    texture.image = place.index_or_none("source", image_count, "images");
    if (const auto sampler = place.index_or_none("sampler", samplers.size(), "samplers")) {
        texture.wrap_s = samplers[*sampler].wrap_s;
        texture.wrap_t = samplers[*sampler].wrap_t;
        texture.nearest = samplers[*sampler].nearest;
    }
    return texture;
}

/// Reads each element of root[key] by read(place); a faulty one leaves a default in its place.
template <class T, class Read>
void read_all(const JsonRef& root, std::string_view key, std::vector<T>& out, FaultList& faults, const Read& read) {
    faults.collect([&] {
        out.resize(count_of(root, key));
        for (uint32_t i = 0; i < out.size(); ++i) faults.collect([&] { out[i] = read(root.require(key).at(i)); });
    });
}

}  // namespace

void read_gltf_data(const JsonRef& root, GltfDocument& document, FaultList& faults) {
    // What refers to a faulty element would only repeat the complaint: each layer starts when the one below is sound.
    read_all(root, "buffers", document.buffers, faults, read_buffer);
    faults.throw_if_any();
    read_all(root, "bufferViews", document.views, faults,
             [&](const JsonRef& place) { return read_view(place, document.buffers); });
    faults.throw_if_any();
    read_all(root, "accessors", document.accessors, faults,
             [&](const JsonRef& place) { return read_accessor(place, document.views); });
    read_all(root, "images", document.images, faults,
             [&](const JsonRef& place) { return read_image(place, document.views); });
    std::vector<Sampler> samplers;
    read_all(root, "samplers", samplers, faults, read_sampler);
    read_all(root, "textures", document.textures, faults,
             [&](const JsonRef& place) { return read_texture(place, document.images.size(), samplers); });
}

}  // namespace photond
