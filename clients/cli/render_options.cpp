#include "clients/cli/render_options.h"

#include "clients/cli/json_member.h"
#include "clients/cli/stop_options.h"

namespace photond::cli {

namespace {

using nlohmann::json;

constexpr uint32_t kDefaultPasses = 64;

/// Parameters of the command line over those of the request; every name and value checked against the schema.
void put_parameters(json& parameters, const RenderOptions& options, const CatalogueMethod& method) {
    std::map<std::string, std::string> given = options.parameters;
    for (const std::string& setting : options.settings) {
        const auto [name, value] = key_and_value(setting, "--set");
        given.insert_or_assign(name, value);
    }
    for (const auto& [name, text] : given) parameters[name] = method.parameter(name).parse(text);
}

/// What only a job says, not a comparison.
void put_method(json& request, const RenderOptions& options, const CatalogueMethod& known) {
    json& method = object_in(request, "method");
    method["name"] = known.name;
    if (!options.device.empty()) method["device"] = options.device;
    put_parameters(object_in(method, "parameters"), options, known);
    if (!request.contains("stop") || request["stop"].empty()) request["stop"] = {{"passes", kDefaultPasses}};
    if (options.seed) request["seed"] = *options.seed;
}

void check_layers(const json& request, const CatalogueMethod& method) {
    if (!request.contains("layers") || !request["layers"].is_array() || method.layers.empty()) return;
    for (const json& layer : request["layers"])
        if (layer.is_string()) method.require_layer(layer.get<std::string>());
}

/// The method that renders: the command line's, else that of a request from standard input, which nobody had read when
/// the options were made.
CatalogueMethod method_of(Session& session, const RenderOptions& options, const CatalogueMethod& known,
                          const json& request) {
    if (!options.method.empty() || !request.contains("method") || !request["method"].is_object()) return known;
    const std::string name = request["method"].value("name", known.name);
    return name == known.name ? known : MethodCatalogue(session.daemon()).method(name);
}

}  // namespace

json job_body(Session& session, const RenderOptions& options, const CatalogueMethod& known) {
    json request = start_request(options.request);
    const CatalogueMethod method = method_of(session, options, known, request);
    put_method(request, options, method);
    method.require_device(request["method"].value("device", "cpu"));
    check_layers(request, method);
    return request;
}

json job_request(Session& session, const RenderOptions& options, const CatalogueMethod& known) {
    json request = job_body(session, options, known);
    send_parts(session, request, options.request);
    return request;
}

void add_job_options(CLI::App& command, const std::shared_ptr<RenderOptions>& options,
                     const RenderVocabulary& vocabulary) {
    const auto add = [&](const char* name, auto& value, const char* text, const char* type) {
        return command.add_option(name, value, text)->type_name(type);
    };
    add_source_options(command, options->request);
    add("-m,--method", options->method, "method of light transport; default: path_tracing", "METHOD");
    add("--device", options->device, "where to render; default: cpu", "DEVICE");
    add("--set", options->settings, "set a parameter of the method; may be repeated", "NAME=VALUE")
        ->expected(1)
        ->take_all();
    add_stop_options(command, options->request.stop,
                     "stop after this many samples a pixel; default, without --seconds and --target: 64");
    add_image_options(command, options->request, vocabulary.method.layers);
    add("--seed", options->seed, "of the random numbers; default: 1", "INT");
    add_view_options(command, options->request);
    for (const Parameter& parameter : vocabulary.method.parameters) {
        if (command.get_option_no_throw(parameter.option_name()))
            continue;  // the name is taken: --set still reaches it
        command
            .add_option_function<std::string>(
                parameter.option_name(),
                [options, name = parameter.name](const std::string& text) { options->parameters[name] = text; },
                parameter.help())
            ->type_name(parameter.value_name())
            ->group("Parameters of " + vocabulary.method.name);
    }
    if (!vocabulary.known) command.footer("The parameters of a method are listed here when the daemon can be reached.");
}

}  // namespace photond::cli
