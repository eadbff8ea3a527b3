#include "tests/support/animated_gltf.h"

namespace photond::test {

namespace {

std::string text(int number) { return std::to_string(number); }

/// A square in z = 0 that faces +z, with normals, at accessors that it remembers.
struct Square {
    explicit Square(TestGltf& file)
        : positions(file.positions({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0})),
          normals(file.positions({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1})),
          indices(file.indices({0, 1, 2, 0, 2, 3})) {}

    std::string attributes() const { return R"("POSITION":)" + text(positions) + R"(,"NORMAL":)" + text(normals); }
    std::string primitive(const std::string& more_attributes = "", const std::string& more = "") const {
        return R"({"attributes":{)" + attributes() + more_attributes + R"(},"indices":)" + text(indices) + more + "}";
    }
    std::string mesh(const std::string& more_attributes = "", const std::string& more = "") const {
        return R"({"primitives":[)" + primitive(more_attributes, more) + "]}";
    }

    int positions, normals, indices;
};

std::string node_target(int node, const char* path) {
    return R"({"node":)" + text(node) + R"(,"path":")" + path + "\"}";
}
std::string pointer_target(const char* pointer) {
    return R"({"path":"pointer","extensions":{"KHR_animation_pointer":{"pointer":")" + std::string(pointer) + "\"}}}";
}

/// One animation, put together sampler by sampler.
class AnimationText {
public:
    explicit AnimationText(TestGltf& file) : file_(file) {}

    /// `width`: numbers a value, which names the accessor's type.
    AnimationText& drive(const std::string& target, const std::vector<float>& times, int width,
                         const std::vector<float>& values, const char* interpolation = "LINEAR") {
        static const char* const kTypes[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
        return drive_by(target, file_.floats("SCALAR", 1, times), file_.floats(kTypes[width], width, values),
                        interpolation);
    }
    AnimationText& drive_by(const std::string& target, int input, int output, const char* interpolation = "LINEAR") {
        if (!samplers_.empty()) samplers_ += ",", channels_ += ",";
        samplers_ += R"({"input":)" + text(input) + R"(,"output":)" + text(output) + R"(,"interpolation":")" +
                     interpolation + "\"}";
        channels_ += R"({"sampler":)" + text(count_++) + R"(,"target":)" + target + "}";
        return *this;
    }
    std::string json(const std::string& name = "motion") const {
        return R"({"name":")" + name + R"(","samplers":[)" + samplers_ + R"(],"channels":[)" + channels_ + "]}";
    }
    void set() { file_.set("animations", "[" + json() + "]"); }

private:
    TestGltf& file_;
    std::string samplers_, channels_;
    int count_ = 0;
};

/// About x and y, and by less than a half turn: blended with what does not turn, nothing collapses.
const std::vector<float> kBends = {0, 0, 0, 1, 0.38268343f, 0, 0, 0.92387953f, 0.5f, 0.3f, 0, 0.81240384f};
const std::vector<float> kQuarterTurns = {0, 0, 0, 1, 0, 0, 0.70710678f, 0.70710678f, 0, 0, 1, 0};

TestGltf moved_square() {
    TestGltf file;
    const Square square(file);
    file.set("meshes", "[" + square.mesh() + "]");
    return file;
}

TestGltf linear_and_clamped() {
    TestGltf file = moved_square();
    AnimationText(file)
        .drive(node_target(0, "translation"), {0.25f, 1, 2}, 3, {0, 0, 0, 1, 2, 3, -4, 0.5f, 1})
        .drive(node_target(0, "scale"), {0, 1.5f}, 3, {1, 1, 1, 2, 0.5f, 3})
        .set();
    return file;
}

TestGltf steps() {
    TestGltf file = moved_square();
    AnimationText(file)
        .drive(node_target(0, "translation"), {0, 1, 2}, 3, {0, 0, 0, 1, 2, 3, 4, 5, 6}, "STEP")
        .drive(node_target(0, "rotation"), {0, 0.3f, 1}, 4, kQuarterTurns, "STEP")
        .set();
    return file;
}

/// The second key is the negative of a quaternion near the first: the short way is by its negative.
TestGltf the_short_way_round() {
    TestGltf file = moved_square();
    AnimationText(file).drive(node_target(0, "rotation"), {0, 2}, 4, {0, 0, 0, 1, 0.3f, -0.1f, -0.5f, -0.8f}).set();
    return file;
}

