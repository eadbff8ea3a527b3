#pragma once
// What a scene contains, asked once. Whatever it does not need is not built.

#include <cstdint>
#include <limits>

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
    bool instances = false;                                             // a mesh used more than once
    float least_glossy_alpha = std::numeric_limits<float>::infinity();  // GGX, of rough specular lobes

    /// Every surface is a plain Lambert reflector without textures, alpha or vertex colours.
    bool only_lambert() const {
        return !delta && !glossy && !transmission && !alpha && !normal_maps && !base_color_textures &&
               !material_textures && !emission_textures && !vertex_colors && !unlit;
    }

    /// Calls visitor(name, bool) for each need that there is or is not; the names are the wire's.
    template <class Visitor>
    void visit(Visitor&& visitor) const {
        visit(*this, visitor);
    }
    /// The same with bool&: to fill it in by name.
    template <class Visitor>
    void visit(Visitor&& visitor) {
        visit(*this, visitor);
    }

private:
    template <class Self, class Visitor>
    static void visit(Self& needs, Visitor& visitor) {
        visitor("delta", needs.delta), visitor("glossy", needs.glossy), visitor("diffuse", needs.diffuse);
        visitor("transmission", needs.transmission), visitor("solid_glass", needs.solid_glass);
        visitor("alpha", needs.alpha), visitor("normal_maps", needs.normal_maps);
        visitor("base_color_textures", needs.base_color_textures);
        visitor("material_textures", needs.material_textures), visitor("emission_textures", needs.emission_textures);
        visitor("vertex_colors", needs.vertex_colors), visitor("unlit", needs.unlit);
        visitor("area_lights", needs.area_lights), visitor("punctual_lights", needs.punctual_lights);
        visitor("environment", needs.environment), visitor("instances", needs.instances);
    }
};

Needs find_needs(const Scene& scene);
/// Which kinds of light are needed, alone.
void find_light_needs(const Scene& scene, Needs& needs);

}  // namespace photond
