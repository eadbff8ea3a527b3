#include "clients/cli/compare_stages.h"

#include <algorithm>
#include <optional>
#include <ostream>

#include "clients/cli/text_table.h"
#include "clients/cli/units.h"

namespace photond::cli {

using nlohmann::json;

namespace {

constexpr double kMillisecondsPerSecond = 1000;

struct StageTime {
    std::string name;
    double ms = 0;  // of the whole job
};

/// In the order of their first use. A device's clock is preferred to that of the host, which waits for it.
std::vector<StageTime> stages_of(const json& statistics) {
    std::vector<StageTime> times;
    const json stages = statistics.value("stages", json::array());
    for (const json& stage : stages) {
        const json on_device = stage.value("gpu_seconds", json());
        const json seconds = on_device.is_number() ? on_device : stage.value("wall_seconds", json());
        if (seconds.is_number())
            times.push_back({plain_text(stage.value("name", json())), seconds.get<double>() * kMillisecondsPerSecond});
    }
    return times;
}

/// One of PublishedStages::rows as it was measured; no times: it is not there.
struct MeasuredRow {
    std::vector<StageTime> stages;
    double passes = 0;

    /// Of those stages together; none where no such stage was timed.
    std::optional<double> ms(std::span<const std::string_view> names, bool once) const {
        std::optional<double> sum;
        for (const StageTime& stage : stages)
            if (std::find(names.begin(), names.end(), stage.name) != names.end()) sum = sum.value_or(0) + stage.ms;
        if (!sum || once) return sum;
        return passes > 0 ? std::optional(*sum / passes) : std::nullopt;
    }
};

MeasuredRow measured_row(std::span<const RowStatistics> rows, std::string_view name) {
    for (const RowStatistics& row : rows)
        if (row.name == name) return {stages_of(row.statistics), row.statistics.value("passes", 0.0)};
    return {};
}

}  // namespace

void print_published_stages(std::ostream& out, std::span<const RowStatistics> rows, const PublishedStages& published) {
    std::vector<MeasuredRow> measured;
    std::vector<TextTable::Column> heads{{std::string(published.text)}, {"stages"}};
    for (const std::string_view name : published.rows) {
        measured.push_back(measured_row(rows, name));
        heads.push_back({std::string(name) + ": published", Align::Right});
        heads.push_back({"ours", Align::Right});
    }
    if (std::all_of(measured.begin(), measured.end(), [](const MeasuredRow& row) { return row.stages.empty(); }))
        return;
    TextTable table(heads);
    for (const PublishedStage& stage : published.stages) {
        std::string names;
        for (const std::string_view name : stage.stages) names += (names.empty() ? "" : " + ") + std::string(name);
        std::vector<std::string> cells{std::string(stage.name) + (stage.once ? ", once" : ""), names};
        bool known = !stage.published_ms.empty();
        for (size_t i = 0; i < measured.size(); ++i) {
            const std::optional<double> ms = measured[i].ms(stage.stages, stage.once);
            known = known || ms;
            cells.push_back(stage.published_ms.empty() ? "-" : three_digit_number(stage.published_ms.at(i)));
            cells.push_back(ms ? three_digit_number(*ms) : "-");
        }
        if (known) table.add_row(std::move(cells));
    }
    table.print(out << '\n', "  ");
}

}  // namespace photond::cli
