#pragma once
// The films of a comparison's row, from which bias and noise are told apart, and what has been measured of them.

#include <cstdint>
#include <string>
#include <vector>

#include "server/comparisons/table.h"
#include "server/service/comparison_judgement.h"

namespace photond {

struct RowFilms {
    std::vector<int64_t> jobs;        // seqs, one a seed
    std::vector<int64_t> references;  // of the two films
    /// Of all these and no others, a hash of the jobs' attempts and the references' seqs: what was measured of them is
    /// kept by it, and stays when films are removed. Empty where they are no films to tell bias and noise apart of.
    std::string name;
    std::string why_not;  // in words, where nothing can be measured, of these films or because there are none such

    bool measurable() const { return why_not.empty(); }
};

/// `row`: of the comparison's table.
RowFilms films_of_row(const Compared& compared, const TableRow& row);
/// The layers that a comparison's quadratic metrics are of, and the beauty.
std::vector<std::string> layers_of_bias(const Compared& compared);
/// Fills in TableRow::bias where anything of the row's films has been measured: of those of the table's metrics that
/// are mean squares; of an rmse, that of the mse whose root it is, under that name. Of no metric where none is either.
void add_biases(ComparisonTable& table, const Compared& compared);

}  // namespace photond
