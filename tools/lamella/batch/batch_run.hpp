// A batch from its plan to its end.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "batch/admission/admission.hpp"
#include "batch/plan/item.hpp"
#include "batch/progress/batch_progress.hpp"
#include "batch/progress/batch_summary.hpp"
#include "batch/results/ledger.hpp"
#include "processes/worker_pool.hpp"
#include "terminal/interrupt.hpp"

namespace lamella::cli::batch {

struct RunOptions {
    int jobs = 1;
    std::uint64_t memory_bytes = 0;
    double timeout_s = 0;
    int retries = 1;
    bool force = false;
    bool hash = false;
    std::vector<std::string> names_without_memory{};  ///< options that a mesh larger than all of it cannot have
    ProgressBar::When progress = ProgressBar::When::automatic;
};

class BatchRun {
public:
    /// `items` are those of this shard. Throws Failure.
    BatchRun(std::vector<Item> items, const LedgerName& name, const RunOptions& options, Interrupt& interrupt);

    /// Slices what is not done. Throws Failure where results cannot be kept.
    void run();

    std::string summary() const;
    std::size_t failed() const noexcept { return failed_.size(); }

private:
    void clean(std::chrono::milliseconds patience) const;
    void choose_items();
    bool is_unchanged(std::size_t i);
    std::string why_not_in_memory(std::size_t i) const;
    void start_what_fits();
    void start(const Admitted& admitted);
    std::vector<std::string> words_of(const Item& item, const Admitted& admitted) const;
    void take(const WorkerEnd& end);
    void fail(std::size_t i, const std::string& reason);
    void remove_new_outputs(const Item& item, std::size_t i) const;
    void stop_if_asked();

    std::vector<Item> items_;
    RunOptions options_;
    Interrupt& interrupt_;
    StopCheck stop_;
    Ledger ledger_;
    Admission admission_;
    BatchProgress progress_;
    BatchCounts counts_;
    std::vector<int> attempts_;                              ///< by item
    std::vector<std::vector<std::uint64_t>> output_inodes_;  ///< by item: of its outputs, when it began
    std::vector<std::pair<std::size_t, FailedItem>> failed_;
    WorkerPool pool_;  ///< the last member: its processes end before what they are recorded in
};

}  // namespace lamella::cli::batch