/// Tangents count by the length of their interval, and the result is made unit.
TestGltf spline_rotation() {
    TestGltf file = moved_square();
    AnimationText(file)
        .drive(node_target(0, "rotation"), {0, 0.5f, 3}, 4,
               {0,           0,    0,     0,    0,           0,
                0,           1,    0.4f,  -1,   2,           0.5f,  // tangent in, value, tangent out
                1,           0,    0.3f,  0.2f, 0,           0.6f,
                0,           0.8f, -0.7f, 0.2f, 0,           1,  //
                0.1f,        0.9f, -0.4f, 0.3f, 0.70710678f, 0,
                0.70710678f, 0,    0,     0,    0,           0},
               "CUBICSPLINE")
        .drive(node_target(0, "translation"), {0, 2}, 3, {0, 0, 0, 0, 0, 0, 1, 2, 3, -1, 0, 4, 5, 6, 7, 0, 0, 0},
               "CUBICSPLINE")
        .set();
    return file;
}

const std::vector<float> kBulge = {0, 0, 1, 0.5f, 0, 0, 0, 0, -1, 0, 2, 0};
const std::vector<float> kBent = {0.5f, 0, 0, 0, -0.5f, 0, 0.3f, 0.3f, -0.2f, 0, 0, 1};
const std::vector<float> kLean = {1, 0, 0, 0, 1, 0, 0.5f, 0.5f, 0, -1, 0, 0};

/// Two targets, of which the second moves no normals.
std::string morphing_mesh(TestGltf& file, const std::string& weights = "") {
    const Square square(file);
    const int bulge = file.positions(kBulge), lean = file.positions(kLean), bent = file.positions(kBent);
    return R"({"primitives":[)" +
           square.primitive("", R"(,"targets":[{"POSITION":)" + text(bulge) + R"(,"NORMAL":)" + text(bent) +
                                    R"(},{"POSITION":)" + text(lean) + "}]") +
           "]" + weights + "}";
}

TestGltf morph_weights() {
    TestGltf file;
    file.set("meshes", "[" + morphing_mesh(file) + "]");
    AnimationText(file).drive(node_target(0, "weights"), {0, 1, 2}, 1, {0, 0, 0.5f, 0.25f, -0.3f, 1}).set();
    return file;
}

/// Of a key come all tangents in, then all values, then all tangents out.
TestGltf spline_weights() {
    TestGltf file;
    file.set("meshes", "[" + morphing_mesh(file) + "]");
    AnimationText(file)
        .drive(node_target(0, "weights"), {0, 2}, 1, {9, 9, 0, 0.5f, 0.2f, -0.4f, 0.6f, 0.3f, 0.4f, 0, 9, 9},
               "CUBICSPLINE")
        .set();
    return file;
}

/// The first node has its own weights, the second takes the mesh's, the third is animated.
TestGltf whose_weights() {
    TestGltf file;
    file.set("meshes", "[" + morphing_mesh(file, R"(,"weights":[0.25,0.5])") + "]");
    file.set("scenes", R"([{"nodes":[0,1,2]}])");
    file.set("nodes", R"([{"mesh":0,"weights":[0.5,0]},{"mesh":0,"translation":[3,0,0]},{"mesh":0}])");
    AnimationText(file).drive(node_target(2, "weights"), {0, 1}, 1, {0, 0, 1, 0.5f}).set();
    return file;
}

TestGltf child_of_a_turning_parent() {
    TestGltf file;
    const Square square(file);
    file.set("meshes", "[" + square.mesh() + "]");
    file.set("scenes", R"([{"nodes":[0,3]}])");
    file.set("nodes", R"([{"mesh":0,"children":[1],"rotation":[0,0,0.6,0.8]},
                          {"translation":[2,0,0],"scale":[1,2,1],"children":[2]},
                          {"mesh":0,"translation":[0,1,0.5]},{"mesh":0,"translation":[-9,0,0]}])");
    const std::string first = AnimationText(file)
                                  .drive(node_target(0, "rotation"), {0, 1, 2}, 4, kQuarterTurns)
                                  .drive(node_target(1, "translation"), {0, 1}, 3, {2, 0, 0, 2, -1, 1})
                                  .json("turn");
    const std::string second =
        AnimationText(file).drive(node_target(2, "scale"), {0, 1}, 3, {1, 1, 1, 3, 3, 1}).json("grow");
    file.set("animations", "[" + first + "," + second + "]");
    return file;
}

