#include "tests/support/gltf_equations.h"

#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>

namespace photond::test {

namespace {

using nlohmann::json;
using Numbers = std::vector<double>;

/// Rows of numbers.
struct Table {
    size_t width = 1;
    Numbers numbers;

    size_t rows() const { return numbers.size() / width; }
    const double* row(size_t i) const { return &numbers[i * width]; }
};

class Evaluation {
public:
    Evaluation(const json& document, const std::vector<uint8_t>& binary) : document_(document), binary_(binary) {}

    EvaluatedScene run(std::optional<size_t> animation, double time) {
        nodes_ = document_["nodes"];
        if (animation) animate(document_["animations"][*animation], time);
        world_.assign(nodes_.size(), glm::dmat4(0));
        EvaluatedScene scene;
        for (const json& root : document_["scenes"][0]["nodes"]) place(root, glm::dmat4(1));
        for (const json& root : document_["scenes"][0]["nodes"]) show(root, scene);
        return scene;
    }

private:
    const Table& table(const json& index) const {
        const auto [found, is_new] = tables_.try_emplace(index.get<size_t>());
        if (is_new) found->second = read_table(index);
        return found->second;
    }
    Table read_table(const json& index) const {
        const json& accessor = document_["accessors"][index.get<size_t>()];
        static const std::map<std::string, size_t> kWidths = {
            {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT4", 16}};
        static const std::map<int, size_t> kBytes = {{5120, 1}, {5121, 1}, {5122, 2}, {5123, 2}, {5125, 4}, {5126, 4}};
        const int type = accessor["componentType"];
        Table result{kWidths.at(accessor["type"]), {}};
        const size_t count = accessor["count"], bytes = kBytes.at(type);
        if (!accessor.contains("bufferView")) {
            result.numbers.assign(count * result.width, 0);
            return result;
        }
        const json& view = document_["bufferViews"][accessor["bufferView"].get<size_t>()];
        const size_t stride = view.value("byteStride", bytes * result.width);
        const size_t start = view.value("byteOffset", size_t{0}) + accessor.value("byteOffset", size_t{0});
        for (size_t i = 0; i < count; ++i)
            for (size_t k = 0; k < result.width; ++k)
                result.numbers.push_back(
                    number(&binary_[start + i * stride + k * bytes], type, accessor.value("normalized", false)));
        return result;
    }

    static double number(const uint8_t* at, int type, bool normalized) {
        const auto read = [at]<class T>(T value) {
            std::memcpy(&value, at, sizeof value);
            return static_cast<double>(value);
        };
        switch (type) {
            case 5120: return normalized ? std::max(read(int8_t{}) / 127, -1.0) : read(int8_t{});
            case 5121: return read(uint8_t{}) / (normalized ? 255 : 1);
            case 5122: return normalized ? std::max(read(int16_t{}) / 32767, -1.0) : read(int16_t{});
            case 5123: return read(uint16_t{}) / (normalized ? 65535 : 1);
            case 5125: return read(uint32_t{});
            default: return read(float{});
        }
    }

    static void make_unit(Numbers& q) {
        double square = 0;
        for (const double x : q) square += x * x;
        for (double& x : q) x /= std::sqrt(square);
    }

    /// Appendix C.
    static Numbers sample(const Table& times, const Table& values, const std::string& interpolation, bool rotation,
                          double time) {
        const size_t keys = times.rows(), spline = interpolation == "CUBICSPLINE" ? 3 : 1;
        const size_t width = values.numbers.size() / keys / spline;
        const auto part = [&](size_t key, size_t which) {  // in-tangent, value, out-tangent
            const auto first = values.numbers.begin() + static_cast<ptrdiff_t>((key * spline + which) * width);
            return Numbers(first, first + static_cast<ptrdiff_t>(width));
        };
        const auto value = [&](size_t key) {
            Numbers found = part(key, spline == 3 ? 1 : 0);
            if (rotation) make_unit(found);
            return found;
        };
        if (time <= times.numbers.front()) return value(0);
        if (time >= times.numbers.back()) return value(keys - 1);
        size_t key = 0;
        while (times.numbers[key + 1] <= time) ++key;
        if (interpolation == "STEP") return value(key);
        const double length = times.numbers[key + 1] - times.numbers[key], t = (time - times.numbers[key]) / length;
        Numbers result(width);
        if (spline == 3) {
            const Numbers v0 = part(key, 1), b0 = part(key, 2), v1 = part(key + 1, 1), a1 = part(key + 1, 0);
            for (size_t k = 0; k < width; ++k)
                result[k] = (2 * t * t * t - 3 * t * t + 1) * v0[k] + length * (t * t * t - 2 * t * t + t) * b0[k] +
                            (-2 * t * t * t + 3 * t * t) * v1[k] + length * (t * t * t - t * t) * a1[k];
            if (rotation) make_unit(result);
            return result;
        }
        const Numbers a = value(key), b = value(key + 1);
        double from = 1 - t, to = t;
        if (rotation) {
            const double dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
            const double angle = std::acos(std::min(1.0, std::fabs(dot)));
            if (angle > 1e-6) {
                from = std::sin(angle * (1 - t)) / std::sin(angle);
                to = std::sin(angle * t) / std::sin(angle);
            }
            if (dot < 0) to = -to;
        }
        for (size_t k = 0; k < width; ++k) result[k] = from * a[k] + to * b[k];
        if (rotation) make_unit(result);
        return result;
    }

    void animate(const json& animation, double time) {
        for (const json& channel : animation["channels"]) {
            const json& target = channel["target"];
            std::string path = target["path"];
            size_t node = 0;
            if (path == "pointer") {  // "/nodes/N/PATH", the only ones that this knows
                const std::string pointer = target["extensions"]["KHR_animation_pointer"]["pointer"];
                if (!pointer.starts_with("/nodes/")) continue;
                node = std::stoul(pointer.substr(7));
                path = pointer.substr(pointer.rfind('/') + 1);
            } else if (target.contains("node")) {
                node = target["node"];
            } else {
                continue;
            }
            const json& sampler = animation["samplers"][channel["sampler"].get<size_t>()];
            nodes_[node][path] = sample(table(sampler["input"]), table(sampler["output"]),
                                        sampler.value("interpolation", "LINEAR"), path == "rotation", time);
        }
    }

    static glm::dmat4 local(const json& node) {
        glm::dmat4 m(1);
        if (node.contains("matrix")) {
            for (int k = 0; k < 16; ++k) m[k / 4][k % 4] = node["matrix"][static_cast<size_t>(k)];
            return m;
        }
        Numbers q = node.value("rotation", Numbers{0, 0, 0, 1});
        make_unit(q);
        const double x = q[0], y = q[1], z = q[2], w = q[3];
        const Numbers s = node.value("scale", Numbers{1, 1, 1}), t = node.value("translation", Numbers{0, 0, 0});
        m[0] = glm::dvec4(1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y), 0) * s[0];
        m[1] = glm::dvec4(2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x), 0) * s[1];
        m[2] = glm::dvec4(2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y), 0) * s[2];
        m[3] = glm::dvec4(t[0], t[1], t[2], 1);
        return m;
    }

