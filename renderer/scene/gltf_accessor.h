#pragma once
// The bytes of a document's buffers, and its accessors as arrays that can be read.

#include <cstring>
#include <span>
#include <vector>

#include "renderer/scene/bundle_files.h"
#include "renderer/scene/gltf_document.h"

namespace photond {

/// An accessor's elements in place: any component type, stride and normalisation, read one at a time.
class AccessorView {
public:
    uint64_t count() const { return count_; }
    uint32_t rows() const { return rows_; }
    /// Whether it has neither a buffer view nor sparse values: then all of it is zeros, and its count costs the file
    /// nothing.
    bool is_zeros() const { return stride_ == 0; }

    /// Component `row` of element `i` (of column 0), as glTF converts it to float.
    float value(uint64_t i, uint32_t row) const {
        return component(data_ + i * stride_ + row * component_bytes(type_));
    }
    template <int N>
    glm::vec<N, float> vec(uint64_t i) const {
        glm::vec<N, float> result(0.0f);
        if (type_ == ComponentType::F32) {
            std::memcpy(&result, data_ + i * stride_, sizeof result);
            return result;
        }
        for (int row = 0; row < N; ++row) result[row] = value(i, static_cast<uint32_t>(row));
        return result;
    }
    dmat4 matrix(uint64_t i) const;
    /// An unsigned scalar or component, unconverted.
    uint32_t whole(uint64_t i, uint32_t row = 0) const;

private:
    friend class GltfData;
    float component(const uint8_t* at) const;

    const uint8_t* data_ = nullptr;
    uint64_t stride_ = 0;  // 0 where every element is the same zeros
    uint64_t count_ = 0;
    ComponentType type_ = ComponentType::F32;
    uint32_t rows_ = 1;
    uint32_t column_bytes_ = 4;
    bool normalized_ = false;
};

/// Loads what is asked for and keeps it: buffers, decompressed views, accessors with their sparse values put in. Not
/// thread-safe. Every function throws ErrorCode::BadScene with the place when the contents break a promise of the
/// document.
class GltfData {
public:
    /// `binary_chunk`: of the .glb, empty otherwise. `folder`: of the .gltf inside the bundle, "" or ending in "/". All
    /// are borrowed.
    GltfData(const GltfDocument& document, std::span<const uint8_t> binary_chunk, BundleFiles& files,
             std::string folder, uint64_t max_made_bytes);

    std::span<const uint8_t> view_bytes(uint32_t view);
    AccessorView accessor(uint32_t accessor);
    /// Adds to what is made of the file's bytes more than once, or of none: keys, morph targets, matrices of joints,
    /// accessors with sparse values. To be called before that is allocated. Throws ErrorCode::BadScene, at `pointer`,
    /// where the sum is more than `max_made_bytes` and the bytes of the files together.
    void charge(uint64_t bytes, const std::string& pointer);
    /// The encoded bytes of an image, from its view, its data URI or its file.
    std::vector<uint8_t> image_bytes(uint32_t image);

private:
    std::span<const uint8_t> buffer_bytes(uint32_t buffer);
    std::vector<uint8_t> decompress(uint32_t view);
    std::vector<uint8_t> apply_sparse(uint32_t accessor);

    struct Held {
        bool loaded = false;
        std::vector<uint8_t> owned;
        std::span<const uint8_t> bytes;
    };

    const GltfDocument& document_;
    std::span<const uint8_t> binary_chunk_;
    BundleFiles& files_;
    std::string folder_;
    std::vector<Held> buffers_;
    std::vector<Held> views_;      // decompressed ones only
    std::vector<Held> accessors_;  // sparse ones only
    const uint64_t max_made_bytes_;
    uint64_t made_bytes_ = 0;  // see charge()
};

}  // namespace photond
