#include "protocol/job.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include "protocol/enumerated.h"
#include "protocol/nearest_name.h"
#include "protocol/object_reader.h"
#include "protocol/param_json.h"
#include "protocol/strict_json.h"

namespace photond {
namespace {

using nlohmann::json;

constexpr size_t kMaxNameBytes = 256;
constexpr size_t kMaxLabels = 64;
constexpr size_t kMaxLabelKeyBytes = 64;
constexpr size_t kMaxLabelValueBytes = 256;
constexpr double kMaxSeconds = 1e9;  // thirty years: further than any deadline, near enough for a clock's type
constexpr int64_t kMaxAnimations = 65536;
constexpr int64_t kMaxPasses = 1'000'000'000;
constexpr double kMaxCoordinate_m = 1e12;  // squares still fit a float's range
constexpr double kMaxScale = 1e12;
// A lens that sees nothing, or half of everything, has no projection.
constexpr NumberRange kFieldOfView{1e-4, std::numbers::pi - 1e-4, "rad"};

std::optional<std::array<double, 3>> read_vector(ObjectReader& reader, const std::string& key, bool required) {
    const json* value = reader.member(key, required);
    if (value == nullptr) return std::nullopt;
    if (!value->is_array() || value->size() != 3) {
        reader.faults().add(ErrorCode::WrongType, reader.at(key),
                            "must be an array of three numbers, got " +
                                (value->is_array() ? "one of " + std::to_string(value->size()) : value_text(*value)));
        return std::nullopt;
    }
    std::array<double, 3> vector{};
    bool good = true;
    for (size_t i = 0; i < 3; ++i) {
        const json& x = (*value)[i];
        const std::string pointer = reader.at(key) + "/" + std::to_string(i);
        if (!x.is_number()) {
            reader.faults().add(ErrorCode::WrongType, pointer, "must be a number, got " + value_text(x));
            good = false;
        } else if (!(std::abs(x.get<double>()) <= kMaxCoordinate_m)) {
            reader.faults().add(ErrorCode::OutOfRange, pointer,
                                value_text(x) + " is outside [-" + number_text(kMaxCoordinate_m) + ", " +
                                    number_text(kMaxCoordinate_m) + "] m");
            good = false;
        } else {
            vector[i] = x.get<double>();
        }
    }
    return good ? std::optional(vector) : std::nullopt;
}

double length_of_cross(const std::array<double, 3>& a, const std::array<double, 3>& b) {
    return std::hypot(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]);
}

/// What is wrong with the directions of a view: the member, and how.
std::optional<std::pair<std::string, std::string>> fault_of_directions(const LookAt& view) {
    const std::array<double, 3> forward{view.target[0] - view.eye[0], view.target[1] - view.eye[1],
                                        view.target[2] - view.eye[2]};
    const double distance = std::hypot(forward[0], forward[1], forward[2]);
    if (!(distance > 0)) return std::pair("target", "must differ from eye");
    const double up_length = std::hypot(view.up[0], view.up[1], view.up[2]);
    // Below this sine the image's roll would be decided by rounding.
    if (!(length_of_cross(forward, view.up) > 1e-6 * distance * up_length))
        return std::pair("up", "must not be zero nor parallel to the direction of view");
    return std::nullopt;
}

}  // namespace

LookAt read_look_at(const json& source, const std::string& pointer, BodyFaults& faults) {
    ObjectReader reader(source, pointer, faults);
    LookAt look_at;
    const auto eye = read_vector(reader, "eye", true);
    const auto target = read_vector(reader, "target", true);
    const auto up = read_vector(reader, "up", false);
    const auto yfov = reader.number("yfov", kFieldOfView);
    reader.finish();
    if (eye) look_at.eye = *eye;
    if (target) look_at.target = *target;
    if (up) look_at.up = *up;
    if (yfov) look_at.yfov = *yfov;
    if (!eye || !target) return look_at;
    if (const auto fault = fault_of_directions(look_at))
        faults.add(ErrorCode::Conflict, pointer + "/" + fault->first, fault->second);
    return look_at;
}

std::string fault_of_view(const LookAt& view) {
    for (const auto& [name, vector] :
         {std::pair("eye", view.eye), std::pair("target", view.target), std::pair("up", view.up)})
        for (const double x : vector)
            if (!(std::abs(x) <= kMaxCoordinate_m))
                return std::string(name) + " = " + number_text(x) + " is outside [-" + number_text(kMaxCoordinate_m) +
                       ", " + number_text(kMaxCoordinate_m) + "] m";
    if (!(view.yfov >= kFieldOfView.min && view.yfov <= kFieldOfView.max))
        return "yfov = " + number_text(view.yfov) + " is outside [" + number_text(kFieldOfView.min) + ", " +
               number_text(kFieldOfView.max) + "] rad";
    const auto fault = fault_of_directions(view);
    return fault ? fault->first + " " + fault->second : "";
}

