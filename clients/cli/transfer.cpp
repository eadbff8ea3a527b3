#include "clients/cli/transfer.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <iostream>
#include <memory>
#include <sstream>

#include "clients/cli/json_member.h"
#include "clients/cli/output_file.h"
#include "clients/cli/units.h"

namespace photond::cli {

using nlohmann::json;

namespace {

std::string decimal(double value) {
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text << value;
    return text.str();
}

/// What is saved under one name each, as a member, its place below the job and what its file is to end in.
struct NamedOutput {
    std::string JobOutputs::*file;
    const char* resource;
    const char* suffix;  // empty: any
};
constexpr std::array<NamedOutput, 8> kNamedOutputs{{{&JobOutputs::statistics, "/statistics.json", ""},
                                                    {&JobOutputs::log, "/log.txt", ""},
                                                    {&JobOutputs::photon_map, "/photon_map.glb", ".glb"},
                                                    {&JobOutputs::error_curve, "/curve.csv", ""},
                                                    {&JobOutputs::difference, "/difference.exr", ".exr"},
                                                    {&JobOutputs::flip, "/flip.png", ".png"},
                                                    {&JobOutputs::error_map, "/error.png", ".png"},
                                                    {&JobOutputs::film, "/film", ""}}};

/// All names that something is to be saved as, with the suffix that each needs.
std::vector<std::pair<std::string, std::string>> names_and_suffixes(const JobOutputs& outputs) {
    std::vector<std::pair<std::string, std::string>> names;
    for (const std::string& image : outputs.images) names.emplace_back(image, "");
    if (!outputs.preview.empty()) names.emplace_back(outputs.preview, ".png");
    for (const NamedOutput& output : kNamedOutputs)
        if (const std::string& file = outputs.*output.file; !file.empty()) names.emplace_back(file, output.suffix);
    return names;
}

bool shows_preview(const JobOutputs& outputs) {
    if (!outputs.preview.empty()) return true;
    return std::any_of(outputs.images.begin(), outputs.images.end(), [&](const std::string& image) {
        return image.ends_with(".png") || (image == "-" && outputs.format == "png");
    });
}

std::string preview_query(const JobOutputs& outputs) {
    std::string query = "?exposure=" + decimal(outputs.exposure_stops);
    if (!outputs.preview_layer.empty()) query += "&layer=" + percent_encode(outputs.preview_layer);
    if (!outputs.tone_curve.empty()) query += "&curve=" + percent_encode(outputs.tone_curve);
    return query;
}

}  // namespace

uint64_t download(Session& session, const std::string& path_and_query, const std::string& file) {
    HttpRequest request;
    request.path = path_and_query;
    ReplySink sink;
    OutputFile output(file);
    sink.head = [&output](const HttpReply&) {
        output.restart();
        return true;
    };
    sink.data = [&output](std::string_view bytes) {
        output.write(bytes);
        return true;
    };
    // What standard output has got cannot be taken back.
    const HttpReply reply = session.daemon().ask(request, file == "-" ? Repeat::OnlyIfRefused : Repeat::Safely, &sink);
    if (reply.status != 200)
        throw Failure("there is nothing to save" + (file == "-" ? "" : " as " + file) + " yet: no pass is done",
                      nlohmann::json{{"title", "no pass is done"}, {"status", reply.status}});
    output.publish();
    return output.size_bytes();
}

void save_resource(Session& session, const std::string& path_and_query, const std::string& file) {
    const uint64_t bytes = download(session, path_and_query, file);
    if (file != "-") session.remark("saved " + file + " (" + human_bytes(static_cast<double>(bytes)) + ")");
}

void JobOutputs::check(const Session& session) const {
    for (const std::string& image : images)
        if (image != "-" && !image.ends_with(".exr") && !image.ends_with(".png"))
            throw Failure(ExitCode::Usage, "cannot tell what to save as " + image,
                          "name it .exr (all layers) or .png (preview), or - for standard output");
    size_t on_standard_output = 0;
    for (const auto& [name, suffix] : names_and_suffixes(*this)) {
        if (name == "-")
            ++on_standard_output;
        else if (!name.ends_with(suffix))
            throw Failure(ExitCode::Usage, "what would be saved as " + name + " is a " + suffix, "name it " + suffix);
    }
    if (on_standard_output > 1)
        throw Failure(ExitCode::Usage, "standard output can take one of the results, not several");
    const bool image_on_standard_output = std::find(images.begin(), images.end(), "-") != images.end();
    if (!format.empty() && !image_on_standard_output)
        throw Failure(ExitCode::Usage, "--format says what -o - writes; a file is what its name ends in");
    const bool binary = on_standard_output > 0 && statistics != "-" && log != "-" && error_curve != "-";
    if (binary && session.json_output)
        throw Failure(ExitCode::Usage, "--json and a result named - cannot share standard output");
    if (binary && isatty(STDOUT_FILENO) == 1)
        throw Failure(ExitCode::Usage, "standard output is a terminal, which the bytes of an image would garble",
                      "send it on: > image.exr, or | another program");
    for (const auto& [name, suffix] : names_and_suffixes(*this)) OutputFile::check_place(name);
}

void JobOutputs::check_preview_layer(Session& session, const json& layers) const {
    if (preview_layer.empty() || !shows_preview(*this)) return;
    std::string there_are;
    const json items = session.daemon().get("/v1/layers").at("items");
    for (const json& layer : items) {
        const json name = member(layer, "name");
        const bool kept = member(layer, "always") == true ||
                          (layers.is_array() && std::find(layers.begin(), layers.end(), name) != layers.end());
        if (!kept || member(layer, "preview").is_null()) continue;
        if (name == preview_layer) return;
        there_are += (there_are.empty() ? "" : ", ") + plain_text(name);
    }
    throw Failure(ExitCode::Usage, "the image has no layer " + printable(preview_layer) + " with a preview",
                  "it has " + there_are + "; --layers adds others");
}

bool JobOutputs::to_standard_output() const {
    const auto names = names_and_suffixes(*this);
    return std::any_of(names.begin(), names.end(), [](const auto& name) { return name.first == "-"; });
}

std::ostream& text_beside(const JobOutputs& outputs) { return outputs.to_standard_output() ? std::cerr : std::cout; }

bool JobOutputs::any() const {
    return any_image() || std::any_of(kNamedOutputs.begin(), kNamedOutputs.end(),
                                      [this](const NamedOutput& output) { return !(this->*output.file).empty(); });
}

void save_job_outputs(Session& session, const std::string& job_id, const JobOutputs& outputs) {
    const std::string job = resource_path("jobs", job_id);
    for (const std::string& image : outputs.images) {
        if (image.ends_with(".png") || (image == "-" && outputs.format == "png"))
            save_resource(session, job + "/preview.png" + preview_query(outputs), image);
        else
            save_resource(session,
                          job + "/image.exr" + (outputs.precision.empty() ? "" : "?precision=" + outputs.precision),
                          image);
    }
    if (!outputs.preview.empty())
        save_resource(session, job + "/preview.png" + preview_query(outputs), outputs.preview);
    for (const NamedOutput& output : kNamedOutputs)
        if (const std::string& file = outputs.*output.file; !file.empty())
            save_resource(session, job + output.resource, file);
}

}  // namespace photond::cli
