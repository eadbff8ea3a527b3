#pragma once
// Whether two renderers that are one estimator, as the CPU's and the GPU's of a method, make images of one mean: block
// by block of pixels, from what their passes come to.
//
// Pixels of a block share photons, so a block is summed first and its variance is that between passes. Pass i of the
// one less pass i of the other, by other random numbers, is symmetric about 0 when both are the same estimator, however
// skewed that is (a few heavy splats), and also where passes are not alike (beams that shrink). The mean of n such
// differences over its standard error is a Student-t number of n - 1 degrees of freedom if they are normal. Symmetric
// ones with heavier tails pass far limits more rarely [Efron 1969]: to order 1 / n an excess kurtosis k takes
// k t (t^2 - 3) / (12 n) of the density at t from the tail [Hall 1987].
//
// Measured: sums of 8 x 8 pixels of the Cornell box have a skewness of 0.4 on average and 1.2 at most when splatted by
// connections, their differences a kurtosis of 3.1 and 4 at most (a normal number's is 3); where glossy walls send
// beams 1.1 and 9, 10 and 170.
//
// Blocks and channels depend upon one another, so each has the false-alarm rate over their number (Bonferroni). Passes
// must be independent: SamplerKind::Random. Sobol' points are spread over the passes, whose variance is then about
// twice what it would have to be for their mean: the test alarms more rarely than it says.
//
// [Efron 1969] Student's t-Test under Symmetry Conditions. JASA 64.
// [Hall 1987] Edgeworth Expansion for Student's t Statistic under Minimal Moment Conditions. Annals of Probability 15.

#include <algorithm>
#include <iomanip>
#include <sstream>
#include <stdexcept>
#include <string>

#include "tests/support/render.h"
#include "tests/support/statistics.h"

namespace photond::test {

/// What blocks of `side` x `side` pixels of the beauty sum up to, pass by pass. Pixels beyond the last whole block
/// count in none.
class BlockSums {
public:
    explicit BlockSums(uint32_t side) : side_(side) {}

    /// A film of one pass; all of one size.
    void add(const Film& pass) {
        const std::vector<float> beauty = pass.resolve_beauty();
        const Size2 size = pass.size();
        const uint32_t columns = size.width / side_, rows = size.height / side_;
        std::vector<double> sums(size_t{3} * columns * rows);
        for (uint32_t y = 0; y < rows * side_; ++y)
            for (uint32_t x = 0; x < columns * side_; ++x)
                for (uint32_t c = 0; c < 3; ++c)
                    sums[3 * (size_t{y / side_} * columns + x / side_) + c] +=
                        beauty[3 * (size_t{y} * size.width + x) + c];
        add(std::move(sums), columns);
    }
    /// A pass's sums: blocks row by row, the three channels of a block together.
    void add(std::vector<double> sums, uint32_t columns) {
        columns_ = columns;
        passes_.push_back(std::move(sums));
    }

    /// Appends the passes of another render with the same blocks.
    void add(const BlockSums& more) {
        columns_ = more.columns_;
        passes_.insert(passes_.end(), more.passes_.begin(), more.passes_.end());
    }

    uint32_t columns() const { return columns_; }
    const std::vector<std::vector<double>>& passes() const { return passes_; }

private:
    uint32_t side_, columns_ = 0;
    std::vector<std::vector<double>> passes_;
};

/// A film, and what its passes' blocks sum up to.
struct RenderedBlocks {
    Film film;
    BlockSums blocks;
};

/// Renders the settings' passes: of a Scene, or of a SceneOnDevice (gpu_render.h).
template <class Where, class M>
RenderedBlocks render_blocks(const Where& where, const RenderSettingsOf<M>& settings, uint32_t side) {
    RenderedBlocks rendered{Film(settings.size, settings.layers, settings.first_pass), BlockSums(side)};
    run_passes(where, settings, [&](M& method, uint32_t pass) {
        Film film(settings.size, settings.layers, pass);
        method.resolve(film);
        rendered.blocks.add(film);
        rendered.film.merge(film);
    });
    return rendered;
}

/// Mean of ((x - mean) / deviation)^power: 3 is the skewness, 4 the kurtosis (3 of a normal one). 0 where none differ.
inline double standardised_moment(const std::vector<double>& values, int power) {
    RunningMean mean;
    for (const double x : values) mean.add(x);
    const double deviation = std::sqrt(mean.variance());
    double sum = 0;
    for (const double x : values) sum += std::pow((x - mean.mean()) / deviation, power);
    return deviation > 0 ? sum / double(values.size()) : 0;
}

/// A block's channel in two renders.
struct BlockDifference {
    uint32_t column, row, channel;
    double mean;      // of the first render's passes
    double relative;  // the second's mean less that, over it
    double t;         // the difference over its standard error
    double noticed;   // least relative difference that is an alarm
    double skewness;  // of the first render's passes
    double kurtosis;  // of the passes' differences
};

struct BlockTest {
    std::vector<BlockDifference> blocks;  // the greatest |t| first
    size_t alarms = 0;
    double t_limit = 0;
    /// What half of the blocks' channels notice: a relative difference at most this large is an alarm there.
    double half_notice = 0;