namespace {

JobCamera read_camera(const json& source, const std::string& pointer, BodyFaults& faults) {
    ObjectReader reader(source, pointer, faults);
    JobCamera camera;
    if (const auto name = reader.string("name", kMaxNameBytes)) camera.name = *name;
    if (const json* look_at = reader.member("look_at"))
        camera.look_at = read_look_at(*look_at, reader.at("look_at"), faults);
    if (const auto aperture = reader.number("aperture", {0, 1e6, "m"})) camera.aperture = *aperture;
    camera.focus_distance = reader.number("focus_distance", {1e-6, kMaxCoordinate_m, "m"});
    reader.finish();
    if (!camera.name.empty() && camera.look_at)
        faults.add(ErrorCode::Conflict, reader.at("look_at"), "camera takes either name or look_at, not both");
    if (camera.aperture > 0 && !camera.focus_distance && !camera.look_at)
        faults.add(ErrorCode::MissingField, reader.at("focus_distance"),
                   "is required with an aperture, unless look_at gives a target to focus on");
    return camera;
}

void read_image(ObjectReader& body, const JobVocabulary& vocabulary, JobRequest& request) {
    const json* source = body.member("image", true);
    if (source == nullptr) return;
    ObjectReader reader(*source, body.at("image"), body.faults());
    const auto width = reader.integer("width", 1, vocabulary.max_width, true);
    const auto height = reader.integer("height", 1, vocabulary.max_height, true);
    if (width) request.width = static_cast<uint32_t>(*width);
    if (height) request.height = static_cast<uint32_t>(*height);
    if (const auto filter = reader.word("filter", {"box", "gaussian", "blackman_harris"})) request.filter = *filter;
    reader.finish();
}

// "cpu", "gpu" or "gpu:N".
bool is_device(const std::string& device) {
    if (device == "cpu" || device == "gpu") return true;
    if (!device.starts_with("gpu:")) return false;
    unsigned number = 0;
    const auto [end, error] = std::from_chars(device.data() + 4, device.data() + device.size(), number);
    return error == std::errc() && end == device.data() + device.size() && number < 1000;
}

JobMethod read_method(const json& source, const std::string& pointer, const JobVocabulary& vocabulary,
                      BodyFaults& faults) {
    ObjectReader reader(source, pointer, faults);
    const auto name = reader.word("name", vocabulary.method_names, true);
    const auto device = reader.string("device", kMaxNameBytes);
    const json* parameters = reader.member("parameters");
    reader.finish();

    JobMethod method;
    if (device) {
        method.device = *device;
        if (!is_device(*device))
            faults.add(ErrorCode::UnknownName, reader.at("device"),
                       value_text(*device) + " is no device: \"cpu\", \"gpu\" or \"gpu:N\"");
    }
    if (!name) return method;  // which parameters there are is then unknown
    method.name = *name;
    if (is_device(method.device)) {
        const std::vector<std::string> kinds = vocabulary.devices_of(*name);
        const std::string kind = method.device.substr(0, 3);
        if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end())
            faults.add(ErrorCode::Unsupported, reader.at("device"),
                       "unsupported: the method \"" + *name + "\" does not run on a " + kind + ", only on a " +
                           enumerated(kinds));
    }
    const std::unique_ptr<MethodParams> params = vocabulary.make_params(*name);
    std::vector<Fault> found;
    read_params(*params, parameters != nullptr ? *parameters : json::object(), reader.at("parameters"), found);
    faults.take(ErrorCode::OutOfRange, std::move(found));
    method.parameters = params_to_json(*params);
    return method;
}

std::optional<ErrorTarget> read_target(const json& source, const std::string& pointer, const JobVocabulary& vocabulary,
                                       bool has_reference, BodyFaults& faults) {
    ObjectReader reader(source, pointer, faults);
    const auto metric = reader.string("metric", kMaxNameBytes, true);
    const auto value = reader.number("value", {0, ErrorTarget::kGreatest}, true);
    reader.finish();
    if (!metric || !value) return std::nullopt;
    check_metric_name(*metric, reader.at("metric"), vocabulary, faults);
    const auto& estimated = vocabulary.estimated_metrics;
    if (!has_reference && std::find(estimated.begin(), estimated.end(), *metric) == estimated.end())
        faults.add(ErrorCode::Conflict, reader.at("metric"),
                   value_text(*metric) + " needs a reference; without one the metric is \"estimated_relative_mse\"");
    return ErrorTarget{*metric, *value};
}

