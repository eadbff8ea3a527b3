#pragma once
// What a scene contains, asked once. Whatever it does not need is not built.

#include <cstdint>

namespace photond {

struct Scene;

struct Needs {
    bool delta = false;   // a mirror or smooth glass lobe
    bool glossy = false;  // a rough specular lobe
    bool diffuse = false;
    bool transmission = false;
    bool solid_glass = false;
    bool alpha = false;  // masked or blended surfaces
    bool normal_maps = false;
    bool base_color_textures = false;
    bool material_textures = false;  // metallic-roughness, specular, transmission
    bool emission_textures = false;
    bool vertex_colors = false;
    bool unlit = false;
    bool area_lights = false;
    bool punctual_lights = false;
    bool environment = false;
    bool instances = false;  // a mesh used more than once

    /// Every surface is a plain Lambert reflector without textures, alpha or vertex colours.
    bool only_lambert() const {
        return !delta && !glossy && !transmission && !alpha && !normal_maps && !base_color_textures &&
               !material_textures && !emission_textures && !vertex_colors && !unlit;
    }

    /// Calls visitor(name, bool) for each need; the names are the wire's.
    template <class Visitor>
    void visit(Visitor&& visitor) const {
        visitor("delta", delta), visitor("glossy", glossy), visitor("diffuse", diffuse);
        visitor("transmission", transmission), visitor("solid_glass", solid_glass), visitor("alpha", alpha);
        visitor("normal_maps", normal_maps), visitor("base_color_textures", base_color_textures);
        visitor("material_textures", material_textures), visitor("emission_textures", emission_textures);
        visitor("vertex_colors", vertex_colors), visitor("unlit", unlit), visitor("area_lights", area_lights);
        visitor("punctual_lights", punctual_lights), visitor("environment", environment);
        visitor("instances", instances);
    }
};

Needs find_needs(const Scene& scene);

}  // namespace photond