TestGltf scaled_through_nothing() {
    TestGltf file = moved_square();
    AnimationText(file).drive(node_target(0, "scale"), {0, 1, 2}, 3, {1, 1, 1, 0, 0, 0, 2, 2, 2}).set();
    return file;
}

TestGltf mirrored_by_scale() {
    TestGltf file = moved_square();
    AnimationText(file).drive(node_target(0, "scale"), {0, 1}, 3, {1, 1, 1, -1, 1, 1}, "STEP").set();
    return file;
}

TestGltf whole_number_rotations() {
    TestGltf file = moved_square();
    const int times = file.floats("SCALAR", 1, {0, 1, 2});
    const std::vector<int16_t> turns = {0, 0, 0, 32767, 0, 0, 23170, 23170, 0, -32767, 0, -32768};
    const int rotations = file.accessor(file.view(bytes_of(turns)), TestGltf::kI16, "VEC4", 3, R"(,"normalized":true)");
    AnimationText(file).drive_by(node_target(0, "rotation"), times, rotations).set();
    return file;
}

TestGltf pointers_to_nodes() {
    TestGltf file = moved_square();
    file.set("extensionsUsed", R"(["KHR_animation_pointer"])");
    AnimationText(file)
        .drive(pointer_target("/nodes/0/translation"), {0, 1}, 3, {0, 0, 0, 1, 2, 3})
        .drive(pointer_target("/nodes/0/rotation"), {0, 1, 2}, 4, kQuarterTurns)
        .drive(R"({"path":"translation"})", {0, 1}, 3, {9, 9, 9, 9, 9, 9})  // no node: passed over
        .set();
    return file;
}

TestGltf hung_on_nodes() {
    TestGltf file = moved_square();
    file.set("extensionsUsed", R"(["KHR_lights_punctual"])");
    file.set("extensions", R"({"KHR_lights_punctual":{"lights":[{"type":"spot","spot":{}}]}})");
    file.set("cameras", R"([{"type":"perspective","perspective":{"yfov":0.7,"znear":0.1}}])");
    file.set("nodes", R"([{"mesh":0,"children":[1]},{"translation":[0,0,4],"camera":0,"children":[2]},
                          {"translation":[1,0,0],"extensions":{"KHR_lights_punctual":{"light":0}}}])");
    AnimationText(file).drive(node_target(0, "rotation"), {0, 1, 2}, 4, kQuarterTurns).set();
    return file;
}

// --- skins -----------------------------------------------------------------------------------------------------------
struct SkinParts {
    std::vector<float> weights = {1, 0, 0, 0, 0.5f, 0.5f, 0, 0, 0, 1, 0, 0, 0.25f, 0.75f, 0, 0};
    std::string more_attributes;
    std::string more_of_skin;
    std::string root = R"("translation":[0.5,0,0])";  // of the first joint
};

/// A square with two joints: nodes 1 and 2, one the child of the other; node 0 shows it and is moved, which lends the
/// square nothing.
TestGltf skinned_square(const SkinParts& parts = {}, const std::string& more_of_primitive = "") {
    TestGltf file;
    const Square square(file);
    const int joints =
        file.accessor(file.view(bytes_of(std::vector<uint8_t>{0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0})),
                      TestGltf::kU8, "VEC4", 4);
    const int weights = file.floats("VEC4", 4, parts.weights);
    const int binds = file.floats("MAT4", 16, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -0.5f, 0,  0, 1,  //
                                               1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -0.5f, -1, 0, 1});
    const std::string attributes =
        R"(,"JOINTS_0":)" + text(joints) + R"(,"WEIGHTS_0":)" + text(weights) + parts.more_attributes;
    file.set("meshes", "[" + square.mesh(attributes, more_of_primitive) + "]");
    file.set("skins", R"([{"joints":[1,2],"inverseBindMatrices":)" + text(binds) + parts.more_of_skin + "}]");
    file.set("scenes", R"([{"nodes":[0,1]}])");
    file.set("nodes", R"([{"mesh":0,"skin":0,"translation":[100,0,0],"scale":[5,5,5]},{)" + parts.root +
                          R"(,"children":[2]},{"translation":[0,1,0]}])");
    return file;
}

