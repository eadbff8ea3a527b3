#include "tests/support/reference_images.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "renderer/film/exr_file.h"
#include "tests/support/path_render.h"

namespace photond::test {

namespace {

using MillimetrePoint = std::array<long, 3>;

struct Edge {
    vec3 a, b;
    vec3 normal;  // of the first triangle found at it
    size_t triangles = 0;
    bool crease = false;
    bool counts() const { return triangles != 2 || crease; }
};

std::vector<Edge> edges_of(const Scene& scene) {
    const auto key = [](const vec3& p) {
        return MillimetrePoint{std::lround(1e3f * p.x), std::lround(1e3f * p.y), std::lround(1e3f * p.z)};
    };
    std::map<std::array<MillimetrePoint, 2>, Edge> edges;
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
        const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
        for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            const TriangleCorners corners = world_triangle(scene, i, t);
            const vec3 n = glm::normalize(glm::cross(corners.p[1] - corners.p[0], corners.p[2] - corners.p[0]));
            for (int e = 0; e < 3; ++e) {
                const vec3 a = corners.p[e], b = corners.p[(e + 1) % 3];
                const MillimetrePoint ka = key(a), kb = key(b);
                const auto [at, added] = edges.try_emplace({std::min(ka, kb), std::max(ka, kb)}, Edge{a, b, n});
                ++at->second.triangles;
                at->second.crease |= glm::dot(at->second.normal, n) < 0.99f;
            }
        }
    }
    std::vector<Edge> counted;
    for (const auto& [unused, edge] : edges)
        if (edge.counts()) counted.push_back(edge);
    return counted;
}

/// Side of a square image or mask.
size_t side_of(size_t pixels) { return static_cast<size_t>(std::lround(std::sqrt(static_cast<double>(pixels)))); }

}  // namespace

std::vector<float> reference_image(const char* file) {
    return read_exr(std::filesystem::path(PHOTOND_TEST_DATA) / "reference" / file).layers.at("beauty");
}

std::vector<float> reduced(const std::vector<float>& image, uint32_t side) {
    const size_t from = side_of(image.size() / 3), scale = from / side;
    std::vector<double> sums(size_t{3} * side * side);
    for (size_t i = 0; i < image.size(); ++i) {
        const size_t y = i / 3 / from, x = i / 3 % from;
        sums[3 * (y / scale * side + x / scale) + i % 3] += double{image[i]};
    }
    std::vector<float> means(sums.size());
    for (size_t i = 0; i < means.size(); ++i)
        means[i] = static_cast<float>(sums[i] / static_cast<double>(scale * scale));
    return means;
}

Mask reduced_mask(const Mask& mask, uint32_t side) {
    const size_t from = side_of(mask.size()), scale = from / side;
    Mask all(size_t{side} * side, 1);
    for (size_t i = 0; i < mask.size(); ++i)
        if (!mask[i]) all[i / from / scale * side + i % from / scale] = 0;
    return all;
}

size_t count_of(const Mask& mask) { return static_cast<size_t>(std::count(mask.begin(), mask.end(), 1)); }

double masked_mean(const std::vector<float>& image, size_t channel, const Mask& mask) {
    double sum = 0;
    size_t count = 0;
    for (size_t i = channel; i < image.size(); i += 3)
        if (mask.empty() || mask[i / 3]) sum += double{image[i]}, ++count;
    return sum / static_cast<double>(count);
}

double masked_mse(const std::vector<float>& image, const std::vector<float>& expected, const Mask& mask) {
    double sum = 0;
    size_t count = 0;
    for (size_t i = 0; i < image.size(); ++i) {
        if (!mask.empty() && !mask[i / 3]) continue;
        const double error = double{image[i]} - double{expected[i]};
        sum += error * error, ++count;
    }
    return sum / static_cast<double>(count);
}

double reference_noise_of_mean(const Mask& mask, size_t pixels) {
    const double judged = mask.empty() ? static_cast<double>(pixels) : static_cast<double>(count_of(mask));
    return kReferenceNoise /
           std::sqrt(judged * static_cast<double>(kReferenceSize.pixels()) / static_cast<double>(pixels));
}

std::vector<float> positions_seen(const Scene& scene, Size2 size) {
    RenderSettings settings;
    settings.size = size;
    settings.params.indirect_bounces = 0;
    settings.layers.add(Layer::Position);
    return render(scene, settings).resolve(Layer::Position);
}

std::vector<float> distances_to_edges(const Scene& scene, const std::vector<float>& positions) {
    const std::vector<Edge> edges = edges_of(scene);
    std::vector<float> distances(positions.size() / 3, 0.0f);
    for (size_t i = 0; i < distances.size(); ++i) {
        const vec3 p(positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]);
        if (p == vec3(0)) continue;  // nothing was hit
        distances[i] = kInfinity;
        for (const Edge& edge : edges) {
            const vec3 along = edge.b - edge.a;
            const float s = std::clamp(glm::dot(p - edge.a, along) / glm::dot(along, along), 0.0f, 1.0f);
            distances[i] = std::min(distances[i], glm::length(p - edge.a - s * along));
        }
    }
    return distances;
}

Mask far_from_edges(const Scene& scene, Size2 size, float distance) {
    constexpr float kJump = 0.3f * 256;  // [m] times the picture's width: more between neighbours is a silhouette
    const std::vector<float> positions = positions_seen(scene, size);
    const std::vector<float> distances = distances_to_edges(scene, positions);
    Mask inner(size.pixels(), 0);
    const size_t width = size.width;
    const float jump = kJump / static_cast<float>(width);
    for (size_t y = 1; y + 1 < size.height; ++y) {
        for (size_t x = 1; x + 1 < width; ++x) {
            bool far = true;
            for (size_t j = y - 1; j <= y + 1; ++j)
                for (size_t i = x - 1; i <= x + 1; ++i) {
                    const float* p = &positions[3 * (j * width + i)];
                    const float* q = &positions[3 * (y * width + x)];
                    far = far && distances[j * width + i] > distance &&
                          std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]) < jump;
                }
            inner[y * width + x] = far;
        }
    }
    return inner;
}

}  // namespace photond::test
