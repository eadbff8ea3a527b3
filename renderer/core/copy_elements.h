#pragma once
// Elements from their bytes, and none from nowhere: memcpy may not be given a null pointer, even to copy nothing.

#include <cstring>
#include <span>
#include <type_traits>

namespace photond {

/// Fills all of `to` from the to.size_bytes() bytes at `from`, which need not be aligned, and is not looked at where
/// `to` is empty.
template <class T>
void copy_elements(const void* from, std::span<T> to) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (!to.empty()) std::memcpy(to.data(), from, to.size_bytes());
}

}  // namespace photond
