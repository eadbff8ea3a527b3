#pragma once
#include <tbb/parallel_sort.h>

namespace photond {

/// Sorts a random-access range by `less`; the result depends on the threads where elements are equal and differ.
template <class Iterator, class Less>
void parallel_sort(Iterator begin, Iterator end, const Less& less) {
    tbb::parallel_sort(begin, end, less);
}

}  // namespace photond
