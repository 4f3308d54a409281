#include "batch/workers/worker_starter.hpp"

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <new>
#include <system_error>

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "lamella/medical/record.hpp"
#include "worker/worker_side.hpp"

namespace lamella::cli::batch {

namespace {

Failure starter_is_gone() {
    return {bad_input, "the process that starts the others was ended"};
}

enum class Task : std::uint32_t { start, wait, look };

struct Request {
    Task task = Task::start;
    pid_t worker = 0;      ///< to wait for or to look at
    std::size_t size = 0;  ///< of the text that follows, to start one
};

struct Answer {
    int error_number = 0;
    pid_t worker = 0;  ///< 0: it still runs
    WorkerStarter::End end;
};

/// Descriptors that travel with a request.
struct Channels {
    int facts = -1;
    int messages = -1;
};

void close_all(const Channels& channels) noexcept {
    for (const int descriptor : {channels.facts, channels.messages}) {
        if (descriptor >= 0) {
            ::close(descriptor);
        }
    }
}

bool send_all(int socket, const void* data, std::size_t size) noexcept {
    const char* at = static_cast<const char*>(data);
    while (size > 0) {
        const ssize_t sent = ::send(socket, at, size, MSG_NOSIGNAL);
        if (sent < 0 && errno == EINTR) {
            continue;
        }
        if (sent <= 0) {
            return false;
        }
        at += sent;
        size -= static_cast<std::size_t>(sent);
    }
    return true;
}

bool receive_all(int socket, void* data, std::size_t size) noexcept {
    char* at = static_cast<char*>(data);
    while (size > 0) {
        const ssize_t received = ::recv(socket, at, size, MSG_WAITALL);
        if (received < 0 && errno == EINTR) {
            continue;
        }
        if (received <= 0) {
            return false;
        }
        at += received;
        size -= static_cast<std::size_t>(received);
    }
    return true;
}

/// A request with its descriptors, as the system's messages carry them.
struct Message {
    Request request;
    iovec piece{&request, sizeof(request)};
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(Channels))> space{};
    msghdr header{};

    Message() {
        header.msg_iov = &piece;
        header.msg_iovlen = 1;
        header.msg_control = space.data();
        header.msg_controllen = space.size();
    }
    ~Message() = default;
    Message(const Message&) = delete;
    Message& operator=(const Message&) = delete;

    void put(const Channels& channels) {
        cmsghdr* const control = CMSG_FIRSTHDR(&header);
        control->cmsg_level = SOL_SOCKET;
        control->cmsg_type = SCM_RIGHTS;
        control->cmsg_len = CMSG_LEN(sizeof(Channels));
        std::memcpy(CMSG_DATA(control), &channels, sizeof(Channels));
    }

    Channels take() const {
        Channels channels;
        const cmsghdr* const control = CMSG_FIRSTHDR(&header);
        if (control != nullptr && control->cmsg_type == SCM_RIGHTS && control->cmsg_len == CMSG_LEN(sizeof(Channels))) {
            std::memcpy(&channels, CMSG_DATA(control), sizeof(Channels));
        }
        return channels;
    }
};

// Of a call, each string with a zero byte behind it: folder, "=" and date of build or nothing, command, words.

std::string text_of_call(const WorkerCall& call) {
    std::string text =
        call.folder + '\0' + (call.date_of_build ? "=" + *call.date_of_build : "") + '\0' + call.command + '\0';
    for (const std::string& word : call.words) {
        text += word + '\0';
    }
    return text;
}

WorkerCall call_of_text(const std::string& text) {
    std::vector<std::string> strings;
    for (std::size_t begin = 0; begin < text.size();) {
        strings.emplace_back(text.c_str() + begin);
        begin += strings.back().size() + 1;
    }
    WorkerCall call{strings.at(2), {strings.begin() + 3, strings.end()}, strings[0]};
    if (!strings[1].empty()) {
        call.date_of_build = strings[1].substr(1);
    }
    return call;
}

/// The starter's side: forks, and waits for what it forked.
class Starter {
public:
    Starter(int socket, int nothing, WorkerStarter::Main main) : socket_(socket), nothing_(nothing), main_(main) {
        sigset_t ends;
        sigemptyset(&ends);
        for (const int signal_number : {SIGINT, SIGTERM, SIGHUP}) {
            sigaddset(&ends, signal_number);
        }
        // A scheduler asks all processes of a job to end at the same time. The batch then needs this one to end its workers.
        (void)::sigprocmask(SIG_BLOCK, &ends, &before_);
        // Where it is ignored, nobody learns how a process ended.
        (void)std::signal(SIGCHLD, SIG_DFL);
        // A descriptor that comes later is no standard stream that is closed.
        int filled = 0;
        do {
            filled = ::dup(nothing_);
        } while (filled >= 0 && filled <= STDERR_FILENO);
        ::close(filled);
        // Once for all workers: libcrypto sets itself up at its first digest.
        (void)seal_file("/dev/null");
    }