std::optional<JobReference> read_reference(const json& source, const std::string& pointer,
                                           const JobVocabulary& vocabulary, BodyFaults& faults) {
    JobReference reference;
    if (source.is_string()) {
        const auto text = source.get<std::string>();
        if (text.starts_with("job:") && text.size() > 4 && text.size() <= kMaxNameBytes)
            reference.job = text.substr(4);
        else if (text.starts_with("image:") && text.size() > 6 && text.size() <= kMaxNameBytes)
            reference.image = text.substr(6);
        else
            faults.add(ErrorCode::UnknownName, pointer,
                       value_text(source) + " is no reference: \"job:ID\", \"image:ID\" or a method and its stop");
        return reference;
    }
    if (!source.is_object()) {
        faults.add(ErrorCode::WrongType, pointer,
                   "must be \"job:ID\", \"image:ID\" or an object with method and stop, got " + value_text(source));
        return std::nullopt;
    }
    ObjectReader reader(source, pointer, faults);
    const json* method = reader.member("method", true);
    const json* stop = reader.member("stop", true);
    reader.finish();
    reference.rendering.emplace();
    if (method) reference.rendering->method = read_method(*method, reader.at("method"), vocabulary, faults);
    if (stop) reference.rendering->stop = read_stop_conditions(*stop, reader.at("stop"), vocabulary, false, faults);
    return reference;
}

void read_metrics(ObjectReader& body, const JobVocabulary& vocabulary, JobRequest& request) {
    const json* source = body.member("metrics");
    if (source == nullptr) return;
    BodyFaults& faults = body.faults();
    if (!source->is_array()) {
        faults.add(ErrorCode::WrongType, body.at("metrics"), "must be an array, got " + value_text(*source));
        return;
    }
    for (size_t i = 0; i < source->size(); ++i) {
        const json& metric = (*source)[i];
        const std::string pointer = body.at("metrics") + "/" + std::to_string(i);
        if (!metric.is_string()) {
            faults.add(ErrorCode::WrongType, pointer, "must be a string, got " + value_text(metric));
            continue;
        }
        const auto name = metric.get<std::string>();
        check_metric_name(name, pointer, vocabulary, faults);
        if (std::find(request.metrics.begin(), request.metrics.end(), name) != request.metrics.end())
            faults.add(ErrorCode::Conflict, pointer, value_text(metric) + " is named twice");
        request.metrics.push_back(name);
    }
    if (!request.metrics.empty() && !request.reference)
        faults.add(ErrorCode::Conflict, body.at("metrics"), "metrics need a reference");
}

/// A metric of a layer that the image would not hold.
void check_metric_layers(const JobRequest& request, const JobVocabulary& vocabulary, BodyFaults& faults) {
    const auto check = [&](const std::string& metric, const std::string& pointer) {
        const std::string layer = layer_of_metric(metric);
        const auto is_in = [&](const std::vector<std::string>& layers) {
            return std::find(layers.begin(), layers.end(), layer) != layers.end();
        };
        if (layer != "beauty" && !is_in(vocabulary.always_layers) && !is_in(request.layers))
            faults.add(ErrorCode::Conflict, pointer,
                       value_text(metric) + " needs the layer \"" + layer + "\": add it to layers");
    };
    if (request.stop.target) check(request.stop.target->metric, "/stop/target/metric");
    for (size_t i = 0; i < request.metrics.size(); ++i) check(request.metrics[i], "/metrics/" + std::to_string(i));
}

