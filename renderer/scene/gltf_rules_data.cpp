// Rules of buffer views, accessors and images: where bytes are, checked in 64-bit arithmetic.

#include <nlohmann/json.hpp>

#include "renderer/scene/gltf_judge.h"
#include "renderer/scene/gltf_layout.h"

namespace photond::gltf_rules {

namespace {

uint64_t whole(const Json& object, const char* key, uint64_t absent = 0) { return object.value(key, absent); }

void check_inside(const Json& place, uint64_t length, const Json& holder, const std::string& name) {
    const uint64_t offset = whole(place, "byteOffset"), available = whole(holder, "byteLength");
    if (offset + length > available)
        fail(place, "bytes [" + std::to_string(offset) + ", " + std::to_string(offset + length) + ") lie outside the " +
                        std::to_string(available) + " bytes of " + name);
}

void check_in_buffer(const Json& root, const Json& range) {
    check_inside(range, whole(range, "byteLength"), root["buffers"][whole(range, "buffer")],
                 "buffer " + range["buffer"].dump());
}

const Json& view_of(const Json& root, const Json& place) { return root["bufferViews"][whole(place, "bufferView")]; }

void check_in_view(const Json& root, const Json& place, uint64_t length) {
    check_inside(place, length, view_of(root, place), "buffer view " + place["bufferView"].dump());
}

void meshopt(const Json& root, const Json& place, uint64_t view_length) {
    check_in_buffer(root, place);
    const uint64_t stride = whole(place, "byteStride"), count = whole(place, "count"),
                   source_length = whole(place, "byteLength");
    const std::string mode = place["mode"], filter = place.value("filter", "NONE");
    const auto fail_stride = [&](const char* detail) { fail(place["byteStride"], detail); };
    if (mode == "ATTRIBUTES") {
        if (stride % 4 != 0) fail_stride("must be a multiple of 4 for ATTRIBUTES");
        if (filter == "OCTAHEDRAL" && stride != 4 && stride != 8)
            fail_stride("must be 4 or 8 for the OCTAHEDRAL filter");
        if (filter == "QUATERNION" && stride != 8) fail_stride("must be 8 for the QUATERNION filter");
    } else {
        if (stride != 2 && stride != 4) fail_stride("must be 2 or 4 for indices");
        if (mode == "TRIANGLES" && count % 3 != 0) fail(place["count"], "must be a multiple of 3 for TRIANGLES");
        if (filter != "NONE") fail(place["filter"], "filters belong to ATTRIBUTES only");
    }
    if (count * stride != view_length)
        fail(place["count"], "count x byteStride is " + std::to_string(count * stride) + ", but the buffer view is " +
                                 std::to_string(view_length) + " bytes long");
    // The codecs spend at least a bit on each four bytes that come out, plus headers: what promises more cannot decode,
    // and is refused before memory is taken for it.
    if (view_length > 64 * source_length + 65536)
        fail(place, std::to_string(source_length) + " compressed bytes cannot hold " + std::to_string(view_length));
}

void sparse(const Json& root, const Json& place, uint64_t accessor_count, uint64_t element_bytes) {
    const uint64_t count = whole(place, "count");
    const Json &indices = place["indices"], &values = place["values"];
    if (count > accessor_count)
        fail(place["count"], std::to_string(count) + " is outside [1, " + std::to_string(accessor_count) + "]");
    check_in_view(root, indices, count * component_bytes(ComponentType(whole(indices, "componentType"))));
    check_in_view(root, values, count * element_bytes);
    if (view_of(root, indices).contains("byteStride") || view_of(root, values).contains("byteStride"))
        fail(place, "sparse data must be tightly packed, without byteStride");
}

}  // namespace

void buffer_view(const Json& root, const Json& view) {
    check_in_buffer(root, view);
    if (whole(view, "byteStride") % 4 != 0)
        fail(view["byteStride"], "must be a multiple of 4, not " + view["byteStride"].dump());
    if (const Json* compressed = find_extension(view, "EXT_meshopt_compression"))
        return meshopt(root, *compressed, whole(view, "byteLength"));
    const Json* buffer = find_extension(root["buffers"][whole(view, "buffer")], "EXT_meshopt_compression");
    if (buffer != nullptr && buffer->value("fallback", false))
        fail(view, "the buffer is a fallback without data, and the view has no EXT_meshopt_compression");
}

void accessor(const Json& root, const Json& accessor) {
    const ElementLayout layout = element_layout(accessor["componentType"], accessor["type"].get<std::string>());
    const uint64_t count = whole(accessor, "count"), size = layout.element_bytes();
    if (accessor.value("normalized", false) && component_bytes(layout.type) == 4)
        fail(accessor["normalized"], "only 8 and 16 bit integers can be normalized");
    for (const char* key : {"min", "max"})
        if (accessor.contains(key) && accessor[key].size() != layout.components())
            fail(accessor[key], "has " + std::to_string(accessor[key].size()) + " elements, not " +
                                    std::to_string(layout.components()));
    if (accessor.contains("bufferView")) {
        const uint64_t stride = whole(view_of(root, accessor), "byteStride", size);
        if (stride < size)
            fail(accessor, "elements of " + std::to_string(size) + " bytes do not fit the buffer view's byteStride " +
                               std::to_string(stride));
        check_in_view(root, accessor, (count - 1) * stride + size);
    }
    if (accessor.contains("sparse")) sparse(root, accessor["sparse"], count, size);
}

void image(const Json&, const Json& image) {
    if (image.contains("uri") && image.contains("bufferView")) fail(image, "has both uri and bufferView");
    if (!image.contains("uri") && !image.contains("bufferView")) fail(image, "has neither uri nor bufferView");
}

}  // namespace photond::gltf_rules