    [[noreturn]] void serve() noexcept {
        while (true) {
            Message message;
            const ssize_t received = ::recvmsg(socket_, &message.header, MSG_WAITALL | MSG_CMSG_CLOEXEC);
            if (received < 0 && errno == EINTR) {
                continue;
            }
            if (received != static_cast<ssize_t>(sizeof(Request))) {
                ::_exit(0);  // The batch has ended.
            }
            const Channels channels = message.take();
            const Answer answer =
                message.request.task == Task::start ? started(message.request, channels) : ended(message.request);
            close_all(channels);
            if (!send_all(socket_, &answer, sizeof(answer))) {
                ::_exit(0);
            }
        }
    }

private:
    Answer started(const Request& request, const Channels& channels) noexcept {
        Answer answer;
        try {
            std::string text(request.size, '\0');
            if (!receive_all(socket_, text.data(), text.size())) {
                ::_exit(0);
            }
            const WorkerCall call = call_of_text(text);
            const pid_t starter = ::getpid();
            answer.worker = ::fork();
            if (answer.worker == 0) {
                work(call, channels, starter);
            }
            answer.error_number = answer.worker < 0 ? errno : 0;
        } catch (const std::bad_alloc&) {
            answer.error_number = ENOMEM;
        }
        return answer;
    }

    static Answer ended(const Request& request) noexcept {
        Answer answer;
        do {
            answer.worker =
                ::wait4(request.worker, &answer.end.status, request.task == Task::look ? WNOHANG : 0, &answer.end.used);
        } while (answer.worker < 0 && errno == EINTR);
        answer.error_number = answer.worker < 0 ? errno : 0;
        return answer;
    }

    /// In the new process, which ends here whatever happens.
    [[noreturn]] void work(const WorkerCall& call, const Channels& channels, pid_t starter) noexcept {
        (void)::setpgid(0, 0);
        ::dup2(nothing_, STDIN_FILENO);
        ::dup2(nothing_, STDOUT_FILENO);
        ::dup2(channels.messages, STDERR_FILENO);
        for (const int descriptor : {socket_, nothing_, channels.messages}) {
            ::close(descriptor);
        }
        if (!call.folder.empty() && ::chdir(call.folder.c_str()) != 0) {
            ::_exit(bad_input);
        }
        if (call.date_of_build) {
            constexpr const char* name = "SOURCE_DATE_EPOCH";
            (void)(call.date_of_build->empty() ? ::unsetenv(name) : ::setenv(name, call.date_of_build->c_str(), 1));
        }
        std::vector<std::string> words = {"lamella", call.command, worker_word(channels.facts, starter)};
        words.insert(words.end(), call.words.begin(), call.words.end());
        std::vector<char*> pointers;
        pointers.reserve(words.size() + 1);
        for (std::string& word : words) {
            pointers.push_back(word.data());
        }
        pointers.push_back(nullptr);
        (void)::sigprocmask(SIG_SETMASK, &before_, nullptr);
        // Tidying up at an exit would copy the memory that it touches. Nothing waits in a buffer: stdout leads nowhere.
        ::_exit(main_(static_cast<int>(words.size()), pointers.data()));
    }

    int socket_;
    int nothing_;  ///< /dev/null
    WorkerStarter::Main main_;
    sigset_t before_{};  ///< signals that the batch was started with blocked
};

/// Makes no descriptor take the place of a standard stream that is closed.
int above_streams(int descriptor) {
    const int above = ::fcntl(descriptor, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    const int error_number = errno;
    ::close(descriptor);
    if (above < 0) {
        throw no_process(error_number);
    }
    return above;
}

}  // namespace

Failure no_process(int error_number) {
    return {bad_input, "cannot start a process for a mesh: " + std::generic_category().message(error_number)};
}

WorkerStarter::WorkerStarter(Main main) {
    const int nothing = above_streams(::open("/dev/null", O_RDWR | O_CLOEXEC));
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
        throw no_process(errno);
    }
    const pid_t batch = ::getpid();
    starter_ = ::fork();
    if (starter_ < 0) {
        throw no_process(errno);
    }
    if (starter_ == 0) {
        (void)::prctl(PR_SET_PDEATHSIG, SIGKILL);
        if (::getppid() != batch) {  // It ended before.
            ::_exit(bad_input);
        }
        (void)::setpgid(0, 0);
        ::close(ends[0]);
        Starter(above_streams(ends[1]), nothing, main).serve();
    }
    ::close(ends[1]);
    ::close(nothing);
    socket_ = above_streams(ends[0]);
}

WorkerStarter::~WorkerStarter() {
    ::close(socket_);
    while (::waitpid(starter_, nullptr, 0) < 0 && errno == EINTR) {
    }
}

pid_t WorkerStarter::start(const WorkerCall& call, int facts, int messages) {
    const std::string text = text_of_call(call);
    Message message;
    message.request.size = text.size();
    message.put({facts, messages});
    Answer answer;
    const bool sent = ::sendmsg(socket_, &message.header, MSG_NOSIGNAL) == static_cast<ssize_t>(sizeof(Request));
    if (!sent || !send_all(socket_, text.data(), text.size()) || !receive_all(socket_, &answer, sizeof(answer))) {
        throw starter_is_gone();
    }
    if (answer.error_number != 0) {
        throw no_process(answer.error_number);
    }
    return answer.worker;
}

std::optional<WorkerStarter::End> WorkerStarter::end_of(pid_t worker, bool wait) {
    const Request request{wait ? Task::wait : Task::look, worker};
    Answer answer;
    if (!send_all(socket_, &request, sizeof(request)) || !receive_all(socket_, &answer, sizeof(answer)) ||
        answer.error_number != 0) {
        throw starter_is_gone();
    }
    return answer.worker == 0 ? std::nullopt : std::optional(answer.end);
}

}  // namespace lamella::cli::batch