    /// The first blocks as a table.
    std::string table(size_t rows = 8) const {
        std::ostringstream text;
        text << alarms << " of " << blocks.size() << " beyond |t| = " << t_limit << ", half notice " << half_notice
             << '\n'
             << "  column row channel      mean  relative       t   noticed  skewness  kurtosis of differences\n";
        for (size_t i = 0; i < std::min(rows, blocks.size()); ++i) {
            const BlockDifference& b = blocks[i];
            text << std::setprecision(3) << std::setw(8) << b.column << std::setw(4) << b.row << std::setw(8)
                 << b.channel << std::setw(10) << b.mean << std::setw(10) << b.relative << std::setw(8) << b.t
                 << std::setw(10) << b.noticed << std::setw(10) << b.skewness << std::setw(10) << b.kurtosis << '\n';
        }
        return text.str();
    }
};

/// Two renders of as many passes each, by other random numbers. A test that nothing is wrong with raises an alarm with
/// the probability `false_alarm`. Rounding is let pass: 1e-5 of the sum, where passes do not vary at all.
inline BlockTest compare_blocks(const BlockSums& a, const BlockSums& b, double false_alarm = 1e-6) {
    const size_t n = a.passes().size();
    if (n < 2 || n != b.passes().size() || a.passes()[0].size() != b.passes()[0].size())
        throw std::invalid_argument("the block test takes pairs of passes, two or more, with the same blocks");
    const size_t checks = a.passes()[0].size();
    BlockTest test;
    test.t_limit = two_sided_t(false_alarm / double(checks), double(n) - 1);
    std::vector<double> noticed, of_a(n), differences(n);
    for (uint32_t i = 0; i < checks; ++i) {
        RunningMean mean, difference;
        for (size_t pass = 0; pass < n; ++pass) {
            mean.add(of_a[pass] = a.passes()[pass][i]);
            difference.add(differences[pass] = b.passes()[pass][i] - of_a[pass]);
        }
        const double rounding = 1e-5 * std::fabs(mean.mean());
        const double tolerance = test.t_limit * difference.standard_error() + rounding;
        const auto over_mean = [&](double x) { return x == 0 ? 0 : x / mean.mean(); };
        const bool rounded = std::fabs(difference.mean()) <= rounding;
        test.alarms += !(std::fabs(difference.mean()) <= tolerance);
        test.blocks.push_back({i / 3 % a.columns(), i / 3 / a.columns(), i % 3, mean.mean(),
                               over_mean(difference.mean()),
                               rounded ? 0 : difference.mean() / difference.standard_error(), over_mean(tolerance),
                               standardised_moment(of_a, 3), standardised_moment(differences, 4)});
        noticed.push_back(over_mean(tolerance));
    }
    std::nth_element(noticed.begin(), noticed.begin() + std::ptrdiff_t(checks / 2), noticed.end());
    test.half_notice = noticed[checks / 2];
    std::sort(test.blocks.begin(), test.blocks.end(),
              [](const BlockDifference& p, const BlockDifference& q) { return std::fabs(p.t) > std::fabs(q.t); });
    return test;
}

/// How compare_blocks_when_sharp() looks at two renders while their passes come.
struct BlockLooks {
    uint32_t side;              // of a block [pixels]
    double must_notice;         // largest half_notice at which the comparison may stop
    double false_alarm = 1e-6;  // of all looks together
    uint32_t first_look = 16;   // passes
};

/// What two renders came to when they were sharp enough.
struct ComparedRenders {
    BlockTest test;   // of the last look
    Film first;       // the first render's passes until then
    uint32_t passes;  // their number
};

/// Compares two renders by compare_blocks() and stops as soon as half of the blocks would notice what must be noticed.
///
/// The looks are after `first_look` passes, 1.5 times as many, and so on; the last one is after all passes of the
/// settings. Each look has an equal part of the false-alarm rate (Bonferroni), so that the choice of when to stop does
/// not raise it. A look with an alarm ends the comparison. A stage begins the method anew: passes have to be pure
/// functions of their index. Where is a Scene or a SceneOnDevice.
template <class WhereA, class A, class WhereB, class B>
ComparedRenders compare_blocks_when_sharp(const WhereA& where_a, RenderSettingsOf<A> a, const WhereB& where_b,
                                          RenderSettingsOf<B> b, const BlockLooks& how) {
    if (a.passes != b.passes) throw std::invalid_argument("both renders need the same number of passes");
    std::vector<uint32_t> looks;
    for (uint32_t passes = how.first_look; passes < a.passes; passes += (passes + 1) / 2) looks.push_back(passes);
    looks.push_back(a.passes);
    const double share = how.false_alarm / double(looks.size());
    BlockSums of_a(how.side), of_b(how.side);
    ComparedRenders found{{}, Film(a.size, a.layers, a.first_pass), 0};
    for (const uint32_t look : looks) {
        a.passes = b.passes = look - found.passes;
        const RenderedBlocks more = render_blocks(where_a, a, how.side);
        of_a.add(more.blocks);
        of_b.add(render_blocks(where_b, b, how.side).blocks);
        found.first.merge(more.film);
        found.passes = look;
        a.first_pass += a.passes;
        b.first_pass += b.passes;
        found.test = compare_blocks(of_a, of_b, share);
        if (found.test.alarms > 0 || found.test.half_notice <= how.must_notice) break;
    }
    return found;
}

}  // namespace photond::test