void bend(TestGltf& file) {
    AnimationText(file)
        .drive(node_target(2, "rotation"), {0, 1, 2}, 4, kBends)
        .drive(node_target(1, "translation"), {0, 2}, 3, {0.5f, 0, 0, 0.5f, 0.5f, 1})
        .drive(node_target(0, "translation"), {0, 1}, 3, {0, 0, 0, 50, 50, 50})
        .set();
}

TestGltf skin() {
    TestGltf file = skinned_square({.more_of_skin = R"(,"skeleton":0)"});
    bend(file);
    return file;
}

TestGltf weights_that_do_not_add_up() {
    TestGltf file = skinned_square({.weights = {2, 0, 0, 0, 0.3f, 0.3f, 0, 0, 0, 0.7f, 0, 0, 1, 3, 0, 0}});
    bend(file);
    return file;
}

TestGltf weights_that_are_all_nothing() {
    TestGltf file = skinned_square({.weights = {0, 0, 0, 0, 0.5f, 0.5f, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0}});
    bend(file);
    return file;
}

TestGltf no_inverse_bind_matrices() {
    TestGltf file = skinned_square();
    file.set("skins", R"([{"joints":[1,2]}])");
    bend(file);
    return file;
}

TestGltf more_than_four_influences() {
    TestGltf file;
    const Square square(file);
    const std::vector<uint16_t> first = {0, 1, 2, 0, 0, 1, 2, 0, 0, 1, 2, 0, 0, 1, 2, 0};
    const std::vector<uint16_t> second = {2, 1, 0, 0, 2, 1, 0, 0, 2, 1, 0, 0, 2, 1, 0, 0};
    const auto joints = [&](const std::vector<uint16_t>& values) {
        return text(file.accessor(file.view(bytes_of(values)), TestGltf::kU16, "VEC4", 4));
    };
    const std::vector<uint8_t> low = {100, 50, 5, 0, 0, 100, 55, 0, 20, 20, 15, 0, 0, 0, 0, 0};
    const std::vector<uint8_t> high = {50, 50, 0, 0, 50, 50, 0, 0, 100, 100, 0, 0, 200, 55, 0, 0};
    const auto weights = [&](const std::vector<uint8_t>& values) {
        return text(file.accessor(file.view(bytes_of(values)), TestGltf::kU8, "VEC4", 4, R"(,"normalized":true)"));
    };
    const std::string attributes = R"(,"JOINTS_0":)" + joints(first) + R"(,"JOINTS_1":)" + joints(second) +
                                   R"(,"WEIGHTS_0":)" + weights(low) + R"(,"WEIGHTS_1":)" + weights(high);
    file.set("meshes", "[" + square.mesh(attributes) + "]");
    file.set("skins", R"([{"joints":[1,2,3]}])");
    file.set("scenes", R"([{"nodes":[0,1]}])");
    file.set("nodes", R"([{"mesh":0,"skin":0},{"children":[2,3]},{"translation":[0,1,0]},{"rotation":[0.6,0,0,0.8]}])");
    AnimationText(file)
        .drive(node_target(2, "rotation"), {0, 1, 2}, 4, kBends)
        .drive(node_target(1, "scale"), {0, 2}, 3, {1, 1, 1, 2, 1, 0.5f})
        .set();
    return file;
}

TestGltf mirrored_joint() {
    TestGltf file = skinned_square({.root = R"("translation":[0.5,0,0],"scale":[-1,1,1])"});
    bend(file);
    return file;
}

/// What is moved by its targets is moved by its joints afterwards.
TestGltf morphed_and_skinned() {
    TestGltf file = skinned_square();
    const int bulge = file.positions(kBulge), bent = file.positions(kBent);
    const std::string meshes = file.member("meshes");
    const std::string target = R"(,"targets":[{"POSITION":)" + text(bulge) + R"(,"NORMAL":)" + text(bent) + R"(}]}]}])";
    file.set("meshes", meshes.substr(0, meshes.size() - 4) + target);
    AnimationText(file)
        .drive(node_target(2, "rotation"), {0, 1, 2}, 4, kBends)
        .drive(node_target(0, "weights"), {0, 1}, 1, {0, 0.4f})
        .set();
    return file;
}

