#include "terminal/stages.hpp"

#include <system_error>
#include <utility>

#include <pthread.h>

#include "lamella/io/text_file.hpp"

namespace lamella::cli {

namespace {

constexpr int wake_up = SIGUSR1;  ///< sent by the destructor to its own thread

}  // namespace

Interrupt::Interrupt() {
    sigemptyset(&signals_);
    sigaddset(&signals_, wake_up);
    for (const int signal_number : {SIGINT, SIGTERM, SIGHUP}) {
        // A caller that ignores a signal (nohup, a shell's background jobs) means it for its children too.
        struct sigaction action {};
        if (::sigaction(signal_number, nullptr, &action) != 0 || action.sa_handler != SIG_IGN) {
            sigaddset(&signals_, signal_number);
        }
    }
    pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
    // A closed pipe and a file size limit become errors of write(), reported like a full disk.
    (void)std::signal(SIGPIPE, SIG_IGN);
    (void)std::signal(SIGXFSZ, SIG_IGN);
    try {
        waiter_ = std::thread([this] { wait_for_signals(); });
    } catch (const std::system_error& refused) {
        throw Failure(bad_input,
                      "cannot start a thread, as there are too many or too little memory: " + refused.code().message());
    }
}

Interrupt::~Interrupt() {
    finished_ = true;
    pthread_kill(waiter_.native_handle(), wake_up);
    waiter_.join();
}

void Interrupt::tidy(std::vector<std::filesystem::path> outputs) {
    const std::lock_guard lock(mutex_);
    outputs_ = std::move(outputs);
}

Callback<bool()> Interrupt::defer() noexcept {
    deferring_ = true;
    return {this, [](void* own) noexcept { return static_cast<Interrupt*>(own)->signal_ != 0; }};
}

void Interrupt::end_deferring() noexcept {
    deferring_ = false;
    die_if_interrupted();
}

void Interrupt::wait_for_signals() {
    int signal_number = 0;
    while (!finished_ && sigwait(&signals_, &signal_number) == 0) {
        if (signal_number == wake_up) {
            continue;
        }
        if (!deferring_ || signal_ != 0) {
            die_by(signal_number);
        }
        signal_ = signal_number;
    }
}

/// As if the signal had never been handled: shells and schedulers see its number in the exit status.
void Interrupt::die_by(int signal_number) noexcept {
    const std::lock_guard lock(mutex_);
    for (const std::filesystem::path& output : outputs_) {
        remove_unfinished(output);
    }
    complain("interrupted");
    sigset_t only;
    sigemptyset(&only);
    sigaddset(&only, signal_number);
    (void)std::signal(signal_number, SIG_DFL);
    pthread_sigmask(SIG_UNBLOCK, &only, nullptr);
    (void)::raise(signal_number);
}

void Interrupt::die_if_interrupted() noexcept {
    if (const int signal_number = signal_; signal_number != 0) {
        die_by(signal_number);
    }
}

}  // namespace lamella::cli