void read_layers(ObjectReader& body, const JobVocabulary& vocabulary, JobRequest& request) {
    const json* source = body.member("layers");
    if (source == nullptr) return;
    const bool method_known = !request.method.name.empty();
    const std::vector<std::string> of_method =
        method_known ? vocabulary.layers_of(request.method.name) : std::vector<std::string>();
    BodyFaults& faults = body.faults();
    if (!source->is_array()) {
        faults.add(ErrorCode::WrongType, body.at("layers"), "must be an array, got " + value_text(*source));
        return;
    }
    for (size_t i = 0; i < source->size(); ++i) {
        const json& layer = (*source)[i];
        const std::string pointer = body.at("layers") + "/" + std::to_string(i);
        if (!layer.is_string()) {
            faults.add(ErrorCode::WrongType, pointer, "must be a string, got " + value_text(layer));
            continue;
        }
        const auto name = layer.get<std::string>();
        const auto& known = vocabulary.layer_names;
        if (std::find(known.begin(), known.end(), name) == known.end())
            faults.add(ErrorCode::UnknownName, pointer,
                       value_text(layer) + " is no layer on request" + did_you_mean(name, known) + "; there are " +
                           enumerated(method_known ? of_method : known));
        else if (std::find(request.layers.begin(), request.layers.end(), name) != request.layers.end())
            faults.add(ErrorCode::Conflict, pointer, value_text(layer) + " is named twice");
        else if (method_known && std::find(of_method.begin(), of_method.end(), name) == of_method.end())
            faults.add(ErrorCode::Unsupported, pointer,
                       "unsupported: " + request.method.name + " has no layer " + value_text(layer) + "; it has " +
                           enumerated(of_method));
        else
            request.layers.push_back(name);
    }
}

void read_labels(ObjectReader& body, JobRequest& request) {
    const json* source = body.member("labels");
    if (source == nullptr) return;
    BodyFaults& faults = body.faults();
    if (!source->is_object()) {
        faults.add(ErrorCode::WrongType, body.at("labels"), "must be an object, got " + value_text(*source));
        return;
    }
    if (source->size() > kMaxLabels)
        faults.add(ErrorCode::OutOfRange, body.at("labels"),
                   std::to_string(source->size()) + " labels, at most " + std::to_string(kMaxLabels) + " are kept");
    for (const auto& [key, value] : source->items()) {
        const std::string pointer = body.at("labels") + "/" + pointer_token(key);
        if (key.empty() || key.size() > kMaxLabelKeyBytes || key.find('=') != std::string::npos)
            faults.add(ErrorCode::OutOfRange, pointer,
                       "a label's key has 1 to " + std::to_string(kMaxLabelKeyBytes) + " bytes and no '='");
        if (!value.is_string())
            faults.add(ErrorCode::WrongType, pointer, "must be a string, got " + value_text(value));
        else if (value.get_ref<const std::string&>().size() > kMaxLabelValueBytes)
            faults.add(ErrorCode::OutOfRange, pointer,
                       "has " + std::to_string(value.get_ref<const std::string&>().size()) + " bytes, the limit is " +
                           std::to_string(kMaxLabelValueBytes));
        else
            request.labels[key] = value.get<std::string>();
    }
}

JobEnvironment read_environment(const json& source, const std::string& pointer, BodyFaults& faults) {
    ObjectReader reader(source, pointer, faults);
    JobEnvironment environment;
    if (const auto image = reader.string("image", kMaxNameBytes, true)) {
        environment.image = *image;
        if (!image->starts_with("image:") || image->size() == 6)
            faults.add(ErrorCode::UnknownName, reader.at("image"),
                       value_text(*image) + " names no uploaded image: write \"image:ID\"");
    }
    if (const auto scale = reader.number("scale", {0, kMaxScale})) environment.scale = *scale;
    if (const auto rotation = reader.number("rotation", {-1e4, 1e4, "rad"})) environment.rotation = *rotation;
    reader.finish();
    return environment;
}

json optional_json(const auto& value) { return value ? json(*value) : json(nullptr); }

/// A time or a shutter by itself is of the scene's first animation.
void read_moment(ObjectReader& reader, JobRequest& request) {
    if (const auto time = reader.number("time", {-1e9, 1e9, "s"})) request.time = *time;
    if (const auto shutter = reader.number("shutter", {0, 1e9, "s"})) request.shutter = *shutter;
    const json* animation = reader.member("animation");
    if (animation == nullptr) {
        if (request.time != 0 || request.shutter != 0) request.animation = JobAnimation{.name = {}, .index = 0};
    } else if (animation->is_string()) {
        const auto name = reader.string("animation", kMaxNameBytes);
        request.animation = JobAnimation{.name = name.value_or(""), .index = {}};
    } else if (const auto index = reader.integer("animation", 0, kMaxAnimations - 1)) {
        request.animation = JobAnimation{.name = {}, .index = static_cast<uint32_t>(*index)};
    }
}

}  // namespace