/// A closed room, whose lamp swings, with a skinned square, one that changes its shape and one that turns, and a camera
/// that travels.
TestGltf room_that_moves() {
    TestGltf file = skinned_square();
    const int room =
        file.positions({-3, -1, -3, 3, -1, -3, 3, 3, -3, -3, 3, -3, -3, -1, 6, 3, -1, 6, 3, 3, 6, -3, 3, 6});
    const int inside = file.indices({0, 1, 2, 0, 2, 3, 4, 6, 5, 4, 7, 6, 0, 3, 7, 0, 7, 4,  //
                                     1, 5, 6, 1, 6, 2, 0, 4, 5, 0, 5, 1, 3, 2, 6, 3, 6, 7});
    const int lamp = file.positions({-0.5f, -0.5f, -0.5f, 0.5f, -0.5f, -0.5f, 0.5f, -0.5f, 0.5f, -0.5f, -0.5f, 0.5f});
    const Square square(file);
    const std::string skinned = file.member("meshes");
    file.set("meshes", skinned.substr(0, skinned.size() - 1) + "," + morphing_mesh(file) + "," +
                           square.mesh("", R"(,"material":1)") + R"(,{"primitives":[{"attributes":{"POSITION":)" +
                           text(room) + R"(},"indices":)" + text(inside) +
                           R"(,"material":0}]},{"primitives":[{"attributes":{"POSITION":)" + text(lamp) +
                           R"(},"indices":)" + text(square.indices) + R"(,"material":2}]}])");
    file.set("materials", R"([{"pbrMetallicRoughness":{"metallicFactor":0,"baseColorFactor":[0.6,0.5,0.4,1]}},
                              {"pbrMetallicRoughness":{"roughnessFactor":0.3,"baseColorFactor":[0.9,0.7,0.3,1]}},
                              {"emissiveFactor":[1,1,1],"doubleSided":true}])");
    file.set("cameras", R"([{"type":"perspective","perspective":{"yfov":0.9,"znear":0.1}}])");
    file.set("scenes", R"([{"nodes":[0,1,3,4,5,6,7]}])");
    file.set("nodes", R"([{"mesh":0,"skin":0,"translation":[100,0,0]},{"translation":[-1,0,0],"children":[2]},
                          {"translation":[0,1,0]},{"mesh":1,"translation":[0.5,0,0]},{"mesh":2,"translation":[-0.5,0,2]},
                          {"mesh":3},{"mesh":4,"translation":[0,3,1]},{"camera":0,"translation":[0,1,5.5]}])");
    AnimationText(file)
        .drive(node_target(2, "rotation"), {0, 1, 2}, 4, kBends)
        .drive(node_target(3, "weights"), {0, 1, 2}, 1, {0, 0, 0.4f, 0.5f, 1, 0})
        .drive(node_target(4, "rotation"), {0, 1, 2}, 4, kBends)
        .drive(node_target(6, "rotation"), {0, 2}, 4, {0, 0, 0.2f, 0.9797959f, 0, 0, -0.2f, 0.9797959f})
        .drive(node_target(7, "translation"), {0, 2}, 3, {0, 1, 5.5f, 0.5f, 1.5f, 4})
        .set();
    return file;
}

