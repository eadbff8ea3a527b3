#include "clients/cli/hard_cases_table.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <set>

#include "clients/cli/units.h"

namespace photond::cli {

namespace {

using nlohmann::json;

constexpr uint64_t kFirstSeed = 1;
// Of references: far from the table's, so that a method is never compared with its own random numbers.
constexpr uint64_t kFirstReferenceSeed = 1'000'001;
constexpr double kReferencePasses = 4;  // times those of a cell

/// Where a check's figures come from.
struct PlannedCheck {
    const HardCheck* check = nullptr;
    Renderings::Place measured;
    std::optional<Renderings::Place> answer;  // of same_as and reference
};

struct PlannedCell {
    std::string not_applicable;
    std::vector<std::string> notes;
    std::vector<PlannedCheck> checks;
};

/// The bounces of the job in which a check is read. Direct and emitted light have none, so they are read in the job of
/// the case's first indirect answer.
std::optional<uint32_t> bounces_of(const HardCase& hard_case, const HardCheck& check) {
    if (check.layer != "direct" && check.layer != "emitted") return check.bounces;
    for (const HardCheck& other : hard_case.checks)
        if (other.layer == "indirect" || other.layer == "beauty") return other.bounces;
    return check.bounces;
}

class Planner {
public:
    Planner(const HardCasesTable& table, Renderings& renderings) : table_(table), renderings_(renderings) {}

    PlannedCell plan(const HardCase& hard_case, const TableEntry& entry) {
        PlannedCell cell;
        const auto excluded = hard_case.not_applicable.find(entry.method.at("name").get<std::string>());
        if (excluded != hard_case.not_applicable.end()) {
            cell.not_applicable = excluded->second;
            return cell;
        }
        for (const HardCheck& check : hard_case.checks) {
            const BouncedMethod asked = with_bounces(entry, bounces_of(hard_case, check));
            if (!asked.not_applicable.empty()) {
                cell.not_applicable = asked.not_applicable;
                continue;
            }
            if (!asked.note.empty() && std::find(cell.notes.begin(), cell.notes.end(), asked.note) == cell.notes.end())
                cell.notes.push_back(asked.note);
            cell.checks.push_back(plan_check(hard_case, check, asked.method));
        }
        if (!cell.checks.empty() && !cell.not_applicable.empty()) {
            cell.notes.push_back("not every answer applies: " + cell.not_applicable);
            cell.not_applicable.clear();
        }
        return cell;
    }

private:
    PlannedCheck plan_check(const HardCase& hard_case, const HardCheck& check, const json& method) {
        RenderWish wish{hard_case.scene, method, passes(hard_case),
                        table_.options.small_images ? small_image(hard_case) : hard_case.size, kFirstSeed};
        PlannedCheck planned{&check, renderings_.want(wish, check.layer, check.region), std::nullopt};
        if (check.relation == Relation::SameAs) {
            wish.scene = check.other_scene;
            planned.answer = renderings_.want(wish, check.layer, check.region);
        } else if (check.relation == Relation::Reference) {
            wish.method = {{"name", "path_tracing"}};
            if (const auto bounces = bounces_of(hard_case, check))
                wish.method["parameters"] = {{"indirect_bounces", *bounces}};
            wish.passes = static_cast<uint32_t>(std::lround(kReferencePasses * wish.passes));
            wish.first_seed = kFirstReferenceSeed;
            planned.answer = renderings_.want(wish, check.layer, check.region);
        }
        return planned;
    }

    uint32_t passes(const HardCase& hard_case) const {
        return static_cast<uint32_t>(std::max(1L, std::lround(table_.options.effort * hard_case.passes)));
    }

