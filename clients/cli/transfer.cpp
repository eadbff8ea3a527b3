#include "clients/cli/transfer.h"

#include <algorithm>
#include <array>
#include <iostream>
#include <memory>
#include <sstream>

#include "clients/cli/output_file.h"
#include "clients/cli/units.h"

namespace photond::cli {

namespace {

std::string decimal(double value) {
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text << value;
    return text.str();
}

/// What is saved under one name each, as a member and its place below the job.
struct NamedOutput {
    std::string JobOutputs::*file;
    const char* resource;
};
constexpr std::array<NamedOutput, 8> kNamedOutputs{{{&JobOutputs::statistics, "/statistics.json"},
                                                    {&JobOutputs::log, "/log.txt"},
                                                    {&JobOutputs::photon_map, "/photon_map.glb"},
                                                    {&JobOutputs::error_curve, "/curve.csv"},
                                                    {&JobOutputs::difference, "/difference.exr"},
                                                    {&JobOutputs::flip, "/flip.png"},
                                                    {&JobOutputs::error_map, "/error.png"},
                                                    {&JobOutputs::film, "/film"}}};

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
    const HttpReply reply = session.daemon().ask(request, Repeat::Safely, &sink);
    if (reply.status != 200)
        throw Failure("there is nothing to save as " + file + " yet: no pass is done",
                      nlohmann::json{{"title", "no pass is done"}, {"status", reply.status}});
    output.publish();
    return output.size_bytes();
}

void save_resource(Session& session, const std::string& path_and_query, const std::string& file) {
    if (file != "-") {
        const uint64_t bytes = download(session, path_and_query, file);
        session.remark("saved " + file + " (" + human_bytes(static_cast<double>(bytes)) + ")");
        return;
    }
    HttpRequest request;
    request.path = path_and_query;
    ReplySink sink;
    sink.data = [](std::string_view bytes) {
        std::cout.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        return std::cout.good();
    };
    session.daemon().ask(request, Repeat::OnlyIfRefused, &sink);  // what is written cannot be taken back
    std::cout.flush();
}

void JobOutputs::check() const {
    for (const std::string& image : images)
        if (!image.ends_with(".exr") && !image.ends_with(".png"))
            throw Failure(ExitCode::Usage, "cannot tell what to save as " + image,
                          "name it .exr (all layers) or .png (preview)");
}

bool JobOutputs::any() const {
    return any_image() || std::any_of(kNamedOutputs.begin(), kNamedOutputs.end(),
                                      [this](const NamedOutput& output) { return !(this->*output.file).empty(); });
}

void save_job_outputs(Session& session, const std::string& job_id, const JobOutputs& outputs) {
    const std::string job = resource_path("jobs", job_id);
    for (const std::string& image : outputs.images) {
        if (image.ends_with(".png"))
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
