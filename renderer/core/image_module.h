#pragma once
// Functions that need the image library, in a module of their own beside the program, loaded when the first of them is
// called: OpenImageIO brings 267 libraries, which cost 0.15 s of processor time and 125 MB a process, and most workers
// never see an image.

namespace photond {

/// The address of a function of the module by its C name; the module is loaded with the first. Throws
/// ErrorCode::Internal where the module or the function is not there.
void* find_image_function(const char* name);

template <class Function>
Function* image_function(const char* name) {
    return reinterpret_cast<Function*>(find_image_function(name));
}

}  // namespace photond