    void place(const json& index, const glm::dmat4& parent) {
        const json& node = nodes_[index.get<size_t>()];
        world_[index.get<size_t>()] = parent * local(node);
        if (node.contains("children"))
            for (const json& child : node["children"]) place(child, world_[index.get<size_t>()]);
    }

    void show(const json& index, EvaluatedScene& scene) {
        const json& node = nodes_[index.get<size_t>()];
        const glm::dmat4& world = world_[index.get<size_t>()];
        if (node.contains("camera")) scene.cameras.push_back(world);
        if (node.contains("extensions") && node["extensions"].contains("KHR_lights_punctual"))
            scene.lights.push_back(world);
        if (node.contains("mesh")) {
            const json& mesh = document_["meshes"][node["mesh"].get<size_t>()];
            const Numbers weights = node.value("weights", mesh.value("weights", Numbers{}));
            for (const json& primitive : mesh["primitives"])
                scene.primitives.push_back(evaluate(primitive, weights, node, world));
        }
        if (node.contains("children"))
            for (const json& child : node["children"]) show(child, scene);
    }

    EvaluatedPrimitive evaluate(const json& primitive, const Numbers& weights, const json& node,
                                const glm::dmat4& world) const {
        const json& attributes = primitive["attributes"];
        const bool skinned = node.contains("skin");
        const Table& stored = table(attributes["POSITION"]);
        EvaluatedPrimitive result;
        for (size_t v = 0; v < stored.rows(); ++v) {
            const glm::dmat4 m =
                skinned ? blended(document_["skins"][node["skin"].get<size_t>()], attributes, v) : world;
            result.positions.emplace_back(m * glm::dvec4(displaced(primitive, "POSITION", weights, v), 1));
            if (attributes.contains("NORMAL"))
                result.normals.push_back(glm::normalize(glm::transpose(glm::inverse(glm::dmat3(m))) *
                                                        displaced(primitive, "NORMAL", weights, v)));
        }
        if (primitive.contains("indices")) {
            for (const double i : table(primitive["indices"]).numbers)
                result.indices.push_back(static_cast<uint32_t>(i));
        } else {
            for (uint32_t i = 0; i < stored.rows(); ++i) result.indices.push_back(i);
        }
        return result;
    }