void check_metric_name(const std::string& metric, const std::string& pointer, const JobVocabulary& vocabulary,
                       BodyFaults& faults) {
    const size_t colon = metric.find(':');
    const std::string name = colon == std::string::npos ? metric : metric.substr(colon + 1);
    const auto& metrics = vocabulary.metric_names;
    const auto& estimated = vocabulary.estimated_metrics;
    const auto& layers = vocabulary.radiance_layers;
    if (std::find(metrics.begin(), metrics.end(), name) == metrics.end())
        faults.add(ErrorCode::UnknownName, pointer, value_text(name) + " is no metric" + did_you_mean(name, metrics));
    if (colon == std::string::npos) return;
    const std::string layer = metric.substr(0, colon);
    if (layer != "beauty" && std::find(layers.begin(), layers.end(), layer) == layers.end())
        faults.add(ErrorCode::UnknownName, pointer,
                   value_text(layer) + " is no layer of radiance" + did_you_mean(layer, layers));
    else if (std::find(estimated.begin(), estimated.end(), name) != estimated.end())
        faults.add(ErrorCode::Unsupported, pointer, "unsupported: " + name + " is of the beauty only");
}

std::string layer_of_metric(const std::string& metric) {
    const size_t colon = metric.find(':');
    return colon == std::string::npos ? "beauty" : metric.substr(0, colon);
}

StopConditions read_stop_conditions(const json& source, const std::string& pointer, const JobVocabulary& vocabulary,
                                    bool has_reference, BodyFaults& faults) {
    const size_t faults_before = faults.size();
    ObjectReader reader(source, pointer, faults);
    StopConditions stop;
    stop.seconds = reader.number("seconds", {StopConditions::kLeastSeconds, kMaxSeconds, "s"});
    if (const auto passes = reader.integer("passes", 1, kMaxPasses)) stop.passes = static_cast<uint32_t>(*passes);
    if (const json* target = reader.member("target"))
        stop.target = read_target(*target, reader.at("target"), vocabulary, has_reference, faults);
    reader.finish();
    if (faults.size() == faults_before && !stop.seconds && !stop.passes && !stop.target)
        faults.add(ErrorCode::MissingField, pointer, "at least one of seconds, passes and target is required");
    return stop;
}

JobRequest parse_job_request(const json& body, const JobVocabulary& vocabulary) {
    BodyFaults faults;
    ObjectReader reader(body, "", faults);
    JobRequest request;
    if (!body.is_object()) faults.throw_if_any();  // else every required field would be called missing too

    if (const auto scene = reader.string("scene", kMaxNameBytes, true)) request.scene = *scene;
    if (const json* camera = reader.member("camera"))
        request.camera = read_camera(*camera, reader.at("camera"), faults);
    read_image(reader, vocabulary, request);
    if (const json* method = reader.member("method", true))
        request.method = read_method(*method, reader.at("method"), vocabulary, faults);
    if (const json* reference = reader.member("reference"))
        request.reference = read_reference(*reference, reader.at("reference"), vocabulary, faults);
    if (const json* stop = reader.member("stop", true))
        request.stop =
            read_stop_conditions(*stop, reader.at("stop"), vocabulary, request.reference.has_value(), faults);
    if (const auto first = reader.integer("first_pass", 0, kMaxPasses))
        request.first_pass = static_cast<uint32_t>(*first);
    if (const auto seed = reader.seed("seed")) request.seed = *seed;
    read_layers(reader, vocabulary, request);
    if (const auto priority = reader.integer("priority", -100, 100)) request.priority = static_cast<int>(*priority);
    request.quiet_machine = reader.number("quiet_machine", {0, kMaxSeconds, "s"});
    read_labels(reader, request);
    if (const json* environment = reader.member("environment"))
        request.environment = read_environment(*environment, reader.at("environment"), faults);
    if (const auto glass = reader.word("glass", {"as_stored", "solid"})) request.glass = *glass;
    read_moment(reader, request);
    read_metrics(reader, vocabulary, request);
    reader.finish();
    check_metric_layers(request, vocabulary, faults);
    faults.throw_if_any();
    return request;
}

void check_animation(const JobAnimation& animation, const std::vector<std::string>& names) {
    const std::string there_are =
        names.empty() ? "the scene has no animations" : "the scene has " + std::to_string(names.size()) + " animations";
    if (animation.index && *animation.index >= names.size())
        throw Error(ErrorCode::UnknownName, "/animation",
                    there_are + ": " + std::to_string(*animation.index) + " is the index of none");
    if (animation.index || std::find(names.begin(), names.end(), animation.name) != names.end()) return;
    const std::string nearest = nearest_name(animation.name, names);
    throw Error(ErrorCode::UnknownName, "/animation",
                there_are + ", none of them named \"" + animation.name.substr(0, 100) + "\"" +
                    (nearest.empty() ? "" : "; did you mean \"" + nearest + "\"?"));
}

