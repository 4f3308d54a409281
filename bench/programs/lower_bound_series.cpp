// Runs the paper's lower bound experiment (3.5) on a series of search instances. Prints the comparisons made and n log2
// k as JSON.
#include <exception>
#include <iostream>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "lower_bound.hpp"
#include "slice_incremental.hpp"

int main() try {
    using namespace lamella::baselines;  // NOLINT(google-build-using-namespace)
    constexpr std::uint32_t n = 1 << 18;
    nlohmann::ordered_json series = nlohmann::ordered_json::array();
    for (std::uint32_t k = 1 << 4; k <= 1 << 18; k <<= 2) {
        const SearchInstance instance = make_search_instance(n, k, 1);
        const Problem problem = instance.problem();
        if (solution_of(incremental_slicing.slice(problem), n) != instance.solution) {
            throw std::runtime_error("the slicing does not solve the search");
        }
        const ComparisonCount count = count_comparisons(problem);
        series.push_back({{"n", n}, {"k", k}, {"least", count.least}, {"search", count.search}, {"sweep", count.sweep}});
    }
    std::cout << series.dump() << '\n';
    return 0;
} catch (const std::exception& failure) {
    std::cerr << "lamella_lower_bound: " << failure.what() << '\n';
    return 1;
}
