#include "protocol/openapi.h"

#include "protocol/error.h"
#include "protocol/message_parts.h"
#include "protocol/openapi_operations.h"
#include "protocol/openapi_schemas.h"
#include "protocol/problem.h"

namespace photond {
namespace {

using nlohmann::json;
using namespace openapi;

json vector3() {
    return {
        {"type", "array"}, {"items", in_range(typed("number", "m"), -1e12, 1e12)}, {"minItems", 3}, {"maxItems", 3}};
}

json problem_schema() {
    json codes = json::array();
    for (const ErrorKind& kind : kErrorKinds) codes.push_back(kind.name);
    return given({{"type", typed("string", "urn:photond:problem:CODE")},
                  {"title", typed("string")},
                  {"status", in_range(typed("integer"), 400, 599)},
                  {"code", {{"type", "string"}, {"enum", codes}}},
                  {"detail", typed("string", "what went wrong, with the value and the limit")},
                  {"instance", nullable("string", "the path asked for")},
                  {"errors", list_of(given({{"code", {{"type", "string"}, {"enum", codes}}},
                                            {"pointer", typed("string", "JSON pointer into the body (or the glTF)")},
                                            {"detail", typed("string")}}))}});
}

/// "relative_mse" or "indirect:relative_mse".
json metric_name(const std::vector<std::string>& metrics, const std::vector<std::string>& layers) {
    const auto alternatives = [](const std::vector<std::string>& words) {
        std::string text;
        for (const std::string& word : words) text += (text.empty() ? "" : "|") + word;
        return text;
    };
    std::vector<std::string> measured = layers;
    measured.emplace_back("beauty");
    return {{"type", "string"},
            {"pattern", "^((" + alternatives(measured) + "):)?(" + alternatives(metrics) + ")$"},
            {"examples", metrics},  // what clients offer to complete
            {"description", "a metric of the beauty, or LAYER:METRIC"}};
}

json stop_schema(const ApiVocabulary& vocabulary) {
    const json target = taken({{"metric", metric_name(vocabulary.metrics, vocabulary.radiance_layers)},
                               {"value", in_range(typed("number", "met when the metric is at most this"), 0, 1e30)}},
                              {"metric", "value"});
    json stop = taken({{"seconds", or_null(in_range(typed("number", "s"), 1e-3, 1e9))},
                       {"passes", or_null(in_range(typed("integer"), 1, 1'000'000'000))},
                       {"target", or_null(target)}},
                      {});
    const auto has = [](const char* key, const char* type) {
        return json{{"properties", {{key, {{"type", type}}}}}, {"required", json::array({key})}};
    };
    stop["anyOf"] = {has("seconds", "number"), has("passes", "number"), has("target", "object")};
    return with_text(stop, "the first one met ends the job; counted from the film's first pass");
}

json job_method_schema(const ApiVocabulary& vocabulary) {
    json methods = json::array();
    for (const ApiVocabulary::Method& method : vocabulary.methods)
        methods.push_back(taken({{"name", {{"const", method.name}}},
                                 {"device", {{"type", {"string", "null"}}, {"pattern", "^(cpu|gpu|gpu:[0-9]{1,3})$"}}},
                                 {"parameters", or_null(schema_ref("Parameters." + method.name))}},
                                {"name"}));
    return {{"oneOf", methods}};
}

json reference_schema() {
    const json named{{"type", "string"}, {"pattern", "^(job|image):."}, {"maxLength", 256}};
    const json made =
        with_text(taken({{"method", schema_ref("JobMethod")}, {"stop", schema_ref("Stop")}}, {"method", "stop"}),
                  "rendered from the job's own scene and view and kept, as two films of different seeds, each of half "
                  "of the passes (rounded up) or seconds, or to twice the estimated error: so that errors are measured "
                  "without their noise");
    return {{"anyOf", {named, made, {{"type", "null"}}}}};
}

json job_request_schema(const ApiVocabulary& vocabulary) {
    const json look_at = taken({{"eye", vector3()},
                                {"target", vector3()},
                                {"up", or_null(vector3())},
                                {"yfov", or_null(in_range(typed("number", "radians"), 1e-4, 3.14159))}},
                               {"eye", "target"});
    json name = typed("string");
    name["minLength"] = 1;
    name["maxLength"] = 256;
    const json camera = taken({{"name", or_null(name)},
                               {"look_at", or_null(look_at)},
                               {"aperture", or_null(in_range(typed("number", "lens radius, m"), 0, 1e6))},
                               {"focus_distance", or_null(in_range(typed("number", "m"), 1e-6, 1e12))}},
                              {});
    const std::string size_text =
        "width times height is at most " + std::to_string(vocabulary.max_pixels) + " pixels (photond --max-pixels)";
    const json image = with_text(taken({{"width", in_range(typed("integer"), 1, vocabulary.max_width)},
                                        {"height", in_range(typed("integer"), 1, vocabulary.max_height)},
                                        {"filter", or_null(one_of_words({"box", "gaussian", "blackman_harris"}))}},
                                       {"width", "height"}),
                                 size_text.c_str());
    json layers = list_of(one_of_words(vocabulary.layers));
    layers["uniqueItems"] = true;
    json metrics = list_of(metric_name(vocabulary.metrics, vocabulary.radiance_layers));
    metrics["uniqueItems"] = true;
    // Methods that cannot fill every layer narrow the list.
    json narrowed = json::array();
    for (const ApiVocabulary::Method& method : vocabulary.methods) {
        if (method.layers.size() == vocabulary.layers.size()) continue;
        const json by_this{{"properties", {{"method", {{"properties", {{"name", {{"const", method.name}}}}}}}}}};
        narrowed.push_back(
            {{"if", by_this}, {"then", {{"properties", {{"layers", {{"items", one_of_words(method.layers)}}}}}}}});
    }
    const json environment = taken({{"image", {{"type", "string"}, {"pattern", "^image:."}, {"maxLength", 256}}},
                                    {"scale", or_null(in_range(typed("number"), 0, 1e12))},
                                    {"rotation", or_null(in_range(typed("number", "radians about +Y"), -1e4, 1e4))}},
                                   {"image"});
    json labels = map_of({{"type", "string"}, {"maxLength", 256}});
    labels["maxProperties"] = 64;
    labels["propertyNames"] = {{"pattern", "^[^=]{1,64}$"}};
    json request = taken(
        {{"scene", name},
         {"camera", or_null(camera)},
         {"image", image},
         {"method", schema_ref("JobMethod")},
         {"stop", schema_ref("Stop")},
         {"first_pass", or_null(in_range(typed("integer", "a part of a larger job, to be merged"), 0, 1'000'000'000))},
         {"seed", or_null(in_range(typed("integer"), 0, UINT64_MAX))},
         {"layers", or_null(layers)},
         {"reference", reference_schema()},
         {"metrics", with_text(or_null(metrics), "measured besides those that cost little")},
         {"priority", or_null(in_range(typed("integer", "higher first"), -100, 100))},
         {"quiet_machine", or_null(in_range(typed("number",
                                                  "s: how long the job may wait for a machine on which nothing else "
                                                  "runs; then it begins all the same"),
                                            0, 1e9))},
         {"labels", or_null(labels)},
         {"environment", or_null(environment)},
         {"glass", with_text(or_null(one_of_words({"as_stored", "solid"})),
                             "solid: what transmits light and is closed, up to rounding, refracts as a solid; the log "
                             "warns of what is not closed, with the number of its open edges")},
         {"animation",
          with_text(or_null({{"anyOf", json::array({typed("string"), in_range(typed("integer"), 0, 65535)})}}),
                    "name or index of one of the scene's animations; without one the scene is at rest, or, "
                    "where a time is given, in its first")},
         {"time", or_null(in_range(typed("number",
                                         "s: the moment of the animation that is rendered; before its first "
                                         "key and after its last one nothing moves"),
                                   -1e9, 1e9))},
         {"shutter", or_null(in_range(typed("number",
                                            "s: passes show moments spread over this long from the time on, each "
                                            "pass one; of methods whose passes stand alone"),
                                      0, 1e9))}},
        {"scene", "image", "method", "stop"});
    if (!narrowed.empty()) request["allOf"] = narrowed;
    return request;
}

json extension_schema() { return taken({{"stop", schema_ref("Stop")}}, {"stop"}); }

json job_change_schema() {
    return taken({{"priority", in_range(typed("integer", "higher first"), -100, 100)}}, {"priority"});
}

json merge_request_schema() {
    json jobs = list_of(typed("string"));
    jobs["minItems"] = 1;
    jobs["maxItems"] = 1000;
    jobs["uniqueItems"] = true;
    return taken({{"jobs", with_text(jobs, "parts of one image, each with passes of its own")}}, {"jobs"});
}

json measurement_request_schema(const ApiVocabulary& vocabulary) {
    const json source = job_or_image();
    json metrics = list_of(metric_name(vocabulary.image_metrics, vocabulary.radiance_layers));
    metrics["minItems"] = 1;
    metrics["maxItems"] = 256;
    metrics["uniqueItems"] = true;
    json two = list_of(source);
    two["minItems"] = two["maxItems"] = 2;
    two["uniqueItems"] = true;
    const json pair =
        with_text(two,
                  "instead of reference: two images of one truth, of different seeds, so that their noise "
                  "has no part in mse, rmse and relative_mse; all else is against their mean");
    return taken({{"image", source},
                  {"reference", with_text(or_null(source), "this or references")},
                  {"references", or_null(pair)},
                  {"metrics", or_null(metrics)}},
                 {"image"});
}

/// A metric's value: one number, one a channel, percentiles by name; null where its definition gives none.
json metric_values() { return map_of({{"type", {"number", "array", "object", "null"}}}); }

json measurement_schema() {
    json interval = list_of(typed("number"));
    interval["minItems"] = interval["maxItems"] = 2;
    return given({{"metrics", metric_values()},
                  {"intervals", with_text(or_null(map_of(or_null(interval))),
                                          "of what two references were measured by: with 90 % confidence between")},
                  {"reference_error", with_text(or_null(metric_values()), "what the reference's own noise explains")},
                  {"notes", list_of(typed("string"))}});
}

json hard_cases_schema() {
    const json settings = typed("object", "parameters with the words they are set to");
    return given({{"variants", with_text(list_of(given({{"label", typed("string")}, {"parameters", settings}})),
                                         "settings with a column of their own; none: the method as it is by default")},
                  {"limits", with_text(list_of(given({{"parameters", settings},
                                                      {"row", typed("string", "part of the case's row")},
                                                      {"text", typed("string")}})),
                                       "why the method misses an answer by its nature; the first that fits")}});
}

json method_schema() {
    return given(
        {{"name", typed("string")},
         {"title", typed("string")},
         {"line", typed("string", "what it does, where it is good and where it is not")},
         {"family", typed("string")},
         {"devices", list_of(one_of_words({"cpu", "gpu"}))},
         {"sources", list_of(typed("string"))},
         {"mergeable", typed("boolean", "with the default parameters")},
         {"deterministic", map_of(nullable("boolean"))},
         {"layers", with_text(list_of(typed("string")), "on request, those it can fill")},
         {"artefacts", list_of(given({{"name", typed("string", "a file beside the image: /v1/jobs/ID/NAME")},
                                      {"media_type", typed("string")},
                                      {"parameter", typed("string", "the flag that asks for it")},
                                      {"description", typed("string")}}))},
         {"hard_cases", hard_cases_schema()},
         {"parameters", typed("object",
                              "a JSON Schema (2020-12); x-unit, x-order, x-group and x-groups (titles of what a "
                              "form shows together) beside the standard words")}});
}

json layer_schema() {
    return given(
        {{"name", typed("string")},
         {"channels", typed("string", "suffixes of the EXR's channels, a letter each")},
         {"always", typed("boolean", "every image has it; the others are asked for")},
         {"measured", typed("boolean", "it is a part of the light: errors of it can be measured")},
         {"preview", with_text(or_null(one_of_words({"light", "heat_map", "directions", "dots", "scale", "signed"})),
                               "how /preview.png shows it; null: not at all, it is numbers to look at closely")},
         {"exposure", typed("boolean", "exposure and tone curve change its preview")},
         {"unit", typed("string", "SI; empty for plain numbers")},
         {"description", typed("string")}});
}

json metric_schema() {
    return given(
        {{"name", typed("string")},
         {"title", typed("string", "for tables")},
         {"values", typed("integer", "1: a number, which may be a target; 3: one a channel; 4: percentiles")},
         {"needs_reference", typed("boolean", "else it is estimated from the passes")},
         {"on_request", typed("boolean", "measured only where a job's `metrics` name it")},
         {"slope", with_text(nullable("number"),
                             "where the error is nothing but independent noise it falls with the passes to this "
                             "power; null: no law says how")},
         {"description", typed("string", "how it is defined")},
         {"line", with_text(nullable("string"), "what the usual ones are, for who does not know them")}});
}

json device_schema() {
    return given({{"id", {{"type", "string"}, {"pattern", "^(cpu|gpu:[0-9]+)$"}}},
                  {"kind", one_of_words({"cpu", "gpu"})},
                  {"name", nullable("string")},
                  {"driver", nullable("string")},
                  {"memory_bytes", nullable("integer")},
                  {"software", nullable("boolean")},
                  {"state", with_text(one_of_words({"ready", "busy", "failed"}),
                                      "failed: its worker does not stay up, or it lacks something")},
                  {"served", typed("boolean", "jobs can be rendered on it: the daemon was given it by --devices")},
                  {"lacks", with_text(list_of(typed("string")), "what photond needs and the device has not")},
                  {"limits", or_null(given({{"storage_buffer_bytes", count()},
                                            {"allocation_bytes", count()},
                                            {"storage_buffers", count()},
                                            {"push_constant_bytes", count()},
                                            {"shared_memory_bytes", count()},
                                            {"workgroup_size", count()},
                                            {"workgroups", list_of(count())},
                                            {"subgroup_size", count()},
                                            {"image_side", count()},
                                            {"timestamp_seconds", typed("number", "of a tick; 0: none")}}))}});
}

/// CoreUse of worker_messages.h.
json cores_schema() {
    return given({{"processor_seconds", typed("number", "of all threads of the job")},
                  {"run_delay_seconds", nullable("number", "its threads were ready to run and had no processor")},
                  {"host_busy_outside_seconds", nullable("number", "of processors, in other processes")},
                  {"host_steal_seconds", nullable("number", "of processors, taken by the host's own host")},
                  {"pressure_seconds", nullable("number", "in which some thread of the host had to wait")},
                  {"lost_seconds", nullable("number",
                                            "of processors, to other processes: the smaller of waiting and "
                                            "what ran outside")},
                  {"share", in_range(nullable("number", "of the processor time that it wanted"), 0, 1)},
                  {"clock_lost_seconds", nullable("number", "by which the job's clock is too long, at most")}});
}

json statistics_schema() {
    const json bytes = nullable("integer", "bytes");
    json pass_range = list_of(count());
    pass_range["minItems"] = pass_range["maxItems"] = 2;
    const json later{
        {"warnings", with_text(list_of(typed("string")), "of a picture that is likely not what was wanted: all black")},
        {"left_out", left_out_list("kinds of path that its method, with its parameters, leaves out in this scene")},
        {"mergeable", nullable("boolean",
                               "whether its passes stand alone, so that its film can be merged with others; "
                               "null where the method is not known")},
        {"least_glossy_alpha", nullable("number", "GGX, of the scene's narrowest rough specular lobe; null: none")},
        {"error_interval", with_text(or_null(map_of(interval_of("at reference.confidence"))),
                                     "where the noise of a reference of two films lets the errors lie that have one")}};
    return with_later(
        given(
            {{"stages", list_of(given({{"name", typed("string")},
                                       {"wall_seconds", nullable("number")},
                                       {"cpu_seconds", nullable("number")},
                                       {"gpu_seconds", nullable("number")}}))},
             {"counts",
              with_later(
                  given({{"rays", map_of(count())},
                         {"photons_emitted", nullable("integer")},
                         {"photons_stored", nullable("integer")},
                         {"splats", nullable("integer")},
                         {"splat_contributions", nullable("integer")},
                         {"vpls", nullable("integer")},
                         {"voxels", nullable("integer")},
                         {"passes", count()}}),
                  {{"photon_rays_saved",
                    with_text(count(), "that photons need not trace, as they share where light first arrives")},
                   {"vpls_kept", with_text(count(), "light paths of virtual lights that came from the frame before")},
                   {"vpls_new", with_text(count(), "those beside them, where frames hand lights on")},
                   {"cache_hits",
                    with_text(count(), "vertices at which a cache of radiance was asked and knew enough")},
                   {"cache_misses",
                    with_text(count(), "... and did not know enough: the path went on as if there were none")},
                   {"cache_refused", with_text(count(), "samples for which the cache had no room")},
                   {"vpls_offered",
                    with_text(count(), "light paths that were decided on by what they bring to the picture")},
                   {"vpls_accepted", with_text(count(), "... and those that were taken")},
                   {"photons_by_bounce", with_text(or_null(list_of(count())),
                                                   "stored after 1, 2 ... scatterings, the last: or more; null "
                                                   "where the method does not tell")}})},
             {"rates", map_of(nullable("number"))},
             {"memory", given({{"structures", map_of(count())},
                               {"accounted_bytes", bytes},
                               {"baseline_resident_bytes", bytes},
                               {"peak_resident_bytes", bytes},
                               {"device_structures", with_text(or_null(map_of(count())), "of a GPU's memory")},
                               {"peak_device_bytes", bytes}})},
             {"needs", or_null(typed("object"))},
             {"skipped",
              list_of(given({{"what", typed("string")}, {"why", typed("string")}, {"bytes_saved", count()}}))},
             {"device", given({{"id", typed("string")},
                               {"name", nullable("string")},
                               {"driver", nullable("string")},
                               {"software", nullable("boolean")}})},
             {"version", typed("string")},
             {"host_cores", nullable("integer")},
             {"threads", nullable("integer")},
             {"seed", count()},
             {"clock", with_text(or_null(given({{"asked_seconds", nullable("number", "the job's stop")},
                                                {"overshoot_seconds", nullable("number", "taken beyond that")},
                                                {"kept", nullable("boolean", "within 0.5 s and 5 %")},
                                                {"begin_seconds", typed("number", "before the first pass")},
                                                {"seconds_per_pass", nullable("number", "the mean of its passes")},
                                                {"passes_cut_off", count("not done in time, so thrown away")},
                                                {"cut_off_seconds", typed("number", "which that took")}})),
                                 "of the last attempt; the first pass is finished whatever was asked")},
             {"job_hash", nullable("string")},
             {"pixel_hash", nullable("string")},
             {"nan_count", count()},
             {"infinity_count", count()},
             {"device_shared", nullable("boolean", "another job ran meanwhile on the same cores")},
             {"host_shared", nullable("boolean", "another job ran meanwhile, on whatever device")},
             {"cores", with_text(or_null(cores_schema()),
                                 "of the host, while the job's clock ran; null of what the kernel "
                                 "does not say and of merged films")},
             {"shared",
              with_text(or_null(given({{"share", typed("number", "of the processor time that it wanted, which it had")},
                                       {"lost_seconds", typed("number", "of processors, to other processes")},
                                       {"clock_seconds", typed("number", "by which its clock is too long, at most")},
                                       {"to", with_text(list_of(given({{"who", typed("string",
                                                                                     "helper, photond, job J12, "
                                                                                     "worker gpu:0 or others")},
                                                                       {"seconds", typed("number")}})),
                                                        "the greatest first")},
                                       {"warning", typed("string", "the same as a sentence")}})),
                        "where other processes took more than 2 % of the processor time that the job wanted")},
             {"pass_ranges", with_text(list_of(pass_range), "[first, end) of each run of passes")},
             {"resumed_passes", count("rendered by earlier attempts")},
             {"settings_hash", nullable("string", "of all that decides a pass's pixels")},
             {"error",
              with_text(or_null(metric_values()),
                        "against the reference; bias_standard_error: of the bias by channel, from the spread "
                        "between passes of the image's mean (an upper figure where passes make up for each other, "
                        "as those of path tracing do; null where reference.notes says why)")},
             {"reference_error", with_text(or_null(metric_values()),
                                           "what the reference's own noise explains of it; of "
                                           "errors with an interval: would explain")},
             {"reference",
              or_null(with_later(
                  given({{"source", {{"type", {"string", "object", "null"}}}},
                         {"passes", nullable("integer", "of two films in all")},
                         {"flip_version", nullable("string")},
                         {"warnings", list_of(typed("string"))},
                         {"notes", list_of(typed("string"))}}),
                  {{"form", with_text(one_of_words({ReferenceSource::kTwoFilms, ReferenceSource::kFilm,
                                                    ReferenceSource::kImage}),
                                      "two_films: mse, rmse and relative_mse are measured without their noise; "
                                      "else, and in results without this member, with it")},
                   {"confidence", nullable("number", "of error_interval")},
                   {"denominators", with_text(map_of(one_of_words({"pixel", "neighbours"})),
                                              "of relative metrics against two films: what of the reference "
                                              "a value's square is divided by")}}))},
             {"estimate", with_text(or_null(given({{"estimated_relative_mse", nullable("number")},
                                                   {"standard_error_scale", nullable("number")},
                                                   {"confidence", nullable("number")},
                                                   {"within_confidence", nullable("number")}})),
                                    "what the passes alone tell of the beauty's error; null after one pass")}}),
        later);
}

json job_schema(const ApiVocabulary& vocabulary) {
    json links = given({{"self", typed("string")},
                        {"image", nullable("string")},
                        {"preview", nullable("string")},
                        {"statistics", nullable("string")},
                        {"curve", nullable("string")},
                        {"difference", nullable("string")},
                        {"flip", nullable("string")},
                        {"error_map", nullable("string")},
                        {"film", nullable("string")},
                        {"log", nullable("string")},
                        {"events", typed("string")}});
    for (const ApiVocabulary::Artefact& artefact : vocabulary.artefacts) {
        links["properties"][artefact_link(artefact.name)] = nullable("string");
        links["required"].push_back(artefact_link(artefact.name));
    }
    const json time{{"type", {"string", "null"}}, {"format", "date-time"}};
    json attempt = given({{"attempt", in_range(typed("integer"), 1, nullptr)},
                          {"device", nullable("string")},
                          {"started", time},
                          {"finished", time},
                          {"outcome", nullable("string")},
                          {"passes_done", count()},
                          {"reason", nullable("string")}});
    attempt["properties"]["device_shared"] = typed("boolean", "when it is over: as in statistics");
    attempt["properties"]["host_shared"] = typed("boolean", "likewise");
    const json curve_point = with_later(
        given({{"seconds", typed("number")},
               {"passes", count()},
               {"photons", nullable("integer")},
               {"metrics", or_null(map_of(nullable("number")))}}),
        {{"intervals", with_text(map_of(interval_of("at 90 %")), "of metrics against two films, by their noise")}});
    const json error_now = with_later(given({{"metric", typed("string")}, {"value", nullable("number")}}),
                                      {{"interval", or_null(interval_of("at 90 %, by the noise of two films"))}});
    return given({{"id", typed("string")},
                  {"role", one_of_words({"render", "reference", "merged", "frame"})},
                  {"comparison", nullable("string", "the comparison it belongs to")},
                  {"sequence", nullable("string", "the sequence that it is a frame of")},
                  {"reference_job", nullable("string", "the job it is measured against, the first of two films")},
                  {"reference_jobs", with_text(or_null(list_of(typed("string"))),
                                               "the job that was named, or the two that make its reference")},
                  {"state", one_of_words({"queued", "running", "succeeded", "failed", "cancelled"})},
                  {"progress", in_range(typed("number"), 0, 1)},
                  {"passes_done", count()},
                  {"seconds", typed("number")},
                  {"error_now", or_null(error_now)},
                  {"created", {{"type", "string"}, {"format", "date-time"}}},
                  {"started", time},
                  {"finished", time},
                  {"attempts", list_of(std::move(attempt))},
                  {"waiting_for", nullable("string", "while it is queued, in words: its turn, a quiet machine, a job")},
                  {"request", schema_ref("JobRequest")},
                  {"links", links},
                  {"statistics", nullable_ref("Statistics")},
                  {"failure", nullable_ref("Problem")},
                  {"curve", or_null(list_of(curve_point))}});
}

/// What a list shows of a job.
json job_summary_schema(const json& job) {
    json properties{{"scene", typed("string", "as the request names it")},
                    {"method", typed("string")},
                    {"device", typed("string")},
                    {"width", count()},
                    {"height", count()},
                    {"priority", in_range(typed("integer", "higher first"), -100, 100)},
                    {"labels", map_of(typed("string"))},
                    {"waiting_for", nullable("string", "while it is queued, in words")},
                    {"waits_for", nullable("string", "the job, its reference, that must be over before it begins")},
                    {"failure", nullable("string", "what went wrong")}};
    for (const char* key : {"id", "role", "comparison", "sequence", "state", "progress", "passes_done", "seconds",
                            "error_now", "created", "started", "finished"})
        properties[key] = job.at("properties").at(key);
    return given(std::move(properties));
}

json job_summary_page() {
    json page = page_of("JobSummary");
    page["properties"]["total"] = count("jobs that the filter lets through, on whatever page");
    page["required"].push_back("total");
    return page;
}

json store_schema() {
    return given(
        {{"id", typed("string", "given to it when it was made; its films carry it")},
         {"bytes", count("of the database")},
         {"recovered", typed("boolean", "false while a full disk keeps what was running from being recorded")},
         {"check", given({{"state", one_of_words({"waiting", "running", "ok", "damaged", "failed"})},
                          {"detail", nullable("string", "what is wrong, or is waited for")}})},
         {"quarantine", given({{"files", count("that a start could not tell; they are the operator's to look at")},
                               {"bytes", count()}})}});
}

json status_schema() {
    const json totals = with_text(
        given({{"jobs", given({{"succeeded", count()}, {"failed", count()}, {"cancelled", count()}})},
               {"passes", count("rendered, those of jobs that are running included")},
               {"pixels", count("of those passes: width times height of each")},
               {"render_seconds", typed("number", "on the jobs' clocks, those of jobs that are running included")},
               {"rays", map_of(count("traced by attempts that have ended and said so; what runs, was lost or failed "
                                     "is not known"))},
               {"photons", count("emitted, likewise")}}),
        "since the daemon started");
    const json file_access =
        with_text(or_null(given({{"by", one_of_words({"landlock", "mount_namespace", "none"})},
                                 {"version", nullable("integer", "Landlock's")}})),
                  "what bounds the files that the process may open to its own: null until it has said so");
    return given({{"version", typed("string")},
                  {"uptime_seconds", typed("number")},
                  {"ready", typed("boolean")},
                  {"queue", given({{"queued", count()}, {"running", count()}})},
                  {"workers", list_of(given({{"device", typed("string")},
                                             {"state", typed("string")},
                                             {"pid", nullable("integer")},
                                             {"job", nullable("string")},
                                             {"restarts", count()},
                                             {"resident_bytes", nullable("integer")},
                                             {"memory_limit_bytes", nullable("integer", "its jobs may hold")},
                                             {"device_name", nullable("string")},
                                             {"file_access", file_access}}))},
                  {"pictures", given({{"waiting", count("pictures to be drawn beside a job that renders")},
                                      {"pid", nullable("integer", "of the process that draws them")},
                                      {"restarts", count()},
                                      {"resident_bytes", count()},
                                      {"file_access", file_access}})},
                  {"helpers", list_of(given({{"name", one_of_words({"answers", "bulk"})},
                                             {"state", one_of_words({"ready", "busy", "failed"})},
                                             {"busy_seconds", nullable("number", "at the request under way")},
                                             {"pid", nullable("integer")},
                                             {"restarts", count()},
                                             {"resident_bytes", count()},
                                             {"file_access", file_access}}))},
                  {"store", store_schema()},
                  {"disk_free_bytes", nullable("integer")},
                  {"resident_bytes", nullable("integer", "of the daemon itself")},
                  {"event_clients", count("event streams open")},
                  {"totals", totals}});
}

json image_schema() {
    return given(
        {{"id", typed("string")},
         {"media_type", typed("string")},
         {"width", count()},
         {"height", count()},
         {"channels", count()},
         {"bytes", count()},
         {"layers",
          with_text(list_of(given({{"name", typed("string")}, {"channels", in_range(typed("integer"), 1, 3)}})),
                    "by the names of its channels: R, G, B or Y make the beauty, NAME.R/.G/.B, "
                    ".X/.Y/.Z, .Y or .Z the layer NAME")}});
}

json estimate_schema() {
    return given({{"memory_bytes", count("what the job will hold: film, scene, ray structure and the method's own")},
                  {"device_memory_bytes", nullable("integer", "likewise, of a GPU's memory; null on the CPU")},
                  {"seconds", nullable("number", "of rendering; null while the method has rendered nothing here")},
                  {"pass_seconds", nullable("number", "of one pass; likewise")},
                  {"left_out", left_out_list("kinds of path that the image will not have, as in statistics")},
                  {"warnings", with_text(list_of(typed("string")), "of seconds that cannot be kept")}});
}

}  // namespace

json openapi_document(const ApiVocabulary& vocabulary) {
    json schemas{
        {"Problem", problem_schema()},
        {"JobRequest", job_request_schema(vocabulary)},
        {"JobMethod", job_method_schema(vocabulary)},
        {"Stop", stop_schema(vocabulary)},
        {"Extension", extension_schema()},
        {"JobChange", job_change_schema()},
        {"MergeRequest", merge_request_schema()},
        {"MeasurementRequest", measurement_request_schema(vocabulary)},
        {"Measurement", measurement_schema()},
        {"Method", method_schema()},
        {"Layer", layer_schema()},
        {"Metric", metric_schema()},
        {"Device", device_schema()},
        {"Statistics", statistics_schema()},
        {"Job", job_schema(vocabulary)},
        {"JobSummary", job_summary_schema(job_schema(vocabulary))},
        {"Estimate", estimate_schema()},
        {"Status", status_schema()},
        {"Backup",
         given({{"id", typed("string")},
                {"created", typed("string")},
                {"store", typed("string", "the id of the store it is of")},
                {"bytes", count("of all files")},
                {"files", list_of(given({{"path", typed("string", "within a data folder")}, {"bytes", count()}}))}})},
        {"Image", image_schema()},
        {"Health", given({{"status", typed("string")}})},
        {"JobPage", page_of("Job")},
        {"JobSummaryPage", job_summary_page()},
        {"MethodPage", page_of("Method")},
        {"LayerPage", page_of("Layer")},
        {"MetricPage", page_of("Metric")},
        {"DevicePage", page_of("Device")}};
    schemas.update(scene_schemas());
    schemas.update(comparison_schemas(schemas["JobRequest"]));
    schemas.update(sequence_schemas(schemas["JobRequest"]));
    for (const ApiVocabulary::Method& method : vocabulary.methods)
        schemas["Parameters." + method.name] = method.parameters;
    return {{"openapi", "3.1.0"},
            {"jsonSchemaDialect", "https://json-schema.org/draft/2020-12/schema"},
            {"info",
             {{"title", "photond"},
              {"version", vocabulary.version},
              {"description",
               "Global-illumination renders as a service. Units are SI, spans seconds, sizes bytes, "
               "times RFC 3339 UTC; a field that does not apply is null, never absent. Any request may be "
               "answered 503 where too much is asked at once, or 429 where one client asks too fast or presents wrong "
               "tokens: Retry-After says when to ask again. A connection whose client ends its sending is taken for "
               "closed."},
              {"license", {{"name", "Apache-2.0"}, {"identifier", "Apache-2.0"}}}}},
            {"paths", openapi_paths(vocabulary)},
            {"components",
             {{"schemas", schemas}, {"securitySchemes", {{"token", {{"type", "http"}, {"scheme", "bearer"}}}}}}},
            {"security", {{{"token", json::array()}}, json::object()}}};
}

std::vector<std::string> openapi_operations(const json& document) {
    std::vector<std::string> names;
    for (const auto& [path, methods] : document.at("paths").items())
        for (const auto& [method, operation] : methods.items()) {
            std::string name;
            for (const char c : method) name += static_cast<char>(c - 'a' + 'A');
            names.push_back(name.append(" ").append(path));
        }
    return names;
}

}  // namespace photond
