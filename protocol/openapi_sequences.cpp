#include "protocol/openapi_schemas.h"
#include "protocol/sequence.h"

namespace photond::openapi {
namespace {

/// Where the camera is: either member.
json path_schema(const json& view) {
    json key = view;
    key["properties"]["time"] = in_range(typed("number", "s, later than the key before"), -1e9, 1e9);
    key["required"].push_back("time");
    json keys = list_of(std::move(key));
    keys["minItems"] = 1;
    keys["maxItems"] = 10'000;
    return taken(
        {{"turns", or_null(in_range(typed("number",
                                          "of the eye about the vertical axis through look_at's target, over the "
                                          "whole sequence; counter-clockwise from above"),
                                    -1e6, 1e6))},
         {"keys", or_null(with_text(std::move(keys), "views that the camera passes by, smoothly"))}},
        {});
}

json sequence_request_schema(const json& job_request) {
    json properties = job_request.at("properties");
    const json view = properties.at("camera").at("anyOf").at(0).at("properties").at("look_at").at("anyOf").at(0);
    for (const char* not_here : {"time", "first_pass"}) properties.erase(not_here);
    properties.update(
        {{"from", or_null(in_range(typed("number", "s: the first frame's moment; default: 0"), -1e9, 1e9))},
         {"to", or_null(in_range(typed("number", "s: no frame comes after; or else frames"), -1e9, 1e9))},
         {"fps", or_null(in_range(typed("number", "frames a second; default: 24"), 1e-6, 1e6))},
         {"frames", or_null(in_range(typed("integer", "their number, or else to"), 1, kMaxFrames))},
         {"noise", with_text(or_null(one_of_words({"fresh", "still"})),
                             "fresh: each frame has a seed of its own, counted up from seed; default")},
         {"camera_path", or_null(path_schema(view))}});
    properties["animation"]["description"] =
        "name or index of one of the scene's animations; default: its first, or none along a camera_path";
    json schema = taken(std::move(properties), {"scene", "image", "method", "stop"});
    if (job_request.contains("allOf")) schema["allOf"] = job_request.at("allOf");
    return schema;
}

json sequence_summary_schema() {
    return given({{"id", typed("string")},
                  {"state", state()},
                  {"progress", in_range(typed("number"), 0, 1)},
                  {"seconds_left", nullable("number", "as frames that are done tell; null before the first one is")},
                  {"created", {{"type", "string"}, {"format", "date-time"}}},
                  {"started", time_or_none()},
                  {"finished", time_or_none()},
                  {"job_states", map_of(count())},
                  {"frames_share", list_of(typed("string",
                                                 "what each frame follows from of the one before; frames "
                                                 "stand alone where there is nothing"))},
                  {"request", schema_ref("SequenceRequest")},
                  {"links", given({{"self", typed("string")},
                                   {"frames", typed("string", "the ZIP of its images")},
                                   {"video", typed("string")},
                                   {"report_html", typed("string")}})}});
}

json sequence_schema() {
    json schema = sequence_summary_schema();
    schema["properties"]["frames"] = list_of(given({{"frame", count()},
                                                    {"time", typed("number", "s: its moment")},
                                                    {"id", typed("string", "of its job")},
                                                    {"seed", in_range(typed("integer"), 0, UINT64_MAX)},
                                                    {"state", state()},
                                                    {"progress", in_range(typed("number"), 0, 1)},
                                                    {"seconds", typed("number", "of rendering")}}));
    schema["required"].push_back("frames");
    return schema;
}

/// Figures of errors by frame, which may be below 0.
json error_properties() {
    const json figure =
        or_null(given({{"value", typed("number")},
                       {"interval", interval_of("[least, greatest] at 90 %, by the references' noise")}}));
    return {{"relative_mse", figure},
            {"flicker", with_text(figure,
                                  "the mean of (change of the image - change of the truth)^2, divided as "
                                  "relative_mse is; null of a first frame, as the two below")},
            {"lag", with_text(figure,
                              "the mean of error times change of the truth: below 0 where the image shows what "
                              "was; divided likewise")},
            {"change", with_text(figure, "the mean square of the change of the truth, divided likewise")}};
}

json sequence_errors_schema() {
    json frame = error_properties();
    frame["frame"] = count();
    frame["time"] = typed("number", "s: its moment");
    return given({{"sequence", typed("string")},
                  {"references", list_of(typed("string"))},
                  {"layer", typed("string")},
                  {"frames", with_text(list_of(given(std::move(frame))), "that have succeeded in all three")},
                  {"mean", with_text(given(error_properties()), "over these")},
                  {"frames_late", nullable("number",
                                           "by how many frames the image comes late: -lag / change of the "
                                           "means; null where nothing changes for certain")}});
}

}  // namespace

json sequence_schemas(const json& job_request) {
    return {{"SequenceRequest", sequence_request_schema(job_request)},
            {"Sequence", sequence_schema()},
            {"SequenceSummary", sequence_summary_schema()},
            {"SequencePage", page_of("SequenceSummary")},
            {"SequenceErrors", sequence_errors_schema()},
            {"SequenceEstimate", given({{"frames", count()},
                                        {"memory_bytes", count("that a frame will hold")},
                                        {"disk_bytes", count("that all frames will leave")},
                                        {"seconds", nullable("number", "of rendering all")},
                                        {"warning", nullable("string", "of seconds that cannot be kept")}})}};
}

}  // namespace photond::openapi
