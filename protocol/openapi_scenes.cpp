// Scenes and, for the hard cases among them, what must come out.

#include "protocol/openapi_schemas.h"

namespace photond::openapi {
namespace {

json known_answer_schema() {
    json region = list_of(in_range(typed("number"), 0, 1)), value = list_of(typed("number"));
    region["minItems"] = region["maxItems"] = 4;
    value["minItems"] = value["maxItems"] = 3;
    const json relation = with_text(
        one_of_words({"equals", "at_most", "same_as", "reference", "zero", "finite"}),
        "the layer's mean over the region is `value`; is at most `value`; is that of `scene`, by the same method, "
        "times "
        "`scale`; is what path tracing gives; is 0 in every pixel; holds no NaN, infinity or negative radiance");
    const json check =
        given({{"relation", relation},
               {"layer", one_of_words({"beauty", "direct", "indirect", "emitted"})},
               {"region", with_text(region, "x0, y0, x1, y1: fractions of the image, row 0 at the top")},
               {"value", with_text(or_null(value), "red, green and blue radiance, W m^-2 sr^-1")},
               {"scene", nullable("string", "the other scene's name")},
               {"scale", typed("number", "of the other scene's radiance")},
               {"bounces", or_null(count("of the indirect layer that the answer is for; null: unlimited"))},
               {"tolerance", typed("number", "relative error of the answer itself, by quadrature or by facets")}});
    return with_text(given({{"case", typed("string", "row of the table of hard cases: several scenes may make one")},
                            {"strains", typed("string")},
                            {"text", typed("string", "what must come out")},
                            {"checks", list_of(check)},
                            {"passes", count("suggested, as is the size")},
                            {"width", count()},
                            {"height", count()},
                            {"not_applicable", with_text(map_of(typed("string")), "by method: why")}}),
                     "what a hard case's image, seen by its first camera, must be; null for other scenes");
}

json scene_page_schema() {
    json page = page_of("Scene");
    json row = given({{"name", typed("string")},
                      {"test", typed("string", "program of the test suite")},
                      {"known_answer", schema_ref("KnownAnswer")}});
    page["properties"]["tests"] = with_text(
        or_null(list_of(std::move(row))),
        "hard cases that no scene can show, with the tests in their place; null unless that family is asked for");
    page["required"].push_back("tests");
    return page;
}

json scene_schema() {
    json corner = list_of(typed("number"));
    corner["minItems"] = corner["maxItems"] = 3;
    const json view = with_text(
        given({{"eye", corner}, {"target", corner}, {"up", corner}, {"yfov", typed("number", "radians")}}),
        "as a job's camera.look_at takes it; the target lies as deep in the view as the middle of the bounds");
    json motion = given({{"index", count()},
                         {"name", typed("string")},
                         {"duration_seconds", typed("number", "of its last key")},
                         {"moves", given({{"meshes", count()},
                                          {"triangles", count("of these meshes")},
                                          {"cameras", count()},
                                          {"lights", count("that nodes carry; what shines in a mesh is that mesh's")},
                                          {"materials", count()}})}});
    return with_later(
        given(
            {{"id", typed("string")},
             {"name", nullable("string")},
             {"bytes", nullable("integer", "of its files")},
             {"memory_bytes", nullable("integer", "about what it takes in a worker, ray structure included")},
             {"acceleration_bytes", nullable("integer", "of them the ray structure's")},
             {"triangles", nullable("integer")},
             {"vertices", nullable("integer")},
             {"materials", nullable("integer")},
             {"textures", nullable("integer")},
             {"lights", or_null(given({{"area", count()}, {"punctual", count()}, {"environment", typed("boolean")}}))},
             {"cameras",
              list_of(given(
                  {{"name", typed("string")},
                   {"yfov", nullable("number", "radians")},
                   {"aspect",
                    nullable("number", "width over height of the image that its file asks for; a job says its own")},
                   {"look_at", or_null(view)}}))},
             {"default_view", with_text(or_null(view),
                                        "of a job that names no camera: the first one's, or one framed on "
                                        "the bounds; null only in lists, for scenes of an earlier version")},
             {"animations", nullable("integer", "how many of them: \"motion\" lists them")},
             {"bounds", or_null(given({{"min", corner}, {"max", corner}}))},
             {"needs", or_null(map_of(typed("boolean")))},
             {"photon_yield", with_text(or_null(with_later(given({{"global", typed("number")},
                                                                  {"caustic", typed("number")},
                                                                  {"caustic_unguided", typed("number")}}),
                                                           {{"global_unguided", typed("number")}})),
                                        "photons stored for each light path, as a few paths had it: led by "
                                        "projection maps where these help, and unguided")},
             {"warnings", list_of(typed("string"))},
             {"builtin", typed("boolean")},
             {"known_answer", nullable_ref("KnownAnswer")}}),
        {{"least_glossy_alpha", nullable("number", "GGX, of the narrowest rough specular lobe; null: none")},
         {"motion", with_text(or_null(list_of(motion)),
                              "its animations, in the order of their indices; null: of a scene of an earlier version, "
                              "which was not looked at for it")}});
}

}  // namespace

json scene_schemas() {
    return {{"Scene", scene_schema()}, {"ScenePage", scene_page_schema()}, {"KnownAnswer", known_answer_schema()}};
}

}  // namespace photond::openapi
