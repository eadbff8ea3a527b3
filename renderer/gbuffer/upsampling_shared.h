// Light at fewer pixels than there are (upsampling.h), for both compilers.
#ifndef PHOTOND_UPSAMPLING_SHARED_H
#define PHOTOND_UPSAMPLING_SHARED_H

// Specialisation constants.
#define UPSAMPLING_ID 82

#define UPSAMPLING_NEAREST 0u  // Upsampling
#define UPSAMPLING_BILINEAR 1u
#define UPSAMPLING_NORMAL 2u
#define UPSAMPLING_GEOMETRY 3u
#define UPSAMPLING_LEAST 0.05f  // of the weights about a pixel: below it, it is lit itself

#endif
