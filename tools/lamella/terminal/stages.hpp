// A command as stages: the bar shows each, and a signal ends it.
#pragma once

#include <string>
#include <string_view>

#include "lamella/control.hpp"
#include "terminal/console.hpp"
#include "terminal/failure.hpp"
#include "terminal/interrupt.hpp"

namespace lamella::cli {

/// While it lives, the bar shows one stage of a command.
class Stage {
public:
    Stage(ProgressBar& bar, std::string_view what) : show_{bar, what} { bar.show(what, 0); }
    ~Stage() { show_.bar.wipe(); }
    Stage(const Stage&) = delete;
    Stage& operator=(const Stage&) = delete;

    /// For the library's call; empty where no bar is shown.
    Progress progress() const noexcept { return show_.bar.shown() ? Progress::to(show_) : Progress{}; }

private:
    struct Show {
        ProgressBar& bar;
        std::string_view what;
        void operator()(double fraction) const noexcept { bar.show(what, fraction); }
    };

    Show show_;
};

class Stages {
public:
    Stages(ProgressBar::When progress, int threads, Interrupt& interrupt)
        : bar_(progress), threads_(threads), interrupt_(interrupt) {}

    /// Returns what `call` does, which takes a Control. From here on a signal is a stop request.
    template <class Call>
    auto run(std::string_view what, const Call& call) {
        const Stage stage(bar_, what);
        return call(Control{.threads = threads_, .stop = interrupt_.defer(), .progress = stage.progress()});
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