// --- driven by pointers ----------------------------------------------------------------------------------------------
TestGltf pointers() {
    TestGltf file;
    const Square square(file);
    const int uv = file.floats("VEC2", 2, {0, 0, 1, 0, 1, 1, 0, 1});
    const int image = file.view(make_png({2, 2}, std::vector<u8vec4>(4, u8vec4(255))));
    file.set("extensionsUsed", R"(["KHR_animation_pointer","KHR_lights_punctual","KHR_texture_transform",
                                   "KHR_materials_emissive_strength"])");
    file.set("images", R"([{"bufferView":)" + text(image) + R"(,"mimeType":"image/png"}])");
    file.set("textures", R"([{"source":0}])");
    file.set("materials", R"([{"pbrMetallicRoughness":{"metallicFactor":0,"baseColorTexture":{"index":0}},
                               "extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":2}}}])");
    file.set("meshes", "[" + square.mesh(R"(,"TEXCOORD_0":)" + text(uv), R"(,"material":0)") + "]");
    file.set("extensions", R"({"KHR_lights_punctual":{"lights":[{"type":"spot","spot":{}}]}})");
    file.set("cameras", R"([{"type":"perspective","perspective":{"yfov":0.5,"znear":0.1}}])");
    file.set("scenes", R"([{"nodes":[0,1]}])");
    file.set("nodes", R"([{"mesh":0},{"camera":0,"extensions":{"KHR_lights_punctual":{"light":0}}}])");
    AnimationText(file)
        .drive(pointer_target("/cameras/0/perspective/yfov"), {0, 1}, 1, {0.5f, 1})
        .drive(pointer_target("/extensions/KHR_lights_punctual/lights/0/color"), {0, 1}, 3, {1, 1, 0, 1, 0, 0})
        .drive(pointer_target("/extensions/KHR_lights_punctual/lights/0/intensity"), {0, 1}, 1, {10, 20})
        .drive(pointer_target("/extensions/KHR_lights_punctual/lights/0/spot/outerConeAngle"), {0, 1}, 1, {0.4f, 0.6f})
        .drive(pointer_target("/materials/0/pbrMetallicRoughness/baseColorFactor"), {0, 1}, 4,
               {1, 0.5f, 0, 1, 0, 0, 1, 1})
        .drive(pointer_target("/materials/0/pbrMetallicRoughness/roughnessFactor"), {0, 1}, 1, {0.5f, 0})
        .drive(pointer_target("/materials/0/emissiveFactor"), {0, 1}, 3, {0, 0, 0, 2, 2, 0})
        .drive(pointer_target("/materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength"), {0, 1}, 1,
               {2, 4})
        .drive(pointer_target(
                   "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/offset"),
               {0, 1}, 2, {0, 0, 1, 0})
        .drive(pointer_target("/materials/0/occlusionTexture/strength"), {0, 1}, 1, {0, 1})
        .set();
    return file;
}

/// A mesh that one node shows, with channels for the weights of both: first the node's, then the mesh's.
TestGltf weights_of_mesh_and_node() {
    TestGltf file;
    file.set("extensionsUsed", R"(["KHR_animation_pointer"])");
    file.set("meshes", "[" + morphing_mesh(file) + "]");
    AnimationText(file)
        .drive(node_target(0, "weights"), {0, 1}, 1, {0, 0, 1, 0})
        .drive(pointer_target("/meshes/0/weights"), {0, 1}, 1, {0, 0, 0, 1})
        .set();
    return file;
}

/// Two boxes of one material, one on the other, which `pointer` drives from 0 to 1 and back. `glass`: more of the
/// material.
TestGltf stacked_boxes(const std::string& glass, const char* pointer) {
    TestGltf file;
    const int box = file.positions({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1});
    const int outside = file.indices({0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 7, 3, 0, 4, 7,  //
                                      1, 6, 5, 1, 2, 6, 0, 5, 4, 0, 1, 5, 3, 6, 2, 3, 7, 6});
    file.set("extensionsUsed", R"(["KHR_animation_pointer","KHR_materials_transmission","KHR_materials_volume"])");
    file.set("materials", R"([{"pbrMetallicRoughness":{"metallicFactor":0},"extensions":{)" + glass + "}}]");
    file.set_mesh(R"("POSITION":)" + text(box), R"(,"indices":)" + text(outside) + R"(,"material":0)");
    file.set("scenes", R"([{"nodes":[0,1]}])");
    file.set("nodes", R"([{"mesh":0},{"mesh":0,"translation":[0.25,1,0.25],"scale":[0.5,0.5,0.5]}])");
    const bool color = std::string(pointer).ends_with("baseColorFactor");
    AnimationText(file)
        .drive(pointer_target(pointer), {0, 1, 2}, color ? 4 : 1,
               color ? std::vector<float>{0, 0, 0, 1, 1, 1, 1, 1, 0, 0, 0, 1} : std::vector<float>{0, 1, 0})
        .set();
    return file;
}
constexpr const char* kTransmissionPointer = "/materials/0/extensions/KHR_materials_transmission/transmissionFactor";

