#include "server/worker/film_identity.h"

#include <gnu/libc-version.h>

#include <algorithm>

#include "protocol/error.h"
#include "renderer/core/sha256.h"

namespace photond {

using nlohmann::json;

namespace {

std::string hash_of(const json& canonical) {
    const std::string text = canonical.dump(-1, ' ', false, json::error_handler_t::replace);
    return sha256_hex(text.data(), text.size());
}

/// What the compiler was allowed to use.
std::string build_text() {
    std::string text = "built by gcc " __VERSION__;
#ifdef __OPTIMIZE__
    text += " optimised";
#else
    text += " unoptimised";
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    text += " sanitized";
#endif
#ifdef __SSE4_2__
    text += " sse4.2";
#endif
#ifdef __AVX__
    text += " avx";
#endif
#ifdef __AVX2__
    text += " avx2";
#endif
#ifdef __FMA__
    text += " fma";
#endif
#ifdef __AVX512F__
    text += " avx512f";
#endif
#ifdef __AVX512VL__
    text += " avx512vl";
#endif
#ifdef __AVX512DQ__
    text += " avx512dq";
#endif
#ifdef __AVX512FP16__
    text += " avx512fp16";
#endif
    return text;
}

/// What libraries choose their code by.
std::string processor_text() {
    std::string text = "runs";
#if defined(__x86_64__)
    const auto add = [&text](const char* name, int supported) {
        if (supported) text.append(" ").append(name);
    };
    add("sse4.2", __builtin_cpu_supports("sse4.2"));
    add("avx", __builtin_cpu_supports("avx"));
    add("avx2", __builtin_cpu_supports("avx2"));
    add("fma", __builtin_cpu_supports("fma"));
    add("avx512f", __builtin_cpu_supports("avx512f"));
    add("avx512dq", __builtin_cpu_supports("avx512dq"));
    add("avx512bw", __builtin_cpu_supports("avx512bw"));
    add("avx512vl", __builtin_cpu_supports("avx512vl"));
#endif
    return text;
}

}  // namespace

RandomStreams random_streams_named(const std::string& name) {
    if (name == "job") return RandomStreams::Job;
    if (name == "reference") return RandomStreams::Reference;
    throw Error(ErrorCode::UnknownName, "streams \"" + name + "\" are neither \"job\" nor \"reference\"");
}

std::string settings_hash(const JobRequest& request, RandomStreams streams) {
    json canonical = naming_json(request);
    for (const char* other :
         {"scene", "stop", "first_pass", "priority", "labels", "quiet_machine", "reference", "metrics"})
        canonical.erase(other);
    json layers = json::array();
    for (const LayerInfo& info : kLayers)
        if (std::find(request.layers.begin(), request.layers.end(), info.name) != request.layers.end())
            layers.push_back(info.name);
    canonical["layers"] = layers;
    canonical["streams"] = streams == RandomStreams::Reference ? "reference" : "job";
    return hash_of(canonical);
}

std::string device_class(const Device& device) {
    const std::string driver = device.driver.empty() ? "" : device.driver + "; ";
    return device.kind + "; " + device.name + "; " + driver + processor_text() + "; C library " +
           gnu_get_libc_version() + "; " + build_text();
}

FilmIdentity film_identity(const JobRequest& request, const std::string& scene_id, RandomStreams streams,
                           const Device& device) {
    return {scene_id.empty() ? request.scene : scene_id, settings_hash(request, streams),
            device_class(device) + "; photond " PHOTOND_VERSION};
}

}  // namespace photond
