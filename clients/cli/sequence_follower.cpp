#include "clients/cli/sequence_follower.h"

#include "clients/cli/job_follower.h"
#include "clients/cli/progress_view.h"
#include "clients/cli/units.h"

namespace photond::cli {

using nlohmann::json;

namespace {

constexpr std::chrono::milliseconds kPollSequenceEvery{300};

/// To its end. Its frames are read then; until then its summary says all that is shown, in a few bytes.
json follow_sequence(Session& session, const std::string& id, const std::function<void(const json&)>& listener) {
    DaemonClient& daemon = session.daemon();
    while (true) {
        const json summary = daemon.get(resource_path("sequences", id) + "?frames=false");
        listener(summary);
        if (is_over(summary)) return daemon.get(resource_path("sequences", id));
        if (!daemon.interrupt().sleep(kPollSequenceEvery)) throw interrupted(daemon.interrupt().cause());
    }
}

}  // namespace

std::string sequence_figures(const json& sequence) {
    size_t all = 0, over = 0;
    const json states = sequence.value("job_states", json::object());
    for (const auto& [state, count] : states.items()) {
        all += count.get<size_t>();
        if (is_over({{"state", state}})) over += count.get<size_t>();
    }
    std::string text = std::to_string(over) + " of " + std::to_string(all) + " frames";
    if (const json left = sequence.value("seconds_left", json()); left.is_number() && !is_over(sequence))
        text += ", " + human_seconds(left.get<double>()) + " left";
    return text;
}

json wait_for_sequence(Session& session, const std::string& id, const WaitOptions& options) {
    const std::optional<json> sequence = wait_for(session, "sequence", id, options, [&] {
        ProgressLine line;
        std::string shown;
        return follow_sequence(session, id, [&](const json& now) {
            const std::string text = id + " " + now.value("state", "") + ", " + sequence_figures(now);
            if (session.error_is_terminal())
                line.redraw(text);
            else if (const std::string plain = now.value("state", ""); plain != shown)
                session.remark(text), shown = plain;
        });
    });
    return sequence ? *sequence : follow_sequence(session, id, [](const json&) {});
}

}  // namespace photond::cli
