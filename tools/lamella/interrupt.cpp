#include "interrupt.hpp"

#include <pthread.h>

#include "console.hpp"

namespace lamella::cli {

namespace {

constexpr int wake_up = SIGUSR1;  ///< sent by the destructor to its own thread

/// A caller that ignores a signal (nohup, a shell's background jobs) means it for its children too.
bool ignored(int signal_number) noexcept {
    struct sigaction action {};
    return ::sigaction(signal_number, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

/// As if the signal had never been handled: shells and schedulers see its number in the exit status.
void die_by(int signal_number) noexcept {
    complain("interrupted");
    sigset_t only;
    sigemptyset(&only);
    sigaddset(&only, signal_number);
    (void)std::signal(signal_number, SIG_DFL);
    pthread_sigmask(SIG_UNBLOCK, &only, nullptr);
    (void)::raise(signal_number);
}

}  // namespace

Interrupt::Interrupt() {
    sigemptyset(&signals_);
    sigaddset(&signals_, wake_up);
    for (const int signal_number : {SIGINT, SIGTERM, SIGHUP}) {
        if (!ignored(signal_number)) {
            sigaddset(&signals_, signal_number);
        }
    }
    pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
    // A closed pipe and a file size limit become errors of write(), reported like a full disk.
    (void)std::signal(SIGPIPE, SIG_IGN);
    (void)std::signal(SIGXFSZ, SIG_IGN);
    waiter_ = std::thread([this] { wait_for_signals(); });
}

Interrupt::~Interrupt() {
    finished_ = true;
    pthread_kill(waiter_.native_handle(), wake_up);
    waiter_.join();
}

std::stop_token Interrupt::defer() noexcept {
    deferring_ = true;
    return source_.get_token();
}

void Interrupt::wait_for_signals() {
    int signal_number = 0;
    while (!finished_ && sigwait(&signals_, &signal_number) == 0) {
        if (signal_number == wake_up) {
            continue;
        }
        if (!deferring_) {
            die_by(signal_number);
        }
        signal_ = signal_number;
        source_.request_stop();
    }
}

void Interrupt::die_if_interrupted() const noexcept {
    if (const int signal_number = signal_; signal_number != 0) {
        die_by(signal_number);
    }
}

}  // namespace lamella::cli