/// Of a light and a material, whose factors are finite and their products not, and of a light's range, which the spline
/// leads below 0 between its keys.
TestGltf products_out_of_range() {
    TestGltf file;
    const Square square(file);
    file.set("extensionsUsed", R"(["KHR_animation_pointer","KHR_lights_punctual","KHR_materials_emissive_strength"])");
    file.set("materials", R"([{"emissiveFactor":[1,1,0],
                               "extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":2}}}])");
    file.set("meshes", "[" + square.mesh("", R"(,"material":0)") + "]");
    file.set("extensions", R"({"KHR_lights_punctual":{"lights":[{"type":"point"}]}})");
    file.set("nodes", R"([{"mesh":0,"extensions":{"KHR_lights_punctual":{"light":0}}}])");
    AnimationText(file)
        .drive(pointer_target("/extensions/KHR_lights_punctual/lights/0/color"), {0, 1}, 3, {1, 1, 1, 1e30f, 1, 0})
        .drive(pointer_target("/extensions/KHR_lights_punctual/lights/0/intensity"), {0, 1}, 1, {1, 1e30f})
        .drive(pointer_target("/extensions/KHR_lights_punctual/lights/0/range"), {0, 1}, 1, {0, 1, -90, 90, 1, 0},
               "CUBICSPLINE")
        .drive(pointer_target("/materials/0/emissiveFactor"), {0, 1}, 3, {1, 1, 0, 1e30f, 1, 0})
        .drive(pointer_target("/materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength"), {0, 1}, 1,
               {1, 1e30f})
        .set();
    return file;
}

/// Two cameras and a light on nodes of their own: the first camera is scaled to nothing at 1 and thrown out of float's
/// range at 2, the light thrown out at 3.
TestGltf cameras_that_come_and_go() {
    TestGltf file = moved_square();
    file.set("extensionsUsed", R"(["KHR_lights_punctual"])");
    file.set("extensions", R"({"KHR_lights_punctual":{"lights":[{"type":"point"}]}})");
    file.set("cameras", R"([{"type":"perspective","perspective":{"yfov":0.7,"znear":0.1}}])");
    file.set("scenes", R"([{"nodes":[0,1,3,4]}])");
    file.set("nodes", R"([{"mesh":0},{"scale":[10,10,10],"children":[2]},{"name":"first","camera":0},
                          {"name":"second","camera":0,"translation":[0,0,5]},
                          {"scale":[10,10,10],"children":[5]},{"extensions":{"KHR_lights_punctual":{"light":0}}}])");
    AnimationText(file)
        .drive(node_target(2, "scale"), {0, 1, 2}, 3, {1, 1, 1, 0, 0, 0, 1, 1, 1}, "STEP")
        .drive(node_target(2, "translation"), {0, 2, 3}, 3, {0, 0, 1, 3e38f, 0, 0, 0, 0, 1}, "STEP")
        .drive(node_target(5, "translation"), {0, 3}, 3, {0, 0, 1, 3e38f, 0, 0}, "STEP")
        .set();
    return file;
}

TestGltf overshooting_spline() {
    TestGltf file = moved_square();
    file.set("extensionsUsed", R"(["KHR_animation_pointer"])");
    file.set("materials", R"([{}])");
    const Square square(file);
    file.set("meshes", "[" + square.mesh("", R"(,"material":0)") + "]");
    AnimationText(file)
        .drive(pointer_target("/materials/0/pbrMetallicRoughness/roughnessFactor"), {0, 1}, 1,
               {0, 0.9f, 8, -8, 0.9f, 0}, "CUBICSPLINE")
        .set();
    return file;
}

FaultyAnimation faulty(const char* name, const char* pointer, const char* detail, TestGltf gltf) {
    return {name, std::move(gltf), pointer, detail};
}

TestGltf with_channel(const std::string& target, const std::vector<float>& times, int width,
                      const std::vector<float>& values) {
    TestGltf file = moved_square();
    AnimationText(file).drive(target, times, width, values).set();
    return file;
}

}  // namespace

const std::vector<AnimatedFile>& animated_files() {
    static const std::vector<AnimatedFile> kFiles = {
        {"LinearAndClamped", linear_and_clamped()},
        {"Steps", steps()},
        {"TheShortWayRound", the_short_way_round()},
        {"SplineRotation", spline_rotation()},
        {"WholeNumberRotations", whole_number_rotations()},
        {"MorphWeights", morph_weights()},
        {"SplineWeights", spline_weights()},
        {"WhoseWeights", whose_weights()},
        {"ChildOfATurningParent", child_of_a_turning_parent()},
        {"ScaledThroughNothing", scaled_through_nothing()},
        {"MirroredByScale", mirrored_by_scale()},
        {"PointersToNodes", pointers_to_nodes()},
        {"HungOnNodes", hung_on_nodes()},
        {"Skin", skin()},
        {"WeightsThatDoNotAddUp", weights_that_do_not_add_up()},
        {"WeightsThatAreAllNothing", weights_that_are_all_nothing()},
        {"NoInverseBindMatrices", no_inverse_bind_matrices()},
        {"MoreThanFourInfluences", more_than_four_influences()},
        {"MirroredJoint", mirrored_joint()},
        {"MorphedAndSkinned", morphed_and_skinned()},
        {"RoomThatMoves", room_that_moves()},
    };
    return kFiles;
}

