// The layers of a pass on the device: planes of one float buffer, each as large as the film, channel beside channel.
// For both compilers.
#ifndef PHOTOND_DEVICE_IMAGE_SHARED_H
#define PHOTOND_DEVICE_IMAGE_SHARED_H

// Specialisation constants: how many planes there are, and the one that tells whether a surface was met. Who fills a
// layer has a constant for its first plane (three for colours and vectors): DeviceImage::plane(). NO_PLANE: not kept.
#define PLANE_HIT_ID 39
#define PLANES_ID 40
#define NO_PLANE 0xffffffffu

// Emitted, direct and indirect are always there, in this order.
#define PLANE_EMITTED 0
#define PLANE_DIRECT 3
#define PLANE_INDIRECT 6

#endif