    glm::dvec3 displaced(const json& primitive, const char* semantic, const Numbers& weights, size_t v) const {
        const Table& stored = table(primitive["attributes"][semantic]);
        glm::dvec3 sum(stored.row(v)[0], stored.row(v)[1], stored.row(v)[2]);
        for (size_t k = 0; primitive.contains("targets") && k < weights.size(); ++k) {
            if (!primitive["targets"][k].contains(semantic)) continue;
            const Table& offsets = table(primitive["targets"][k][semantic]);
            sum += weights[k] * glm::dvec3(offsets.row(v)[0], offsets.row(v)[1], offsets.row(v)[2]);
        }
        return sum;
    }

    /// sum w_i J_i B_i / sum w_i.
    glm::dmat4 blended(const json& skin, const json& attributes, size_t v) const {
        std::optional<Table> inverse_bind;
        if (skin.contains("inverseBindMatrices")) inverse_bind = table(skin["inverseBindMatrices"]);
        glm::dmat4 sum(0);
        double weight_sum = 0;
        for (int set = 0; attributes.contains("JOINTS_" + std::to_string(set)); ++set) {
            const Table& joints = table(attributes["JOINTS_" + std::to_string(set)]);
            const Table& weights = table(attributes["WEIGHTS_" + std::to_string(set)]);
            for (size_t k = 0; k < 4; ++k) {
                const double weight = weights.row(v)[k];
                const auto joint = static_cast<size_t>(joints.row(v)[k]);
                if (weight == 0) continue;
                glm::dmat4 bind(1);
                for (int i = 0; inverse_bind && i < 16; ++i) bind[i / 4][i % 4] = inverse_bind->row(joint)[i];
                sum += weight * (world_[skin["joints"][joint].get<size_t>()] * bind);
                weight_sum += weight;
            }
        }
        if (weight_sum == 0) {  // all of the first joint
            const auto joint = static_cast<size_t>(table(attributes["JOINTS_0"]).row(v)[0]);
            glm::dmat4 bind(1);
            for (int i = 0; inverse_bind && i < 16; ++i) bind[i / 4][i % 4] = inverse_bind->row(joint)[i];
            return world_[skin["joints"][joint].get<size_t>()] * bind;
        }
        return sum / weight_sum;
    }

    const json& document_;
    const std::vector<uint8_t>& binary_;
    json nodes_;
    std::vector<glm::dmat4> world_;
    mutable std::map<size_t, Table> tables_;  // by accessor
};

}  // namespace

EvaluatedScene evaluate_gltf(const std::string& text, const std::vector<uint8_t>& binary,
                             std::optional<size_t> animation, double time_s) {
    const json document = json::parse(text);
    return Evaluation(document, binary).run(animation, time_s);
}

}  // namespace photond::test
