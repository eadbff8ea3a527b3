#include "renderer/scene/gltf_accessor.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <cstring>

namespace photond {

namespace {

// An accessor without a buffer view is zeros: one element of them, with stride 0, stands for all.
constexpr uint8_t kZeros[64] = {};
constexpr const char* kMeshopt = "EXT_meshopt_compression";

template <class T>
T load(const uint8_t* at) {
    T value;
    std::memcpy(&value, at, sizeof value);
    return value;
}

[[noreturn]] void bad(std::string pointer, const std::string& detail) {
    throw Error(ErrorCode::BadScene, std::move(pointer), detail);
}

}  // namespace

float AccessorView::component(const uint8_t* at) const {
    // glTF 2.0, 3.11: c / 127 and c / 32767 for signed types, not below -1.
    switch (type_) {
        case ComponentType::F32: return load<float>(at);
        case ComponentType::U8: return normalized_ ? static_cast<float>(*at) / 255.0f : static_cast<float>(*at);
        case ComponentType::U16: {
            const auto c = static_cast<float>(load<uint16_t>(at));
            return normalized_ ? c / 65535.0f : c;
        }
        case ComponentType::I8: {
            const auto c = static_cast<float>(load<int8_t>(at));
            return normalized_ ? std::max(c / 127.0f, -1.0f) : c;
        }
        case ComponentType::I16: {
            const auto c = static_cast<float>(load<int16_t>(at));
            return normalized_ ? std::max(c / 32767.0f, -1.0f) : c;
        }
        case ComponentType::U32: return static_cast<float>(load<uint32_t>(at));
    }
    return 0;
}

uint32_t AccessorView::whole(uint64_t i, uint32_t row) const {
    const uint8_t* at = data_ + i * stride_ + row * component_bytes(type_);
    switch (component_bytes(type_)) {
        case 1: return *at;
        case 2: return load<uint16_t>(at);
        default: return load<uint32_t>(at);
    }
}

dmat4 AccessorView::matrix(uint64_t i) const {
    dmat4 m;
    for (uint32_t column = 0; column < 4; ++column)
        for (uint32_t row = 0; row < 4; ++row)
            m[static_cast<int>(column)][static_cast<int>(row)] = static_cast<double>(
                component(data_ + i * stride_ + column * column_bytes_ + row * component_bytes(type_)));
    return m;
}

GltfData::GltfData(const GltfDocument& document, std::span<const uint8_t> binary_chunk, BundleFiles& files,
                   std::string folder, uint64_t max_made_bytes)
    : document_(document),
      binary_chunk_(binary_chunk),
      files_(files),
      folder_(std::move(folder)),
      buffers_(document.buffers.size()),
      views_(document.model.bufferViews.size()),
      accessors_(document.model.accessors.size()),
      max_made_bytes_(max_made_bytes) {}

std::span<const uint8_t> GltfData::buffer_bytes(uint32_t index) {
    Held& held = buffers_[index];
    if (held.loaded) return held.bytes;
    const GltfBuffer& buffer = document_.buffers[index];
    if (buffer.uri) {
        const std::string pointer = gltf_pointer("buffers", index, "uri");
        held.owned = is_data_uri(*buffer.uri) ? decode_data_uri(*buffer.uri, pointer)
                                              : files_.read(folder_ + path_of_uri(*buffer.uri, pointer), pointer);
        held.bytes = held.owned;
    } else if (buffer.meshopt_fallback) {
        bad(gltf_pointer("buffers", index), "the buffer is a fallback without data");
    } else if (index == 0 && !binary_chunk_.empty()) {
        held.bytes = binary_chunk_;
    } else {
        bad(gltf_pointer("buffers", index), index == 0 ? "has no uri, and there is no binary chunk" : "has no uri");
    }
    if (held.bytes.size() < buffer.byte_length)
        bad(gltf_pointer("buffers", index, "byteLength"), "is " + std::to_string(buffer.byte_length) + ", but only " +
                                                              std::to_string(held.bytes.size()) + " bytes are there");
    held.loaded = true;
    return held.bytes;
}

std::span<const uint8_t> GltfData::view_bytes(uint32_t index) {
    const tinygltf::BufferView& view = document_.model.bufferViews[index];
    if (gltf_extension(view.extensions, kMeshopt) == nullptr)
        return buffer_bytes(view.buffer).subspan(view.byteOffset, view.byteLength);
    Held& held = views_[index];
    if (!held.loaded) {
        held.owned = decompress(index);
        held.bytes = held.owned;
        held.loaded = true;
    }
    return held.bytes;
}

std::vector<uint8_t> GltfData::decompress(uint32_t index) {
    const tinygltf::Value& meshopt = *gltf_extension(document_.model.bufferViews[index].extensions, kMeshopt);
    const auto number = [&](const char* key) {
        return static_cast<size_t>(meshopt.Has(key) ? meshopt.Get(key).GetNumberAsDouble() : 0);
    };
    const size_t count = number("count"), stride = number("byteStride");
    const std::span<const uint8_t> source =
        buffer_bytes(static_cast<uint32_t>(number("buffer"))).subspan(number("byteOffset"), number("byteLength"));
    std::vector<uint8_t> result(count * stride);
    const std::string& mode = meshopt.Get("mode").Get<std::string>();
    using Decode = int (*)(void*, size_t, size_t, const unsigned char*, size_t);
    const Decode decode = mode == "ATTRIBUTES"  ? Decode{meshopt_decodeVertexBuffer}
                          : mode == "TRIANGLES" ? Decode{meshopt_decodeIndexBuffer}
                                                : Decode{meshopt_decodeIndexSequence};
    if (const int failure = decode(result.data(), count, stride, source.data(), source.size()); failure != 0)
        bad(gltf_pointer("bufferViews", index, "extensions", kMeshopt),
            "the compressed data cannot be decoded (code " + std::to_string(failure) + ")");
    const std::string& filter = meshopt.Get("filter").Get<std::string>();
    if (filter == "OCTAHEDRAL") meshopt_decodeFilterOct(result.data(), count, stride);
    if (filter == "QUATERNION") meshopt_decodeFilterQuat(result.data(), count, stride);
    if (filter == "EXPONENTIAL") meshopt_decodeFilterExp(result.data(), count, stride);
    return result;
}

AccessorView GltfData::accessor(uint32_t index) {
    const tinygltf::Accessor& accessor = document_.model.accessors[index];
    const ElementLayout layout = element_layout(accessor);
    AccessorView view;
    view.count_ = accessor.count;
    view.type_ = layout.type;
    view.rows_ = layout.rows;
    view.column_bytes_ = layout.column_bytes();
    view.normalized_ = accessor.normalized;
    view.stride_ = layout.element_bytes();
    if (accessor.sparse.isSparse) {
        Held& held = accessors_[index];
        if (!held.loaded) {
            held.owned = apply_sparse(index);
            held.loaded = true;
        }
        view.data_ = held.owned.data();
    } else if (accessor.bufferView >= 0) {
        const size_t stride = document_.model.bufferViews[accessor.bufferView].byteStride;
        view.data_ = view_bytes(accessor.bufferView).data() + accessor.byteOffset;
        if (stride != 0) view.stride_ = stride;
    } else {
        view.data_ = kZeros;
        view.stride_ = 0;
    }
    return view;
}

std::vector<uint8_t> GltfData::apply_sparse(uint32_t index) {
    const tinygltf::Accessor& accessor = document_.model.accessors[index];
    const auto& sparse = accessor.sparse;
    const uint32_t size = element_layout(accessor).element_bytes();
    // Sparse values over nothing: what the zeros take may not be out of all proportion to the file.
    constexpr uint64_t kMaxZeroBytes = 32ull << 20;
    if (accessor.bufferView < 0 && accessor.count * size > kMaxZeroBytes)
        bad(gltf_pointer("accessors", index, "count"), std::to_string(accessor.count) +
                                                           " elements without a buffer view take more than " +
                                                           std::to_string(kMaxZeroBytes) + " bytes");
    charge(accessor.count * size, gltf_pointer("accessors", index, "count"));
    std::vector<uint8_t> elements(accessor.count * size);
    if (accessor.bufferView >= 0) {
        const size_t view_stride = document_.model.bufferViews[accessor.bufferView].byteStride;
        const uint64_t stride = view_stride == 0 ? size : view_stride;
        const uint8_t* source = view_bytes(accessor.bufferView).data() + accessor.byteOffset;
        for (uint64_t i = 0; i < accessor.count; ++i) std::memcpy(&elements[i * size], source + i * stride, size);
    }
    const uint8_t* indices = view_bytes(sparse.indices.bufferView).data() + sparse.indices.byteOffset;
    const uint8_t* values = view_bytes(sparse.values.bufferView).data() + sparse.values.byteOffset;
    const uint32_t index_size = component_bytes(static_cast<ComponentType>(sparse.indices.componentType));
    int64_t last = -1;
    for (uint64_t i = 0; i < static_cast<uint64_t>(sparse.count); ++i) {
        const uint8_t* at = indices + i * index_size;
        const uint32_t target = index_size == 1 ? *at : index_size == 2 ? load<uint16_t>(at) : load<uint32_t>(at);
        if (target >= accessor.count || int64_t{target} <= last)
            bad(gltf_pointer("accessors", index, "sparse", "indices"),
                "index " + std::to_string(target) + " at position " + std::to_string(i) +
                    (target >= accessor.count ? " is not below the count " + std::to_string(accessor.count)
                                              : " does not exceed the one before it"));
        last = target;
        std::memcpy(&elements[target * uint64_t{size}], values + i * size, size);
    }
    return elements;
}

void GltfData::charge(uint64_t bytes, const std::string& pointer) {
    const uint64_t limit = max_made_bytes_ + files_.bytes_read();
    if (bytes > limit || made_bytes_ + bytes > limit)
        bad(pointer, "keys, morph targets, joints and sparse accessors take " + std::to_string(made_bytes_ + bytes) +
                         " bytes up to here, more than the limit of " + std::to_string(limit) + " for files of " +
                         std::to_string(files_.bytes_read()) + " bytes");
    made_bytes_ += bytes;
}

std::vector<uint8_t> GltfData::image_bytes(uint32_t index) {
    const tinygltf::Image& image = document_.model.images[index];
    if (image.bufferView >= 0) {
        const std::span<const uint8_t> bytes = view_bytes(image.bufferView);
        return {bytes.begin(), bytes.end()};
    }
    const std::string pointer = gltf_pointer("images", index, "uri");
    return is_data_uri(image.uri) ? decode_data_uri(image.uri, pointer)
                                  : files_.read(folder_ + path_of_uri(image.uri, pointer), pointer);
}

}  // namespace photond
