#pragma once
// How the elements of an accessor lie in memory.

#include <cstdint>
#include <string_view>

namespace photond {

enum class ComponentType : uint16_t { I8 = 5120, U8 = 5121, I16 = 5122, U16 = 5123, U32 = 5125, F32 = 5126 };

constexpr uint32_t component_bytes(ComponentType type) {
    return type == ComponentType::I8 || type == ComponentType::U8     ? 1
           : type == ComponentType::I16 || type == ComponentType::U16 ? 2
                                                                      : 4;
}

struct ElementLayout {
    ComponentType type = ComponentType::F32;
    uint32_t columns = 1;  // matrices; else 1
    uint32_t rows = 1;     // components of a vector, or of a matrix's column

    uint32_t components() const { return columns * rows; }
    /// Bytes of one column; columns of matrices of small types start on 4-byte boundaries.
    uint32_t column_bytes() const {
        const uint32_t bytes = rows * component_bytes(type);
        return columns > 1 ? (bytes + 3) / 4 * 4 : bytes;
    }
    uint32_t element_bytes() const { return columns * column_bytes(); }
};

/// Of a judged accessor's "componentType" and "type": SCALAR, VEC2 to VEC4, MAT2 to MAT4.
constexpr ElementLayout element_layout(uint64_t component_type, std::string_view type) {
    const uint32_t rows = type == "SCALAR" ? 1 : static_cast<uint32_t>(type.back() - '0');
    return {static_cast<ComponentType>(component_type), type.starts_with("MAT") ? rows : 1, rows};
}

}  // namespace photond
