#pragma once
// What decides the bits of a job's passes, as texts that saved films carry: films are gone on with, and joined, only
// where these agree.

#include <nlohmann/json.hpp>
#include <string>

#include "protocol/job.h"
#include "renderer/film/film_file.h"
#include "server/worker/device.h"

namespace photond {

/// Which random numbers a job draws: its own, or those kept for references.
enum class RandomStreams : uint8_t { Job, Reference };
/// "job" or "reference"; throws ErrorCode::UnknownName for anything else.
RandomStreams random_streams_named(const std::string& name);

/// SHA-256 of all settings that decide a pass's pixels, whatever its index: the request as understood without scene,
/// stop, first_pass, priority, labels, reference and metrics, its layers in the order of kLayers, and the streams.
std::string settings_hash(const JobRequest& request, RandomStreams streams);

/// Machines of one class give the same bits. Ours are as free to differ as the compiler and the libraries make them:
/// the build's compiler, optimisation and instruction sets decide where products and sums are contracted to one
/// rounding (-march=native: the build machine's, tuned for its model); Embree and the C library choose their code at
/// run time by what the processor can do. All of these are in it, and the processor's name, which stands for the
/// model that was tuned for; or the GPU's, with its driver, which compiles the shaders. So passes of a CPU and of a
/// GPU, or of two kinds of card, are never mixed in one film.
std::string device_class(const Device& device);

/// Of the films a job renders. `device` ends with the program's version.
FilmIdentity film_identity(const JobRequest& request, const std::string& scene_id, RandomStreams streams,
                           const Device& device);

}  // namespace photond
