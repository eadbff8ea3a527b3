#include "clients/cli/method_catalogue.h"

#include <algorithm>

#include "clients/cli/failure.h"
#include "clients/cli/stop_options.h"
#include "clients/cli/units.h"
#include "protocol/nearest_name.h"

namespace photond::cli {

using nlohmann::json;

namespace {

/// The one of that name; else a Failure that says what was meant, or where the names stand.
template <class T>
const T& named(const std::vector<T>& list, const std::string& name, const std::string& message,
               const std::string& otherwise) {
    const auto found = std::find_if(list.begin(), list.end(), [&](const T& item) { return item.name == name; });
    if (found != list.end()) return *found;
    std::vector<std::string> known;
    known.reserve(list.size());
    for (const T& item : list) known.push_back(item.name);
    const std::string near = nearest_name(name, known);
    throw Failure(ExitCode::Usage, message, near.empty() ? otherwise : "did you mean " + near + "?");
}

}  // namespace

const Parameter& CatalogueMethod::parameter(const std::string& parameter_name) const {
    return named(parameters, parameter_name, name + " has no parameter " + printable(parameter_name),
                 "photonctl methods " + name + " lists them");
}

void CatalogueMethod::require_layer(const std::string& layer) const {
    if (std::find(layers.begin(), layers.end(), layer) != layers.end()) return;
    const std::string near = nearest_name(layer, layers);
    std::string there_are;
    for (const std::string& one : layers) there_are += (there_are.empty() ? "" : ", ") + one;
    throw Failure(ExitCode::Usage, name + " has no layer " + printable(layer) + " on request",
                  (near.empty() ? "" : "did you mean " + near + "? ") + "there are " + there_are);
}

void CatalogueMethod::require_device(const std::string& device) const {
    if (devices.empty() || runs_on(device)) return;
    throw Failure(ExitCode::Usage, name + " does not run on " + printable(device) + ", only on a " + devices.front(),
                  "ask for --device " + devices.front() + "; photonctl devices shows what the daemon renders on");
}

bool CatalogueMethod::runs_on(const std::string& device) const {
    const std::string kind = device.empty() ? "cpu" : device.substr(0, 3);
    return std::find(devices.begin(), devices.end(), kind) != devices.end();
}

MethodCatalogue::MethodCatalogue(DaemonClient& daemon, std::string device) : device_(std::move(device)) {
    const json items = daemon.get("/v1/methods").at("items");
    for (const json& item : items) {
        CatalogueMethod method;
        method.name = item.value("name", "");
        method.parameters = parameters_of(item);
        for (const json& layer : item.value("layers", json::array())) method.layers.push_back(plain_text(layer));
        for (const json& kind : item.value("devices", json::array())) method.devices.push_back(plain_text(kind));
        const json hard_cases = item.value("hard_cases", json::object());
        for (const json& variant : hard_cases.value("variants", json::array()))
            method.variants.push_back(
                {printable(variant.value("label", "")), variant.value("parameters", json::object())});
        for (const json& limit : hard_cases.value("limits", json::array()))
            method.limits.push_back({limit.value("parameters", json::object()), limit.value("row", ""),
                                     printable(limit.value("text", ""))});
        methods_.push_back(std::move(method));
    }
}

const CatalogueMethod& MethodCatalogue::method(const std::string& name) const {
    return named(methods_, name, "the daemon has no method " + printable(name), "photonctl methods lists them");
}

json MethodCatalogue::method_from(const std::string& text) const {
    const std::vector<std::string> pieces = split(text, ',');
    const size_t at = pieces.front().find('@');
    const CatalogueMethod& found = method(pieces.front().substr(0, at));
    json wire{{"name", found.name}};
    if (at != std::string::npos)
        wire["device"] = pieces.front().substr(at + 1);
    else if (!device_.empty())
        wire["device"] = device_;
    for (size_t i = 1; i < pieces.size(); ++i) {
        const auto [name, value] = key_and_value(pieces[i], text.c_str());
        wire["parameters"][name] = found.parameter(name).parse(value);
    }
    return wire;
}

json MethodCatalogue::entry_from(const std::string& text) const {
    const size_t equals = text.find('=');
    const bool labelled = equals != std::string::npos && equals < text.find(',');
    if (labelled && equals == 0) throw Failure(ExitCode::Usage, "--entry " + printable(text) + " has an empty label");
    json entry{{"method", method_from(labelled ? text.substr(equals + 1) : text)}};
    entry["label"] = labelled ? json(text.substr(0, equals)) : entry["method"]["name"];
    return entry;
}

std::vector<std::string> split(const std::string& text, char separator) {
    std::vector<std::string> pieces;
    for (size_t begin = 0; begin <= text.size();) {
        const size_t end = std::min(text.find(separator, begin), text.size());
        pieces.push_back(text.substr(begin, end - begin));
        begin = end + 1;
    }
    return pieces;
}

}  // namespace photond::cli
