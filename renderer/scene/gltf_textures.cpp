// The images a scene's materials use, decoded in parallel; one texture for each pair of image and sampler.

#include <map>
#include <tuple>

#include "renderer/core/parallel.h"
#include "renderer/scene/gltf_placement.h"
#include "renderer/scene/image_header.h"

namespace photond {

namespace {

/// One image at work. Faults are kept until all images are done, so that the answer does not depend on who finished
/// first.
struct ImageTask {
    uint32_t image = 0;
    uint32_t users = 0;
    std::vector<uint8_t> encoded;
    Texture decoded;
    std::optional<Error> fault;
};

Wrap wrap_of(int code) {
    if (code == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT) return Wrap::MirroredRepeat;
    return code == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE ? Wrap::ClampToEdge : Wrap::Repeat;
}

template <class Step>
void keep_fault(ImageTask& task, const Step& step) {
    try {
        step();
    } catch (const Error& error) {
        task.fault.emplace(error);
    }
}

void throw_faults(const std::vector<ImageTask>& tasks) {
    FaultList faults;
    for (const ImageTask& task : tasks) {
        if (!task.fault) continue;
        const auto& found = task.fault->faults;
        const bool placed = !found.empty() && !found.front().pointer.empty();
        faults.add(task.fault->code, placed ? found.front().pointer : gltf_pointer("images", task.image),
                   task.fault->what());
    }
    faults.throw_if_any();
}

}  // namespace

void load_gltf_textures(const GltfDocument& document, GltfData& data, const ImageDecoder& decode,
                        const LoadLimits& limits, Scene& scene) {
    using Key = std::tuple<uint32_t, Wrap, Wrap, bool>;  // image, wraps, nearest
    std::map<Key, int32_t> texture_of;
    std::map<uint32_t, size_t> task_of;
    std::vector<ImageTask> tasks;
    std::vector<size_t> task_of_texture;
    for (Material& material : scene.materials)
        visit_texture_refs(material, [&](TextureRef& reference) {
            if (!reference.used()) return;
            const tinygltf::Texture& texture = document.model.textures[reference.texture];
            const uint32_t image = texture.source;
            const tinygltf::Sampler sampler =
                texture.sampler < 0 ? tinygltf::Sampler() : document.model.samplers[texture.sampler];
            const Key key{image, wrap_of(sampler.wrapS), wrap_of(sampler.wrapT),
                          sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST};
            const auto [found, is_new] = texture_of.try_emplace(key, static_cast<int32_t>(scene.textures.size()));
            reference.texture = found->second;
            if (!is_new) return;
            const auto [task, new_task] = task_of.try_emplace(image, tasks.size());
            if (new_task) tasks.push_back({.image = image});
            ++tasks[task->second].users;
            task_of_texture.push_back(task->second);
            Texture& made = scene.textures.emplace_back();
            made.name = texture.name.empty() ? document.model.images[image].name : texture.name;
            std::tie(std::ignore, made.wrap_s, made.wrap_t, made.nearest) = key;
        });

    // The sizes of all images are added up from their headers before the first is decoded.
    uint64_t total_pixels = 0;
    for (ImageTask& task : tasks)
        keep_fault(task, [&] {
            task.encoded = data.image_bytes(task.image);
            total_pixels += uint64_t{task.users} * read_image_header(task.encoded).size.pixels();
            if (total_pixels > limits.max_total_texture_pixels)
                throw Error(ErrorCode::BadImage, "",
                            "up to this image the textures have " + std::to_string(total_pixels) +
                                " pixels, more than the limit of " + std::to_string(limits.max_total_texture_pixels));
        });
    throw_faults(tasks);

    parallel_for(tasks.size(), 1, [&](size_t i) {
        ImageTask& task = tasks[i];
        keep_fault(task, [&] { task.decoded = decode(task.encoded, limits); });
        task.encoded = {};
    });
    throw_faults(tasks);

    for (size_t i = 0; i < scene.textures.size(); ++i) {
        ImageTask& task = tasks[task_of_texture[i]];
        Texture& texture = scene.textures[i];
        texture.size = task.decoded.size;
        if (--task.users == 0)
            texture.texels = std::move(task.decoded.texels);
        else
            texture.texels = task.decoded.texels;
    }
}

}  // namespace photond
