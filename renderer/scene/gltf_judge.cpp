#include "renderer/scene/gltf_judge.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "renderer/scene/gltf_schema.h"

namespace photond {

namespace {

using namespace schema;
namespace rules = gltf_rules;

// Offsets and lengths are kept below 2^48, so that sums and products with strides and counts cannot overflow 64 bits.
constexpr uint64_t kMaxBytes = uint64_t{1} << 48;
constexpr uint64_t kMaxCount = UINT32_MAX;
constexpr double kHalfPi = 1.5707963267948966;

constexpr std::string_view kSupportedExtensions[] = {
    "KHR_lights_punctual",     "KHR_materials_emissive_strength", "KHR_materials_ior",
    "KHR_materials_specular",  "KHR_materials_transmission",      "KHR_materials_volume",
    "KHR_materials_unlit",     "KHR_texture_transform",           "KHR_mesh_quantization",
    "EXT_meshopt_compression", "KHR_animation_pointer",
};

bool supported(std::string_view extension) {
    return std::ranges::find(kSupportedExtensions, extension) != std::end(kSupportedExtensions);
}

void required_extension(const Json&, const Json& name) {
    const auto& text = name.get_ref<const std::string&>();
    if (!supported(text))
        fail(name, "the file requires the extension " + text.substr(0, 100) + ", which is not supported",
             ErrorCode::Unsupported);
}

void version(const Json&, const Json& asset) {
    const auto version = asset["version"].get<std::string>(), least = asset.value("minVersion", "2.0");
    if (!version.starts_with("2."))
        fail(asset["version"], "glTF version \"" + version.substr(0, 20) + "\" is not 2.x", ErrorCode::Unsupported);
    if (least != "2.0")
        fail(asset["minVersion"], "the file asks for glTF \"" + least.substr(0, 20) + "\", newer than 2.0",
             ErrorCode::Unsupported);
}

constexpr JsonType kToBuffer = index("buffers"), kToView = index("bufferViews"), kToAccessor = index("accessors"),
                   kToNode = index("nodes"), kOffset = whole(0, kMaxBytes), kLength = whole(1, kMaxBytes),
                   kShortOffset = whole(0, INT32_MAX),  // tinygltf keeps sparse data's in 31 bits
    kFactor = number(0, 1), kPositive = number(0, kAny), kNumber = number(-kAny, kAny), kFactors3 = list(kFactor, 3, 3),
                   kPositive3 = list(kPositive, 3, 3), kNumber2 = list(kNumber, 2, 2), kNumber3 = list(kNumber, 3, 3),
                   kNumbers = list(kNumber), kNodes = list(kToNode);

constexpr auto kAsset = members(must("version", kText), may("minVersion", kText));
constexpr JsonType kRequiredExtension{.rule = required_extension};

constexpr auto kFallback = members(may("fallback", kBoolean));
constexpr auto kBuffer =
    members(must("byteLength", kLength), may("uri", kText), extends("EXT_meshopt_compression", object(kFallback)));
constexpr auto kMeshoptCompression =
    members(must("buffer", kToBuffer), may("byteOffset", kOffset), must("byteLength", kLength),
            must("byteStride", whole(1, 256)), must("count", whole(1, kMaxCount)),
            must("mode", one_of("ATTRIBUTES|TRIANGLES|INDICES")),
            may("filter", one_of("NONE|OCTAHEDRAL|QUATERNION|EXPONENTIAL")));
constexpr auto kView =
    members(must("buffer", kToBuffer), may("byteOffset", kOffset), must("byteLength", kLength),
            may("byteStride", whole(4, 252)), extends("EXT_meshopt_compression", object(kMeshoptCompression)));
constexpr auto kSparseIndices = members(must("componentType", one_of("5121|5123|5125")), must("bufferView", kToView),
                                        may("byteOffset", kShortOffset));
constexpr auto kSparseValues = members(must("bufferView", kToView), may("byteOffset", kShortOffset));
constexpr auto kSparse = members(must("count", whole(1, INT32_MAX)), must("indices", object(kSparseIndices)),
                                 must("values", object(kSparseValues)));
constexpr auto kAccessor =
    members(must("componentType", one_of("5120|5121|5122|5123|5125|5126")),
            must("type", one_of("SCALAR|VEC2|VEC3|VEC4|MAT2|MAT3|MAT4")), must("count", whole(1, kMaxCount)),
            may("normalized", kBoolean), may("byteOffset", kOffset), may("min", kNumbers), may("max", kNumbers),
            may("bufferView", kToView), may("sparse", object(kSparse)));

// An image's own header decides what it is, not its mimeType.
constexpr auto kImage =
    members(may("name", kText), may("uri", kText), may("bufferView", kToView), may("mimeType", kText));
constexpr JsonType kWrap = one_of("10497|33648|33071");
constexpr auto kSampler = members(may("wrapS", kWrap), may("wrapT", kWrap), may("magFilter", one_of("9728|9729")),
                                  may("minFilter", one_of("9728|9729|9984|9985|9986|9987")));
constexpr auto kTexture =
    members(may("name", kText), may("source", index("images")), may("sampler", index("samplers")));

constexpr JsonType kToTexture = index("textures"), kUvSet = whole(0, 65535);
constexpr auto kTransform =
    members(may("offset", kNumber2), may("scale", kNumber2), may("rotation", kNumber), may("texCoord", kUvSet));
constexpr auto kTextureInfo =
    members(must("index", kToTexture), may("texCoord", kUvSet), extends("KHR_texture_transform", object(kTransform)));
constexpr auto kNormalInfo = members(must("index", kToTexture), may("texCoord", kUvSet),
                                     extends("KHR_texture_transform", object(kTransform)), may("scale", kNumber));
constexpr JsonType kTextureRef = object(kTextureInfo);
constexpr auto kRoughness = members(may("baseColorFactor", list(kFactor, 4, 4)), may("baseColorTexture", kTextureRef),
                                    may("metallicFactor", kFactor), may("roughnessFactor", kFactor),
                                    may("metallicRoughnessTexture", kTextureRef));
constexpr auto kStrength = members(may("emissiveStrength", kPositive));
constexpr auto kIor = members(may("ior", kPositive));
constexpr auto kSpecular = members(may("specularFactor", kFactor), may("specularColorFactor", kPositive3),
                                   may("specularTexture", kTextureRef), may("specularColorTexture", kTextureRef));
constexpr auto kTransmission = members(may("transmissionFactor", kFactor), may("transmissionTexture", kTextureRef));
constexpr auto kVolume = members(may("thicknessFactor", kPositive), may("attenuationColor", kFactors3),
                                 may("attenuationDistance", above(0, kAny)));
// The emissive factor's range of 1 predates the strength extension and files pass it; radiance has no upper bound here.
constexpr auto kMaterial = members(
    may("name", kText), may("pbrMetallicRoughness", object(kRoughness)), may("normalTexture", object(kNormalInfo)),
    may("occlusionTexture", kTextureRef), extends("KHR_materials_emissive_strength", object(kStrength)),
    may("emissiveFactor", kPositive3), may("emissiveTexture", kTextureRef), extends("KHR_materials_ior", object(kIor)),
    extends("KHR_materials_specular", object(kSpecular)), extends("KHR_materials_transmission", object(kTransmission)),
    extends("KHR_materials_volume", object(kVolume)), may("alphaMode", one_of("OPAQUE|MASK|BLEND")),
    may("alphaCutoff", kPositive), may("doubleSided", kBoolean), extends("KHR_materials_unlit", object({})));

constexpr JsonType kAttributes = map(kToAccessor);
constexpr auto kPrimitive = members(
    must("attributes", kAttributes), may("mode", whole(0, 6)), may("material", index("materials")),
    may("indices", kToAccessor), extends("KHR_draco_mesh_compression", object({})), may("targets", list(kAttributes)));
constexpr auto kMesh =
    members(may("name", kText), must("primitives", each(kPrimitive, rules::primitive, 1)), may("weights", kNumbers));
constexpr auto kSkin =
    members(must("joints", list(kToNode, 1)), may("skeleton", kToNode), may("inverseBindMatrices", kToAccessor));

// tinygltf wants all of a lens.
constexpr auto kPerspective = members(must("yfov", above(1e-6, 3.141592)), absent("znear", kPositive, 1),
                                      may("zfar", kPositive), may("aspectRatio", kPositive));
constexpr auto kOrthographic = members(must("ymag", kNumber), must("xmag", kNumber),
                                       absent("znear", {.kind = Kind::Any}, 0), absent("zfar", {.kind = Kind::Any}, 1));
constexpr auto kCamera =
    members(may("name", kText), must("type", one_of("perspective|orthographic")),
            chosen("perspective", object(kPerspective)), chosen("orthographic", object(kOrthographic)));
constexpr auto kSpot = members(absent("outerConeAngle", number(0, kHalfPi + 1e-6), kHalfPi / 2),
                               may("innerConeAngle", number(0, kHalfPi + 1e-6)));
constexpr auto kLight =
    members(may("name", kText), must("type", one_of("directional|spot|point")), may("color", kPositive3),
            may("intensity", kPositive), may("range", above(0, kAny)), chosen("spot", object(kSpot)));
constexpr auto kNodeLight = members(must("light", index("lights")));
constexpr JsonType kUnit = number(-1.01, 1.01);
constexpr auto kNode =
    members(may("name", kText), may("mesh", index("meshes")), may("skin", index("skins")),
            may("camera", index("cameras")), extends("KHR_lights_punctual", object(kNodeLight)),
            may("matrix", list(kNumber, 16, 16)), may("translation", kNumber3), may("rotation", list(kUnit, 4, 4)),
            may("scale", kNumber3), may("children", kNodes), may("weights", kNumbers));
constexpr auto kScene = members(may("name", kText), may("nodes", kNodes));
constexpr auto kAnimationSampler = members(must("input", kToAccessor), must("output", kToAccessor),
                                           may("interpolation", one_of("LINEAR|STEP|CUBICSPLINE")));
constexpr auto kAnimationPointer = members(must("pointer", kText));
constexpr auto kTarget =
    members(may("node", kToNode), must("path", kText), extends("KHR_animation_pointer", object(kAnimationPointer)));
constexpr auto kChannel = members(must("sampler", whole(0, kMaxCount)), must("target", object(kTarget)));
constexpr JsonType kSamplerOf = object(kAnimationSampler), kChannelOf = object(kChannel);
constexpr auto kAnimation =
    members(may("name", kText), must("samplers", list(kSamplerOf, 1)), must("channels", list(kChannelOf, 1)));

constexpr auto kLights = members(may("lights", each(kLight, rules::light)));

constexpr auto kRoot =
    members(must("asset", object(kAsset, version)),
            may("extensionsRequired", {.kind = Kind::Array, .element = &kRequiredExtension, .gathered = true}),
            may("extensionsUsed", list(kText)), may("buffers", each(kBuffer)),
            may("bufferViews", each(kView, rules::buffer_view)), may("accessors", each(kAccessor, rules::accessor)),
            may("images", each(kImage, rules::image)), may("samplers", each(kSampler)), may("textures", each(kTexture)),
            may("materials", each(kMaterial, rules::material)), may("meshes", each(kMesh, rules::mesh)),
            may("skins", each(kSkin, rules::skin)), may("cameras", each(kCamera, rules::camera)),
            extends("KHR_lights_punctual", object(kLights)), may("nodes", each(kNode, rules::node, 0, rules::nodes)),
            may("scenes", each(kScene, nullptr, 0, rules::scenes)), may("scene", index("scenes")),
            may("animations", each(kAnimation, rules::animation)));
// How many of them at a time. What refers to a faulty element would only repeat the complaint: a layer is judged when
// those before it are sound.
constexpr size_t kLayers[] = {1, 1, 1, 1, 1, 4, 1, 2, 2, 1, 3};

/// Of the extensions listed only the supported ones stay, once each.
void keep_supported(Json& document, const char* list, std::vector<std::string>& warnings) {
    std::set<std::string> kept;
    for (const Json& name : document.value(list, Json::array())) {
        if (supported(name.get<std::string>()))
            kept.insert(name.get<std::string>());
        else
            warnings.push_back("the extension " + name.get<std::string>().substr(0, 100) +
                               " is not supported and was ignored");
    }
    document[list] = kept;
}

}  // namespace

bool gltf_rules::lists_extension(const Json& root, std::string_view name) {
    const auto listed = [&](const char* list) {
        return std::ranges::any_of(root[list], [&](const Json& entry) { return entry == name; });
    };
    return listed("extensionsUsed") || listed("extensionsRequired");
}

void judge_gltf(Json& document, std::vector<std::string>& warnings) {
    if (!document.is_object()) throw Error(ErrorCode::BadScene, "", "a glTF document must be a JSON object");
    std::span<const JsonMember> rest(kRoot);
    for (const size_t count : kLayers) {
        judge_layer(document, rest.first(count));
        if (rest[0].key == "extensionsUsed")
            for (const char* list : {"extensionsUsed", "extensionsRequired"}) keep_supported(document, list, warnings);
        rest = rest.subspan(count);
    }
    keep_members(document, kRoot);
}

}  // namespace photond
