// Runs the paper's lower bound experiment (3.5) on a series of search instances. Prints the comparisons made as JSON.
#include "lower_bound.hpp"
#include "timing.hpp"

namespace {

void run(const lamella::bench::Words&) {
    using namespace lamella::baselines;  // NOLINT(google-build-using-namespace)
    constexpr std::uint32_t n = 1 << 18;
    lamella::bench::Json series;
    for (std::uint32_t k = 1 << 4; k <= 1 << 18; k <<= 2) {
        const SearchInstance instance = make_search_instance(n, k);
        if (solution_of(incremental_slicing.slice(instance.problem()), n) != instance.solution) {
            lamella::bench::fail("the slicing does not solve the search");
        }
        const ComparisonCount count = count_comparisons(instance.problem());
        series.push_back({{"n", n}, {"k", k}, {"search", count.search}, {"sweep", count.sweep}});
    }
    lamella::bench::print(series);
}

}  // namespace

int main(int count, char** words) {
    return lamella::bench::run_program(count, words, "", run);
}