json to_json(const LookAt& look_at) {
    return {{"eye", look_at.eye}, {"target", look_at.target}, {"up", look_at.up}, {"yfov", look_at.yfov}};
}

json to_json(const StopConditions& stop) {
    json target = nullptr;
    if (stop.target) target = {{"metric", stop.target->metric}, {"value", stop.target->value}};
    return {{"seconds", optional_json(stop.seconds)}, {"passes", optional_json(stop.passes)}, {"target", target}};
}

json to_json(const JobMethod& method) {
    return {{"name", method.name}, {"device", method.device}, {"parameters", method.parameters}};
}

json to_json(const JobAnimation& animation) { return animation.index ? json(*animation.index) : json(animation.name); }

json to_json(const JobReference& reference) {
    if (!reference.job.empty()) return "job:" + reference.job;
    if (!reference.image.empty()) return "image:" + reference.image;
    return {{"method", to_json(reference.rendering->method)}, {"stop", to_json(reference.rendering->stop)}};
}

json to_json(const JobRequest& request) {
    const auto& look_at = request.camera.look_at;
    json environment = nullptr;
    if (const auto& from = request.environment)
        environment = {{"image", from->image}, {"scale", from->scale}, {"rotation", from->rotation}};
    json labels = json::object();
    for (const auto& [key, value] : request.labels) labels[key] = value;
    return {{"scene", request.scene},
            {"camera",
             {{"name", request.camera.name.empty() ? json(nullptr) : json(request.camera.name)},
              {"look_at", look_at ? to_json(*look_at) : json()},
              {"aperture", request.camera.aperture},
              {"focus_distance", optional_json(request.camera.focus_distance)}}},
            {"image", {{"width", request.width}, {"height", request.height}, {"filter", request.filter}}},
            {"method", to_json(request.method)},
            {"stop", to_json(request.stop)},
            {"first_pass", request.first_pass},
            {"seed", request.seed},
            {"layers", request.layers},
            {"reference", request.reference ? to_json(*request.reference) : json(nullptr)},
            {"metrics", request.metrics},
            {"priority", request.priority},
            {"quiet_machine", optional_json(request.quiet_machine)},
            {"labels", labels},
            {"environment", environment},
            {"glass", request.glass},
            {"animation", request.animation ? to_json(*request.animation) : json(nullptr)},
            {"time", request.time},
            {"shutter", request.shutter}};
}

namespace {

/// A parameter that methods have had only since jobs have names.
struct NewParameter {
    std::string_view key;
    json off;                             // the value at which it asks for nothing new
    std::vector<std::string_view> tuned;  // parameters that came with it and mean nothing then
    std::string_view former_by{};         // whoever has this parameter has had the new one from the first on
};

const std::vector<NewParameter>& new_parameters() {
    static const std::vector<NewParameter> kNew = {
        {"temporal", "none", {"history_cap"}}, {"aged", false, {"cache_age"}},
        {"incremental", false, {"new_vpls"}},  {"kept_lists", 0, {}},
        {"near_field_radius", nullptr, {}},    {"placement", "flux", {}, "visibility"}};
    return kNew;
}

/// Of methods' parameters, wherever there are any.
void leave_out_new_parameters(json& part) {
    for (const NewParameter& parameter : new_parameters()) {
        if (!part.is_object()) break;
        const auto found = part.find(parameter.key);
        if (found == part.end() || *found != parameter.off) continue;
        if (!parameter.former_by.empty() && part.contains(parameter.former_by)) continue;
        part.erase(found);
        for (const std::string_view key : parameter.tuned) part.erase(key);
    }
    if (part.is_structured())
        for (json& inner : part) leave_out_new_parameters(inner);
}

}  // namespace

json naming_json(json request) {
    leave_out_new_parameters(request);
    if (request.value("animation", json()).is_null()) request.erase("animation");
    if (request.value("shutter", 0.0) == 0) request.erase("shutter");
    return request;
}

double progress_of(const StopConditions& stop, uint32_t passes, double seconds) {
    double progress = 0;
    if (stop.passes) progress = std::max(progress, passes / static_cast<double>(*stop.passes));
    if (stop.seconds && *stop.seconds > 0) progress = std::max(progress, seconds / *stop.seconds);
    return std::min(progress, 1.0);
}

}  // namespace photond
