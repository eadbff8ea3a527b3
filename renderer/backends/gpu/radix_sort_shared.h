// One pass of RadixSort: for both compilers.
#ifndef PHOTOND_RADIX_SORT_SHARED_H
#define PHOTOND_RADIX_SORT_SHARED_H

#define RADIX_MOST_DIGITS 256  // 8 bits

struct RadixSortConstants {
    uint shift;   // the pass's digit of a key: (key >> shift) % digits
    uint digits;  // a power of two
};

#endif
