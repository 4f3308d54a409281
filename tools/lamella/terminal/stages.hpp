// A command as stages: the bar shows each, and SIGINT, SIGTERM and SIGHUP end it in an orderly way, so that nothing
// half-written stays behind.
#pragma once

#include <atomic>
#include <filesystem>
#include <mutex>
#include <string_view>
#include <thread>
#include <vector>

#include <csignal>

#include "lamella/context.hpp"
#include "terminal/console.hpp"

namespace lamella::cli {

/// While it lives, the signals are taken by a thread of its own. Construct it before any other thread, so that all of them
/// inherit the blocked signals.
class Interrupt {
public:
    Interrupt();  ///< throws Failure
    ~Interrupt();
    Interrupt(const Interrupt&) = delete;
    Interrupt& operator=(const Interrupt&) = delete;

    /// The files that will be written: what is unfinished of them goes with the process.
    void tidy(std::vector<std::filesystem::path> outputs);

    /// From here on a signal becomes a stop request; until here it ends the process, and so does always the second one. One
    /// that comes when all is written is too late: the command ends as it would have.
    Callback<bool()> defer() noexcept;

    /// From here on a signal ends the process again, and one that was deferred does so now.
    void end_deferring() noexcept;

    /// Ends the process as the deferred signal would have, if one came.
    void die_if_interrupted() noexcept;

private:
    void wait_for_signals();
    void die_by(int signal_number) noexcept;

    std::atomic<bool> deferring_ = false;
    std::atomic<bool> finished_ = false;
    std::atomic<int> signal_ = 0;
    sigset_t signals_{};
    std::mutex mutex_;  ///< of the outputs
    std::vector<std::filesystem::path> outputs_;
    std::thread waiter_;
};

/// While it lives, the bar shows one stage of a command.
class Stage {
public:
    Stage(ProgressBar& bar, std::string_view what) : bar_(bar), what_(what) { bar.show(what, 0); }
    ~Stage() { bar_.wipe(); }
    Stage(const Stage&) = delete;
    Stage& operator=(const Stage&) = delete;

    /// For the library's call; empty where no bar is shown.
    Callback<void(double)> progress() noexcept {
        return bar_.shown() ? Callback<void(double)>(*this) : Callback<void(double)>();
    }
    void operator()(double fraction) const noexcept { bar_.show(what_, fraction); }

private:
    ProgressBar& bar_;
    std::string_view what_;
};

class Stages {
public:
    Stages(ProgressBar::When progress, int threads, Interrupt& interrupt)
        : bar_(progress), threads_(threads), interrupt_(interrupt) {}

    /// Returns what `call` does, which takes a Context. From here on a signal is a stop request.
    template <class Call>
    auto run(std::string_view what, const Call& call) {
        Stage stage(bar_, what);
        return call(Context{.threads = threads_, .stop = interrupt_.defer(), .progress = stage.progress()});
    }

    /// The value that it makes; `ms` gets how long that takes. Throws Failure where it makes none.
    template <class Call>
    auto done(std::string_view what, const Call& call, double* ms = nullptr) {
        const Stopwatch watch;
        auto made = done_or_thrown(run(what, call));
        if (ms != nullptr) {
            *ms = watch.ms();
        }
        return made;
    }

    void warn(std::string_view text) {
        bar_.wipe();
        cli::warn(text);
    }

    ProgressBar& bar() noexcept { return bar_; }
    Interrupt& interrupt() noexcept { return interrupt_; }

private:
    ProgressBar bar_;
    int threads_;
    Interrupt& interrupt_;
};

}  // namespace lamella::cli
