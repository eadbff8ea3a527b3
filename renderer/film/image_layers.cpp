#include "renderer/film/image_layers.h"

#include <algorithm>
#include <string_view>

namespace photond {

namespace {

/// What a layer may be made of; an earlier one comes before a later one where an image has both.
struct Form {
    std::vector<std::string_view> channels;
    bool of_light;  // of the beauty too, which has no name
};
const Form kForms[] = {{{"R", "G", "B"}, true}, {{"X", "Y", "Z"}, false}, {{"Y"}, true}, {{"Z"}, false}};

struct ChannelName {
    std::string_view layer, last;
};

ChannelName split(std::string_view name) {
    const size_t dot = name.rfind('.');
    if (dot == std::string_view::npos || dot == 0) return {"", name};
    return {name.substr(0, dot), name.substr(dot + 1)};
}

/// The channels of a layer in one of the forms; empty where one is missing.
std::vector<size_t> channels_in_form(std::span<const std::string> names, std::string_view layer,
                                     const std::vector<std::string_view>& form) {
    std::vector<size_t> channels;
    for (const std::string_view wanted : form) {
        const auto found = std::find_if(names.begin(), names.end(), [&](const std::string& name) {
            const ChannelName parts = split(name);
            return parts.layer == layer && parts.last == wanted;
        });
        if (found == names.end()) return {};
        channels.push_back(static_cast<size_t>(found - names.begin()));
    }
    return channels;
}

}  // namespace

std::vector<NamedLayer> layers_of_channels(std::span<const std::string> channel_names) {
    std::vector<std::string_view> prefixes{""};  // each once
    for (const std::string& name : channel_names) {
        const std::string_view layer = split(name).layer;
        if (std::find(prefixes.begin(), prefixes.end(), layer) == prefixes.end()) prefixes.push_back(layer);
    }
    std::vector<NamedLayer> layers;
    for (const std::string_view prefix : prefixes) {
        const std::string name(prefix.empty() ? "beauty" : prefix);
        if (std::any_of(layers.begin(), layers.end(), [&](const NamedLayer& l) { return l.name == name; })) continue;
        for (const Form& form : kForms) {
            if (prefix.empty() && !form.of_light) continue;
            std::vector<size_t> channels = channels_in_form(channel_names, prefix, form.channels);
            if (channels.empty()) continue;
            layers.push_back({name, std::move(channels)});
            break;
        }
    }
    return layers;
}

}  // namespace photond