TestGltf animated_file(const std::string& name) {
    if (name == "Pointers") return pointers();
    if (name == "OvershootingSpline") return overshooting_spline();
    if (name == "WeightsOfMeshAndNode") return weights_of_mesh_and_node();
    if (name == "ProductsOutOfRange") return products_out_of_range();
    if (name == "SolidsThatAppear")
        return stacked_boxes(R"("KHR_materials_volume":{"thicknessFactor":1})", kTransmissionPointer);
    if (name == "GlassWithoutAnIndex") return stacked_boxes(R"("KHR_materials_ior":{"ior":0})", kTransmissionPointer);
    if (name == "SheetsThatAppear") return stacked_boxes("", kTransmissionPointer);
    if (name == "SheetsThatChangeColour")
        return stacked_boxes(R"("KHR_materials_transmission":{"transmissionFactor":1})",
                             "/materials/0/pbrMetallicRoughness/baseColorFactor");
    if (name == "CamerasThatComeAndGo") return cameras_that_come_and_go();
    const auto found =
        std::ranges::find_if(animated_files(), [&](const AnimatedFile& file) { return file.name == name; });
    return found->gltf;
}

TestGltf plain_square() { return moved_square(); }

std::vector<FaultyAnimation> faulty_animations() {
    const std::vector<float> moves = {0, 0, 0, 1, 1, 1};
    std::vector<FaultyAnimation> files;
    files.push_back(faulty("TimesThatGoBack", "/animations/0/samplers/0/input", "before that of the key before it",
                           with_channel(node_target(0, "translation"), {1, 0.5f}, 3, moves)));
    files.push_back(faulty("TimesThatAreNoNumbers", "/animations/0/samplers/0/input", "not finite",
                           with_channel(node_target(0, "translation"), {0, NAN}, 3, moves)));
    files.push_back(faulty("TooFewValues", "/animations/0/samplers/0/output", "not the 9 of 3 keys",
                           with_channel(node_target(0, "translation"), {0, 1, 2}, 3, moves)));
    files.push_back(faulty("ValuesThatAreInfinite", "/animations/0/samplers/0/output", "not finite",
                           with_channel(node_target(0, "translation"), {0, 1}, 3, {0, 0, 0, INFINITY, 0, 0})));
    files.push_back(faulty("NoSuchNode", "/animations/0/channels/0/target/node", "not an index into the 1 nodes",
                           with_channel(node_target(7, "translation"), {0, 1}, 3, moves)));
    files.push_back(faulty("NoMorphTargets", "/animations/0/channels/0/target", "no morph targets",
                           with_channel(node_target(0, "weights"), {0, 1}, 1, {0, 1})));
    files.push_back(faulty("NoDirection", "/animations/0/channels/0/sampler", "the quaternion of key 1 is 0",
                           with_channel(node_target(0, "rotation"), {0, 1}, 4, {0, 0, 0, 1, 0, 0, 0, 0})));
    files.push_back(faulty("TimesThatAreVectors", "/animations/0/samplers/0/input", "does not hold times", [&] {
        TestGltf file = moved_square();
        const int vectors = file.positions(moves);
        AnimationText(file).drive_by(node_target(0, "translation"), vectors, vectors).set();
        return file;
    }()));
    files.push_back(
        faulty("TwoChannelsForOneProperty", "/animations/0/channels/1/target", "drives the same property", [&] {
            TestGltf file = moved_square();
            AnimationText(file)
                .drive(node_target(0, "translation"), {0, 1}, 3, moves)
                .drive(node_target(0, "translation"), {0, 1}, 3, moves)
                .set();
            return file;
        }()));
    files.push_back(faulty("AMatrixThatIsAnimated", "/animations/0/channels/0/target", "has a matrix", [&] {
        TestGltf file = with_channel(node_target(0, "translation"), {0, 1}, 3, moves);
        file.set("nodes", R"([{"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}])");
        return file;
    }()));
    return files;
}

}  // namespace photond::test