    const HardCasesTable& table_;
    Renderings& renderings_;
};

/// Seed by seed, where both the measured and the answer are there.
RegionSamples samples_of(const PlannedCheck& planned, const Renderings& renderings) {
    const HardCheck& check = *planned.check;
    RegionSamples samples;
    samples.tolerance = check.tolerance;
    const auto& means = renderings.means(planned.measured);
    for (size_t seed = 0; seed < means.size(); ++seed) {
        std::optional<Radiance> answer = check.value.value_or(Radiance{});
        if (planned.answer) answer = renderings.means(*planned.answer)[seed];
        if (!means[seed] || !answer) continue;
        for (double& channel : *answer) channel *= check.relation == Relation::SameAs ? check.scale : 1;
        samples.means.push_back(*means[seed]);
        samples.answers.push_back(*answer);
    }
    return samples;
}

std::string percent(double relative) {
    const std::string digits = three_digit_number(100 * relative);
    return (relative > 0 ? "+" : "") + digits + " %";
}

/// "+3.2 % (se 0.1 %, allowed +-0.9 %)", or radiance where the answer is black.
std::string figure_text(const Judgement& judgement) {
    if (!judgement.relative)
        return three_digit_number(judgement.bias) + " (se " + three_digit_number(judgement.standard_error) +
               ", allowed +-" + three_digit_number(judgement.half_width) + ")";
    return percent(judgement.bias) + " (se " + three_digit_number(100 * judgement.standard_error) + " %, allowed +-" +
           three_digit_number(100 * judgement.half_width) + " %)";
}

void judge_interval(CheckFound& found, const RegionSamples& samples, double false_alarm) {
    if (samples.means.size() < 2) {
        found.text = "breaks: fewer than two seeds gave pixels";
        return;
    }
    found.judgement = judge(found.check.relation, samples, false_alarm);
    found.holds = found.judgement->holds;
    found.text = verdict_text(*found.judgement);
    if (!found.holds) found.text += ": " + figure_text(*found.judgement);
}

void judge_zero(CheckFound& found, const MeanLayer& layer) {
    if (layer.empty()) {
        found.text = "breaks: no seed gave pixels";
        return;
    }
    found.worst = worst_pixel(layer, found.check.region, Radiance{}, 1);
    found.holds = found.worst.deviation == 0 && found.measured == Radiance{};
    found.text = found.holds ? "holds"
                             : "breaks: radiance up to " + three_digit_number(found.worst.deviation) +
                                   " where there is none, mean " +
                                   three_digit_number(*std::max_element(found.measured.begin(), found.measured.end()));
}

CheckFound judge_check(const PlannedCheck& planned, const Renderings& renderings, double false_alarm) {
    CheckFound found;
    found.check = *planned.check;
    const RegionSamples samples = samples_of(planned, renderings);
    const MeanLayer& layer = renderings.layer(planned.measured);
    if (!samples.means.empty()) {
        found.measured = mean_of(samples.means);
        found.answer = mean_of(samples.answers);
    }
    if (found.check.relation == Relation::Zero) {
        judge_zero(found, layer);
    } else if (found.check.relation == Relation::Finite) {
        found.holds = true;  // what it looks for is looked for in every cell
        found.text = "holds";
    } else {
        judge_interval(found, samples, false_alarm);
        const double brightest = *std::max_element(found.answer.begin(), found.answer.end());
        const double scale = brightest > 0 ? brightest : 1;
        if (layer.empty()) return found;
        if (!planned.answer)
            found.worst = worst_pixel(layer, found.check.region, found.answer, scale);
        else if (const MeanLayer& other = renderings.layer(*planned.answer); !other.empty())
            found.worst = worst_pixel(layer, found.check.region, other, found.check.scale, scale);
    }
    return found;
}

/// What must never happen, in one rendering of the cell.
void add_defects(Cell& cell, const Rendering& rendering, const std::string& whose) {
    const auto add = [&](uint64_t count, const std::string& what) {
        if (count > 0) cell.defects.push_back(whose + human_number(static_cast<double>(count)) + " " + what);
    };
    add(rendering.nan_samples, "samples were NaN");
    add(rendering.infinite_samples, "samples were infinite");
    add(rendering.faults.nan, "channels of pixels are NaN");
    add(rendering.faults.infinite, "channels of pixels are infinite");
    add(rendering.faults.negative, "channels of pixels are negative");
    add(rendering.hangs, "jobs hung");
    for (const std::string& failure : rendering.failures) cell.defects.push_back(whose + failure);
}

/// The check a table shows: the first that breaks, else the one known least well.
std::optional<size_t> shown_of(const std::vector<CheckFound>& checks) {
    std::optional<size_t> shown;
    for (size_t i = 0; i < checks.size(); ++i) {
        if (!checks[i].holds) return i;
        const auto width = [&](size_t k) { return checks[k].judgement ? checks[k].judgement->half_width : -1; };
        if (!shown || width(i) > width(*shown)) shown = i;
    }
    return shown;
}

Cell judge_cell(const PlannedCell& planned, const Renderings& renderings, double false_alarm) {
    Cell cell;
    cell.notes = planned.notes;
    if (!planned.not_applicable.empty() || planned.checks.empty()) {
        cell.text = "not applicable: " + (planned.checks.empty() && planned.not_applicable.empty()
                                              ? std::string("the case has no check")
                                              : planned.not_applicable);
        return cell;
    }
    std::set<size_t> own, others;
    for (const PlannedCheck& check : planned.checks) {
        cell.checks.push_back(judge_check(check, renderings, false_alarm));
        own.insert(check.measured.rendering);
        if (check.answer) others.insert(check.answer->rendering);
    }
    for (const size_t index : own) {
        const Rendering& rendering = renderings.rendering(index);
        add_defects(cell, rendering, "");
        cell.nan += rendering.nan_samples + rendering.faults.nan;
        cell.infinite += rendering.infinite_samples + rendering.faults.infinite;
        cell.negative += rendering.faults.negative;
        cell.seconds += rendering.seconds;
        cell.jobs.insert(cell.jobs.end(), rendering.jobs.begin(), rendering.jobs.end());
        if (rendering.cut_short > 0)
            cell.notes.push_back(std::to_string(rendering.cut_short) +
                                 " jobs ended by their seconds, before their passes");
    }
    for (const size_t index : others)
        if (!own.contains(index)) add_defects(cell, renderings.rendering(index), "what it is compared with: ");
    cell.shown = shown_of(cell.checks);
    const bool all_hold = std::all_of(cell.checks.begin(), cell.checks.end(), [](const auto& c) { return c.holds; });
    cell.verdict = all_hold && cell.defects.empty() ? Verdict::Holds : Verdict::Breaks;
    cell.text = cell.defects.empty() ? cell.checks[*cell.shown].text : "breaks: " + cell.defects.front();
    return cell;
}

}  // namespace

const char* wire_name(Verdict verdict) {
    switch (verdict) {
        case Verdict::Holds: return "holds";
        case Verdict::Breaks: return "breaks";
        default: return "not applicable";
    }
}

HardCasesTable::Summary HardCasesTable::summary() const {
    Summary summary;
    for (const auto& row : cells)
        for (const Cell& cell : row) {
            summary.holds += cell.verdict == Verdict::Holds;
            summary.breaks += cell.verdict == Verdict::Breaks;
            summary.not_applicable += cell.verdict == Verdict::NotApplicable;
            summary.defects += !cell.defects.empty();
        }
    return summary;
}

HardCasesTable measure_table(Session& session, std::vector<HardCase> cases, std::vector<TableEntry> entries,
                             const TableOptions& options, bool keep_jobs) {
    HardCasesTable table{std::move(cases), std::move(entries), {}, options};
    Renderings renderings;
    Planner planner(table, renderings);
    std::vector<std::vector<PlannedCell>> plan(table.cases.size());
    for (size_t i = 0; i < table.cases.size(); ++i) {
        if (table.cases[i].scene.empty()) continue;
        for (const TableEntry& entry : table.entries) plan[i].push_back(planner.plan(table.cases[i], entry));
        for (const PlannedCell& cell : plan[i])
            for (const PlannedCheck& check : cell.checks)
                table.comparisons += has_interval(check.check->relation) ? kChannels : 0;
    }
    table.jobs = renderings.size() * options.limits.seeds;
    session.remark(counted(table.jobs, "job") + ": " + counted(renderings.size(), "rendering") + " by " +
                   counted(options.limits.seeds, "seed"));
    renderings.run(session, options.limits);

    const double false_alarm = shared_false_alarm(kTableFalseAlarm, table.comparisons);
    std::set<std::string> kept;
    for (size_t i = 0; i < plan.size(); ++i) {
        table.cells.emplace_back();
        for (size_t j = 0; j < plan[i].size(); ++j) {
            Cell cell = judge_cell(plan[i][j], renderings, false_alarm);
            if (cell.verdict == Verdict::Breaks) {
                cell.reason = known_reason(table.entries[j], table.cases[i]);
                kept.insert(cell.jobs.begin(), cell.jobs.end());
            }
            table.cells.back().push_back(std::move(cell));
        }
    }
    if (keep_jobs) return table;
    for (size_t i = 0; i < renderings.size(); ++i) {
        std::vector<std::string> unneeded;
        for (const std::string& job : renderings.rendering(i).jobs)
            if (!kept.contains(job)) unneeded.push_back(job);
        remove_jobs(session, unneeded);
    }
    return table;
}

}  // namespace photond::cli
