#include "clients/cli/sequence_follower.h"

#include <algorithm>

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

std::pair<size_t, size_t> frames_over(const json& sequence) {
    size_t all = 0, over = 0;
    const json states = sequence.value("job_states", json::object());
    for (const auto& [state, count] : states.items()) {
        all += count.get<size_t>();
        if (is_over({{"state", state}})) over += count.get<size_t>();
    }
    return {over, all};
}

std::string sequence_figures(const json& sequence) {
    const auto [over, all] = frames_over(sequence);
    std::string text = std::to_string(over) + " of " + std::to_string(all) + " frames";
    if (const json left = sequence.value("seconds_left", json()); left.is_number() && !is_over(sequence))
        text += ", " + human_seconds(left.get<double>()) + " left";
    return text;
}

json wait_for_sequence(Session& session, const std::string& id, const WaitOptions& options,
                       const std::function<void(const json& summary)>& told) {
    constexpr size_t kLines = 10;  // that say how far it is, where it is no terminal that reads them
    const std::optional<json> sequence = wait_for(session, "sequence", id, options, [&] {
        ProgressLine line;
        std::string shown;
        size_t shown_tenth = 0;
        return follow_sequence(session, id, [&](const json& now) {
            const std::string state = now.value("state", ""), text = id + " " + state + ", " + sequence_figures(now);
            const auto [over, all] = frames_over(now);
            const size_t tenth = kLines * over / std::max<size_t>(all, 1);
            if (session.error_is_terminal())
                line.redraw(text);
            else if (state != shown || tenth > shown_tenth)
                session.remark(text), shown = state, shown_tenth = tenth;
            told(now);
        });
    });
    return sequence ? *sequence : follow_sequence(session, id, told);
}

}  // namespace photond::cli
