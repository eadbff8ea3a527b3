// The one file that compiles tinygltf.

#include <fstream>  // tinygltf can write files too
#include <nlohmann/json.hpp>

#define TINYGLTF_IMPLEMENTATION
#include "renderer/scene/gltf_document.h"

namespace photond {

tinygltf::Model parse_plain_gltf(const std::string& text) {
    tinygltf::TinyGLTF parser;  // without callbacks: it can open nothing
    tinygltf::Model model;
    std::string error;
    if (text.size() > UINT32_MAX ||
        !parser.LoadASCIIFromString(&model, &error, nullptr, text.data(), static_cast<unsigned>(text.size()), ""))
        throw Error(ErrorCode::Internal, "tinygltf refuses a document that was judged sound: " + error.substr(0, 300));
    return model;
}

}  // namespace photond
