#include "protocol/comparison.h"
#include "protocol/comparison_remarks.h"
#include "protocol/openapi_schemas.h"

namespace photond::openapi {
namespace {

json at_least_one(json list) {
    list["minItems"] = 1;
    return list;
}

json remarks_schemas() {
    const auto text = [](size_t most, const char* what) {
        json schema = typed("string");
        schema["minLength"] = 1;
        schema["maxLength"] = most;
        return with_text(or_null(std::move(schema)), what);
    };
    return {{"title", text(kMaxTitleBytes, "what it is called")}, {"notes", text(kMaxNotesBytes, "several lines")}};
}

json request_schema(const json& job_request) {
    const json& of_job = job_request.at("properties");
    json label = typed("string", "the method's name where there is none");
    label["minLength"] = 1;
    label["maxLength"] = 256;
    json values = at_least_one(list_of({{"not", {{"type", "null"}}}}));
    values["uniqueItems"] = true;
    const json entry =
        taken({{"label", or_null(label)},
               {"method", schema_ref("JobMethod")},
               {"sweep", with_text(or_null(map_of(values)), "parameters and their values; every combination is run")}},
              {"method"});
    json seeds = at_least_one(list_of(in_range(typed("integer"), 0, UINT64_MAX)));
    seeds["uniqueItems"] = true;
    seeds["maxItems"] = kMaxComparisonJobs;
    json metrics = of_job.at("metrics").at("anyOf").at(0);
    metrics = at_least_one(std::move(metrics));
    metrics["maxItems"] = 16;
    json entries = at_least_one(list_of(entry));
    entries["maxItems"] = kMaxComparisonJobs;
    json properties{{"entries", with_text(entries, "rows of the tables; their labels differ")},
                    {"seeds", or_null(seeds)},
                    {"metrics", with_text(or_null(metrics), "of the tables; the first decides the Pareto front")}};
    for (const char* key : {"scene", "camera", "image", "reference", "stop", "layers", "priority", "labels",
                            "environment", "glass", "animation", "time", "shutter", "quiet_machine"})
        properties[key] = of_job.at(key);
    properties.update(remarks_schemas());
    return taken(std::move(properties), {"scene", "image", "entries", "stop"});
}

/// A mean over seeds and its 95 % interval; null where not every seed has a value.
json mean(const char* name, json more) {
    more[name] = nullable("number");
    more["low"] = nullable("number");
    more["high"] = nullable("number");
    return given(std::move(more));
}

/// Where the references' noise lets a figure lie.
json noise_interval() {
    return or_null(interval_of("[least, greatest] at 90 %, by the noise of two references; null: one reference"));
}

/// Of one metric, what a row's error is made of.
json bias_schema() {
    return given(
        {{"squared_bias", typed("number")},
         {"low", typed("number", "90 %, from the seeds and the references' noise")},
         {"high", typed("number")},
         {"variance", typed("number", "of one film")},
         {"variance_low", nullable("number", "90 %, from the seeds; null for two")},
         {"variance_high", nullable("number")},
         {"floor", typed("boolean",
                         "parameters are fixed: more passes will not go below squared_bias; else it is that at "
                         "these passes")},
         {"text", typed("string", "the same as a sentence")}});
}

json row_schema() {
    const json spread = or_null(given({{"min", typed("number")}, {"max", typed("number")}}));
    const json counts = or_null(given({{"min", count()}, {"max", count()}}));
    return given(
        {{"label", typed("string")},
         {"parameters", typed("object", "those the sweep gave")},
         {"jobs", list_of(typed("string"))},
         {"seeds", count()},
         {"succeeded", count("seeds whose job has succeeded")},
         {"disturbed", count("of these, that lost processor time to other processes")},
         {"passes", counts},
         {"photons", counts},
         {"seconds", spread},
         {"error",
          with_text(map_of(mean("value", {{"reference", nullable("number", "the reference's own noise")},
                                          {"near_reference", typed("boolean",
                                                                   "within 3 times of that; with an interval: not "
                                                                   "known to a third of itself")},
                                          {"interval", noise_interval()}})),
                    "the mean over the seeds of an error with an interval, which may be below 0; of the "
                    "logarithms of others. The root of what is below 0 counts as 0")},
         {"time_to_error",
          map_of(list_of(mean("seconds", {{"error", typed("number")},
                                          {"reached", count("seeds")},
                                          {"at_most", typed("boolean", "the time is an upper bound")},
                                          {"earliest", nullable("number", "what the references' noise leaves open")},
                                          {"latest", nullable("number")}})))},
         {"error_at_time",
          map_of(list_of(mean(
              "error", {{"seconds", typed("number")}, {"reached", count("seeds")}, {"interval", noise_interval()}})))},
         {"peak_bytes", nullable("integer", "the largest of the seeds', beside the idle process")},
         {"efficiency", nullable("number", "1 / the mean over the seeds of mse x seconds; null: not above 0")},
         {"pareto", typed("boolean", "at some time no other row is better, by upper ends")},
         {"bias",
          with_text(
              or_null(map_of(bias_schema())),
              "by quadratic metric, {} where none is; null for one seed, while jobs run, without two references")},
         {"left_out", left_out_list("as in its jobs' statistics; null before there are any")},
         {"mark", nullable("string",
                           "of a row that has light which the reference lacks, and which counts as its error: what "
                           "that is")}});
}

json summary_schema() {
    json states = json::object();
    for (const char* name : kStates) states[name] = count();
    return given({{"id", typed("string")},
                  {"state", state()},
                  {"progress", in_range(typed("number"), 0, 1)},
                  {"created", time_or_none()},
                  {"started", time_or_none()},
                  {"finished", time_or_none()},
                  {"job_states", with_text(given(std::move(states)),
                                           "of what was planned, whatever job of its runs "
                                           "counts")},
                  {"repeats", count("jobs made again because they were disturbed")},
                  {"overhead_seconds",
                   nullable("number", "from the first start to the last end on each device, less the jobs' clocks")},
                  {"request", schema_ref("ComparisonRequest")},
                  {"links", given({{"self", typed("string")},
                                   {"report_json", typed("string")},
                                   {"report_csv", typed("string")},
                                   {"report_html", typed("string")}})}});
}

json verdict_schema() {
    return given({{"metric", typed("string")},
                  {"error", typed("number", "the smallest level of which it is true")},
                  {"easiest", typed("number", "the largest")},
                  {"close", typed("boolean", "who is first cannot be told")},
                  {"factor", nullable("number", "the second's time over the first's")},
                  {"arrived", with_text(list_of(given({{"row", count()}, {"seconds", typed("number")}})),
                                        "rows of the table that reach it with every seed, quickest first")},
                  {"missing", with_text(list_of(count()), "rows that do not")},
                  {"disturbed", with_text(list_of(count()), "rows with jobs that lost processor time to others")},
                  {"text", typed("string", "the same as a sentence")}});
}

json headline_schema() {
    const json row = nullable("integer", "the first to reach them; null: too close to call");
    return given(
        {{"metric", typed("string")},
         {"text", typed("string", "the sentence: who is first, where that changes and where it is too close to call")},
         {"row", nullable("integer",
                          "of the table, which the sentence is about: the only one that is first anywhere, else the "
                          "first at the smallest error; null: nobody there")},
         {"best", typed("boolean",
                        "row is first at the smallest error, no other row is first anywhere, and none is clearly "
                        "sooner at any error")},
         {"verdict", count("the one of verdicts to show with it")},
         {"stretches", with_text(list_of(given({{"row", row},
                                                {"easiest", typed("number", "the largest level of which it is true")},
                                                {"error", typed("number", "the smallest")}})),
                                 "what the sentence is made of, by falling error")}});
}

json comparison_schema() {
    json schema = summary_schema();
    const auto add = [&schema](const char* key, json member) {
        schema["properties"][key] = std::move(member);
        schema["required"].push_back(key);
    };
    const json warning = nullable("string", "what it lost of its processor time, as in its statistics");
    const json run = given({{"id", typed("string")}, {"state", state()}, {"warning", warning}});
    add("jobs", list_of(given({{"id", typed("string")},
                               {"label", typed("string")},
                               {"parameters", typed("object")},
                               {"seed", count()},
                               {"state", state()},
                               {"passes_done", count()},
                               {"seconds", typed("number")},
                               {"warning", warning},
                               {"runs", with_text(list_of(run),
                                                  "the job that was planned and its repeats; the first "
                                                  "undisturbed one counts, else the least disturbed")}})));
    add("warnings", with_text(list_of(typed("string")), "which jobs were disturbed, and what became of that"));
    add("table", list_of(row_schema()));
    add("verdicts", with_text(list_of(verdict_schema()), "who is first, for each metric by falling error"));
    add("headlines",
        with_text(list_of(headline_schema()), "what verdicts come to, for each metric that has one: one sentence"));
    add("reference", or_null(given({{"job", nullable("string", "the first of two films")},
                                    {"jobs", with_text(or_null(list_of(typed("string"))), "as a job's reference_jobs")},
                                    {"form", typed("string", "as in a job's statistics")},
                                    {"image", nullable("string")},
                                    {"state", {{"type", {"string", "null"}}}},
                                    {"error", with_text(or_null(map_of(typed("number"))), "its own noise")},
                                    {"left_out", left_out_list("by it; null of an image")},
                                    {"warnings", list_of(typed("string"))}})));
    return schema;
}

json estimate_schema() {
    const json seconds = nullable("number", "of all its seeds; null where it cannot be told");
    return given(
        {{"jobs", count("its reference not among them")},
         {"memory_bytes", count("what the largest job will hold, the reference's among them")},
         {"seconds", nullable("number",
                              "of rendering once the reference is there: on each device one job after another, on all "
                              "at the same time; null where it cannot be told")},
         {"reference_seconds", nullable("number", "of the reference that is still to be made; 0: none is")},
         {"warnings", with_text(list_of(typed("string")),
                                "of seconds that cannot be kept, and of entries with light that the reference lacks")},
         {"entries", with_text(list_of(given({{"label", typed("string")},
                                              {"parameters", typed("object", "those the sweep gave")},
                                              {"memory_bytes", count()},
                                              {"seconds", seconds},
                                              {"left_out", left_out_list("as of a job's dry run")},
                                              {"mark", nullable("string", "as the row's will be")}})),
                               "rows of the table to come, in its order")}});
}

/// Differences and standard errors are over sqrt(r^2 + 0.01 m^2): r the block's mean luminance in the reference, m the
/// image's.
json bias_map_schema() {
    const json block =
        given({{"difference", typed("number", "of the mean luminance over the seeds, over the block's")},
               {"standard_error", typed("number", "by the seeds and the reference's noise")},
               {"degrees", typed("number", "of freedom, by Satterthwaite: stated only, p is not by them")},
               {"p", in_range(typed("number", "of as large a difference by chance"), 0, 1)},
               {"found", typed("boolean", "it differs, at that level for the image as a whole")}});
    return given({{"row", count("of the table")},
                  {"label", typed("string")},
                  {"layer", typed("string")},
                  {"block", count("pixels a side")},
                  {"width", count("in blocks; those at the right and at the bottom may be cut")},
                  {"height", count()},
                  {"image_width", count("in pixels")},
                  {"image_height", count()},
                  {"seeds", count()},
                  {"level", typed("number", "chance of finding any block of an image without bias")},
                  {"blocks", with_text(list_of(block), "row by row from the top")},
                  {"tested", count("blocks that have a finite pixel")},
                  {"found", count("blocks that differ")},
                  {"share_below_level", typed("number", "of blocks whose own p is below the level")},
                  {"detectable", typed("number", "the bias that half of the blocks would have shown, as difference")},
                  {"heavy_tailed", typed("boolean", "few pixels carry most of the noise: p is not to be relied on")},
                  {"heavy_blocks", count("in which they do")},
                  {"text", typed("string", "the same as a sentence")}});
}

json report_schema(const json& comparison) {
    json schema = comparison;
    schema["properties"]["curves"] =
        list_of(given({{"job", typed("string")},
                       {"points", list_of(given({{"seconds", typed("number")},
                                                 {"passes", count()},
                                                 {"photons", nullable("integer")},
                                                 {"metrics", map_of(nullable("number"))},
                                                 {"intervals", map_of(noise_interval())}}))}}));
    schema["required"].push_back("curves");
    json& row = schema["properties"]["table"]["items"];
    row["properties"]["mean_curve"] = with_text(map_of(list_of(mean("error", {{"seconds", typed("number")},
                                                                              {"min", typed("number", "of the seeds")},
                                                                              {"max", typed("number", "of the seeds")},
                                                                              {"interval", noise_interval()}}))),
                                                "over the seeds where all their curves overlap, by metric");
    row["required"].push_back("mean_curve");
    return schema;
}

}  // namespace

json comparison_schemas(const json& job_request) {
    const json comparison = comparison_schema();
    return {{"ComparisonRequest", request_schema(job_request)},
            {"ComparisonRemarks", taken(remarks_schemas(), {})},
            {"Comparison", comparison},
            {"ComparisonSummary", summary_schema()},
            {"ComparisonEstimate", estimate_schema()},
            {"ComparisonPage", page_of("ComparisonSummary")},
            {"ComparisonReport", report_schema(comparison)},
            {"BiasMap", bias_map_schema()}};
}

}  // namespace photond::openapi
