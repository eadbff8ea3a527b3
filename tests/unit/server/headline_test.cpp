// The sentence of a comparison: true of its table, whatever the table. Tables are drawn at random; what is true of them
// is found here by the table alone, and the sentence is read back and held against that.

#include "server/comparisons/headline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>

namespace photond::headline_test {
namespace {

using nlohmann::json;

constexpr const char* kMetric = "rmse";
/// 0.1004 is a target: to three digits it is its neighbour.
constexpr double kLevels[] = {2, 1, 0.5, 0.2, 0.1004, 0.1, 0.05, 0.02, 0.01, 1e-5};

TableRow row_of(const std::string& label, const std::vector<TimeToError>& times) {
    TableRow row;
    row.label = label;
    row.parameters = json::object();
    row.time_to_error[kMetric] = times;
    return row;
}

/// Seconds by falling error, from kLevels' first on, of rows "a", "b" ...; 0: not reached.
ComparisonTable table_of(const std::vector<std::vector<double>>& seconds) {
    ComparisonTable table{{kMetric}, {}};
    for (const std::vector<double>& of_row : seconds) {
        std::vector<TimeToError> times;
        for (const double second : of_row) {
            times.push_back({kLevels[times.size()], {}, 1, false});
            if (second > 0) times.back().seconds = SeedMean{second, {}, {}};
        }
        table.rows.push_back(row_of(std::string(1, static_cast<char>('a' + table.rows.size())), times));
    }
    return table;
}

/// Too close to call at this level, of two rows that reach it.
void tie(ComparisonTable& table, size_t level, size_t one, size_t other) {
    for (const size_t row : {one, other}) table.rows[row].time_to_error[kMetric][level].at_most = true;
}

/// The only one there is.
Headline headline_of_table(const ComparisonTable& table) {
    const std::vector<Headline> found = headlines(table, verdicts(table));
    if (found.size() != 1) throw std::runtime_error(std::to_string(found.size()) + " headlines");
    return found.front();
}

std::string sentence(const ComparisonTable& table) { return headline_text(table, headline_of_table(table)); }

TEST(Headline, TellsWhereOneTakesOverThoughItIsAloneAtTheEnd) {
    // Two verdicts are for a: the last level only it reaches. It once read "a is first down to 0.1004, a below that".
    const ComparisonTable table = table_of({{2, 3, 4, 5, 6}, {1, 2, 5, 6, 0}});
    ASSERT_EQ(verdicts(table).size(), 3u);
    EXPECT_EQ(sentence(table), "It depends on the error you need: b is first down to rmse 1, a below that");
    const Headline headline = headline_of_table(table);
    EXPECT_EQ(headline.row, 0u);
    EXPECT_EQ(headline.verdict, 1u) << "which says by how much";
}

TEST(Headline, NamesEachThatLeads) {
    EXPECT_EQ(sentence(table_of({{1, 2, 3}, {2, 3, 4}})), "a is better here");
    EXPECT_EQ(sentence(table_of({{1, 2, 9, 9}, {2, 3, 4, 9.5}})),
              "It depends on the error you need: a is first down to rmse 1, b down to 0.5, a below that");
    EXPECT_EQ(sentence(table_of({{1, 5, 9}, {2, 3, 9.5}, {3, 4, 5}})),
              "It depends on the error you need: a is first down to rmse 2, b down to 1, c below that");
    // To three digits, the first two levels of it are one.
    EXPECT_EQ(sentence(table_of({{1, 1, 1, 1, 1, 3}, {2, 2, 2, 2, 2, 2}})),
              "It depends on the error you need: a is first down to rmse 0.1004, b below that");
    EXPECT_EQ(sentence(table_of({{1, 3, 3, 5, 5, 7}, {2, 2, 4, 4, 6, 6}})),
              "It depends on the error you need: the lead changes 5 times; b is first below rmse 0.1004");
}

TEST(Headline, SaysWhereItIsTooCloseToCall) {
    ComparisonTable table = table_of({{1, 2, 3}, {2, 3, 4}});
    tie(table, 0, 0, 1);
    EXPECT_EQ(sentence(table), "a is better here");  // b is nowhere clearly sooner
    tie(table, 1, 0, 1);
    tie(table, 2, 0, 1);
    EXPECT_EQ(sentence(table), "Too close to call");
    table = table_of({{1, 2, 3}, {2, 3, 4}});
    tie(table, 2, 0, 1);
    EXPECT_EQ(sentence(table), "a is first down to rmse 1; it is too close to call below that");
    EXPECT_EQ(headline_of_table(table).row, 0u);
    table = table_of({{3, 3, 3}, {1, 4, 4}, {2, 5, 5}});  // b and c before a
    tie(table, 0, 1, 2);
    EXPECT_EQ(sentence(table), "It is too close to call down to rmse 2; a is first below that");
    table = table_of({{1, 2, 4, 5}, {2, 3, 3, 6}});
    tie(table, 1, 0, 1);
    tie(table, 3, 0, 1);
    EXPECT_EQ(sentence(table),
              "It depends on the error you need: a is first down to rmse 2; it is too close to call down to 1; b is "
              "first down to 0.5; it is too close to call below that");
    EXPECT_FALSE(headline_of_table(table).row);
    table = table_of({{2, 2, 2, 2, 2, 2}, {3, 1, 3, 1, 3, 1}, {4, 1.5, 4, 1.5, 4, 1.5}});
    for (const size_t level : {1, 3, 5}) tie(table, level, 1, 2);
    EXPECT_EQ(sentence(table), "a is first wherever it is not too close to call");
}

TEST(Headline, IsSilentWhereNothingIsKnown) {
    for (const ComparisonTable& table : {table_of({{1, 2}}), table_of({{0, 0}, {0, 0}}), table_of({{}, {}})})
        EXPECT_TRUE(headlines(table, verdicts(table)).empty());
}

TEST(Headline, IsGivenForEachMetric) {
    ComparisonTable table = table_of({{1, 2}, {2, 3}});
    table.metrics = {"mse", "unreached", kMetric};
    for (TableRow& row : table.rows) row.time_to_error["unreached"] = {{1, {}, 0, false}};
    table.rows[0].time_to_error["mse"] = {{0.5, SeedMean{2, {}, {}}, 1, false}, {0.25, {}, 0, false}};
    table.rows[1].time_to_error["mse"] = {{0.5, SeedMean{1, {}, {}}, 1, false}, {0.25, SeedMean{9, {}, {}}, 1, false}};
    EXPECT_EQ(headlines_json(table, verdicts(table)), json::parse(R"([
        {"metric": "mse", "text": "b is better here", "row": 1, "best": true, "verdict": 0,
         "stretches": [{"row": 1, "easiest": 0.5, "error": 0.25}]},
        {"metric": "rmse", "text": "a is better here", "row": 0, "best": true, "verdict": 2,
         "stretches": [{"row": 0, "easiest": 2.0, "error": 1.0}]}])"));
}

// --- What is true of a table
// ------------------------------------------------------------------------------------------

/// Rows that are first, a level each, as far as any row reaches; none: too close to call.
using Firsts = std::vector<std::optional<size_t>>;

const TimeToError& at(const ComparisonTable& table, size_t row, size_t level) {
    return table.rows[row].time_to_error.at(kMetric)[level];
}

/// Whether one is sooner at a level than another, which may not reach it.
bool is_clearly_before(const TimeToError& a, const TimeToError& b) {
    if (!a.seconds || (b.seconds && a.seconds->mean >= b.seconds->mean)) return false;
    if (!b.seconds) return true;
    const bool overlap = a.seconds->high && b.seconds->low && *a.seconds->high >= *b.seconds->low;
    return !overlap && !(a.at_most && b.at_most);
}

Firsts firsts_of(const ComparisonTable& table) {
    Firsts firsts;
    for (size_t level = 0; level < table.rows[0].time_to_error.at(kMetric).size(); ++level) {
        std::vector<std::pair<double, size_t>> order;
        for (size_t row = 0; row < table.rows.size(); ++row)
            if (const auto& seconds = at(table, row, level).seconds) order.emplace_back(seconds->mean, row);
        if (order.empty()) break;
        std::sort(order.begin(), order.end());
        const TimeToError& first = at(table, order[0].second, level);
        const bool clear = std::all_of(order.begin() + 1, order.end(), [&](const auto& other) {
            return is_clearly_before(first, at(table, other.second, level));
        });
        firsts.push_back(clear ? std::optional(order[0].second) : std::nullopt);
    }
    return firsts;
}

std::set<size_t> leaders_of(const Firsts& firsts) {
    std::set<size_t> leaders;
    for (const auto& first : firsts)
        if (first) leaders.insert(*first);
    return leaders;
}

bool is_best(const ComparisonTable& table, const Firsts& firsts, size_t row) {
    if (firsts.back() != row || leaders_of(firsts) != std::set{row}) return false;
    for (size_t level = 0; level < firsts.size(); ++level)
        for (size_t other = 0; other < table.rows.size(); ++other)
            if (is_clearly_before(at(table, other, level), at(table, row, level))) return false;
    return true;
}

// --- What a sentence says
// ---------------------------------------------------------------------------------------------

/// Takes `word` off the front of a text, where it stands there.
bool takes(std::string_view& text, std::string_view word) {
    if (!text.starts_with(word)) return false;
    text.remove_prefix(word.size());
    return true;
}

/// A name of the tables here is one letter.
size_t take_row(std::string_view& text) {
    const auto row = static_cast<size_t>(text.at(0) - 'a');
    text.remove_prefix(1);
    return row;
}

double take_number(std::string_view& text) {
    size_t length = 0;
    const double number = std::stod(std::string(text), &length);
    text.remove_prefix(length);
    return number;
}

/// "rmse 0.2" once in a sentence, then "0.2".
double take_level(std::string_view& text, bool named) {
    EXPECT_EQ(takes(text, std::string(kMetric) + " "), named);
    return take_number(text);
}

/// Who is first or nobody: "a is first", "it is too close to call".
std::optional<size_t> take_clause(std::string_view& text) {
    if (takes(text, "it is too close to call")) return std::nullopt;
    const size_t row = take_row(text);
    EXPECT_TRUE(takes(text, " is first"));
    return row;
}

/// Reads "a is first down to rmse 0.2, b down to 0.1; it is too close to call below that" and holds it against the
/// table.
void expect_stretches(std::string_view text, const Firsts& firsts) {
    size_t level = 0;
    std::optional<size_t> said;
    for (bool begins = true; level < firsts.size(); begins = false) {
        if (!begins && takes(text, ", ")) {
            ASSERT_TRUE(said) << "'is first' is left out after a clause that has it";
            said = take_row(text);
        } else {
            ASSERT_TRUE(begins || takes(text, "; "));
            said = take_clause(text);
        }
        const bool last = takes(text, " below that");
        ASSERT_TRUE(last || takes(text, " down to "));
        const double down_to = last ? 0 : take_level(text, begins);
        const size_t from = level;
        for (; level < firsts.size() && kLevels[level] >= down_to; ++level) EXPECT_EQ(firsts[level], said) << level;
        ASSERT_GT(level, from) << "a stretch of no level";
        ASSERT_TRUE(last || kLevels[level - 1] == down_to) << "no level of the table: " << down_to;
        ASSERT_EQ(last, level == firsts.size());
    }
    EXPECT_EQ(text, "");
}

/// Reads "the lead changes 6 times; a is first below rmse 0.1".
void expect_changes(std::string_view text, const Firsts& firsts) {
    std::vector<size_t> lead;
    for (const auto& first : firsts)
        if (first && (lead.empty() || lead.back() != *first)) lead.push_back(*first);
    EXPECT_EQ(take_number(text), static_cast<double>(lead.size() - 1));
    ASSERT_TRUE(takes(text, lead.size() == 2 ? " time; " : " times; "));
    const std::optional<size_t> said = take_clause(text);
    ASSERT_TRUE(takes(text, " below "));
    const double below = take_level(text, true);
    EXPECT_EQ(text, "");
    for (size_t level = 0; level < firsts.size(); ++level) {
        EXPECT_TRUE(kLevels[level] >= below || firsts[level] == said) << level;
        EXPECT_TRUE(kLevels[level] != below || firsts[level] != said) << "it is so from there on already";
    }
}

/// What the sentence is, in a word, to count how often each was met.
std::string expect_true(std::string_view text, const ComparisonTable& table, const Firsts& firsts) {
    const std::set<size_t> leaders = leaders_of(firsts);
    if (text == "Too close to call") {
        EXPECT_TRUE(leaders.empty());
        return "close";
    }
    if (text.ends_with(" is better here")) {
        EXPECT_TRUE(is_best(table, firsts, take_row(text)));
        return "better";
    }
    if (text.ends_with(" is first wherever it is not too close to call")) {
        EXPECT_EQ(leaders, std::set{take_row(text)});
        return "wherever";
    }
    EXPECT_EQ(takes(text, "It depends on the error you need: "), leaders.size() > 1);
    if (takes(text, "the lead changes ")) {
        expect_changes(text, firsts);
        return "changes";
    }
    std::string lower(text);
    lower.front() = static_cast<char>(std::tolower(lower.front()));
    expect_stretches(lower, firsts);
    return std::to_string(leaders.size()) +
           (std::count(firsts.begin(), firsts.end(), std::nullopt) ? " with close" : "");
}

/// The parts that clients are given beside the sentence.
void expect_parts(const ComparisonTable& table, const Firsts& firsts, const Headline& headline) {
    size_t level = 0;
    for (const Stretch& stretch : headline.stretches) {
        EXPECT_EQ(stretch.easiest, kLevels[level]);
        for (; level < firsts.size() && kLevels[level] >= stretch.error; ++level) EXPECT_EQ(firsts[level], stretch.row);
        EXPECT_EQ(stretch.error, kLevels[level - 1]);
    }
    EXPECT_EQ(level, firsts.size());
    const std::set<size_t> leaders = leaders_of(firsts);
    EXPECT_EQ(headline.row, leaders.size() == 1 ? std::optional(*leaders.begin()) : firsts.back());
    EXPECT_EQ(headline.best, headline.row && is_best(table, firsts, *headline.row));

    const std::vector<Verdict> all = verdicts(table);
    const Verdict& shown = all.at(headline.verdict);
    EXPECT_TRUE(!headline.row || (!shown.close && shown.arrived[0] == *headline.row));
    for (size_t i = 0; i < all.size(); ++i) {
        if (headline.row && (all[i].close || all[i].arrived[0] != *headline.row)) continue;
        const bool tells = all[i].arrived.size() > 1, shown_tells = shown.arrived.size() > 1;
        EXPECT_TRUE(shown_tells > tells || (shown_tells == tells && i <= headline.verdict)) << i;
    }
}

/// Times rise with falling error until a row ends; rows keep near each other, so that the lead changes.
ComparisonTable random_table(std::mt19937& random) {
    const auto below = [&random](uint32_t end) { return static_cast<uint32_t>(random() % end); };
    const auto uniform = [&random] { return static_cast<double>(random()) / 4294967296.0; };
    const bool intervals = below(2) == 0;
    const double width = uniform() * uniform(), restless = 2 * uniform();
    const size_t levels = 1 + below(std::size(kLevels));
    ComparisonTable table{{kMetric}, {}};
    for (uint32_t row = 0, rows = 2 + below(3); row < rows; ++row) {
        const uint32_t before_first = below(4) == 0 ? below(5) : 0, reached = below(3) == 0 ? below(11) : 10;
        double seconds = std::exp(restless * uniform());
        std::vector<TimeToError> times;
        for (uint32_t level = 0; level < levels; ++level) {
            times.push_back({kLevels[level], {}, 1, level < before_first});
            seconds = std::max(seconds, std::exp(level + restless * 2 * uniform()));
            const double spread = std::exp(width * uniform());
            if (level < reached)
                times.back().seconds =
                    intervals ? SeedMean{seconds, seconds / spread, seconds * spread} : SeedMean{seconds, {}, {}};
        }
        table.rows.push_back(row_of(std::string(1, static_cast<char>('a' + row)), times));
    }
    return table;
}

TEST(Headline, IsTrueOfRandomTables) {
    std::mt19937 random(19);
    std::map<std::string, int> met;
    for (int i = 0; i < 5000 && !HasFailure(); ++i) {
        const ComparisonTable table = random_table(random);
        const Firsts firsts = firsts_of(table);
        const std::vector<Headline> found = headlines(table, verdicts(table));
        ASSERT_EQ(found.size(), firsts.empty() ? 0u : 1u);
        if (firsts.empty()) continue;
        const std::string text = headline_text(table, found[0]);
        SCOPED_TRACE("table " + std::to_string(i) + ": " + text);
        expect_parts(table, firsts, found[0]);
        ++met[expect_true(text, table, firsts)];
    }
    for (const char* kind : {"close", "better", "changes", "1 with close", "2", "2 with close", "3", "3 with close"})
        EXPECT_GT(met[kind], 50) << kind;
    EXPECT_GT(met["wherever"], 0);
}

}  // namespace
}  // namespace photond::headline_test
