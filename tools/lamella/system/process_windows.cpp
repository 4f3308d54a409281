#include <array>
#include <bit>
#include <filesystem>
#include <mutex>
#include <system_error>
#include <thread>

#include "base/system/file.hpp"
#include "base/system/machine.hpp"
#include "base/system/windows.hpp"
#include "system/process.hpp"

#define PSAPI_VERSION 2
#include <psapi.h>

namespace lamella::cli {

namespace {

HANDLE as_handle(std::intptr_t handle) noexcept {
    return reinterpret_cast<HANDLE>(handle);
}

[[noreturn]] void fail() {
    throw std::system_error(static_cast<int>(::GetLastError()), std::system_category());
}

struct SignalTarget {
    void (*take)(void* own, int number) = nullptr;
    void* own = nullptr;
} signal_target;

BOOL CALLBACK take_console_event(DWORD event) {
    signal_target.take(signal_target.own, static_cast<int>(event) + 1);
    if (event >= CTRL_CLOSE_EVENT) {  // The system ends the process when this returns, or after five seconds.
        ::Sleep(INFINITE);
    }
    return TRUE;
}

/// By which the starter of a process asks it to end. Whoever is first makes it.
HANDLE stop_event(DWORD process) {
    return ::CreateEventW(nullptr, TRUE, FALSE, (L"Local\\lamella-stop-" + std::to_wstring(process)).c_str());
}

/// Its processes end when it is closed, which the system does at the end of this process.
HANDLE job_of_children() {
    static const HANDLE job = [] {
        const HANDLE made = ::CreateJobObjectW(nullptr, nullptr);
        JOBOBJECT_EXTENDED_LIMIT_INFORMATION limits{};
        limits.BasicLimitInformation.LimitFlags = JOB_OBJECT_LIMIT_KILL_ON_JOB_CLOSE;
        ::SetInformationJobObject(made, JobObjectExtendedLimitInformation, &limits, sizeof limits);
        return made;
    }();
    return job;
}

std::wstring program_of(HANDLE process) {
    std::wstring name(std::size_t{1} << 15, 0);
    auto size = static_cast<DWORD>(name.size());
    name.resize(::QueryFullProcessImageNameW(process, 0, name.data(), &size) != 0 ? size : 0);
    return name;
}

/// As CommandLineToArgvW() takes it apart: before a quote, backslashes count double.
void append_quoted(std::wstring& line, const std::string& word) {
    line += line.empty() ? L"\"" : L" \"";
    std::size_t backslashes = 0;
    const std::filesystem::path text = path_of(word);
    for (const wchar_t c : text.native()) {
        line.append(c == L'"' ? backslashes + 1 : 0, L'\\');
        backslashes = c == L'\\' ? backslashes + 1 : 0;
        line += c;
    }
    line.append(backslashes, L'\\') += L'"';
}

/// Starts the program with its output in that pipe, and closes this process's end of it. False where that fails.
bool start(std::wstring& line, const std::string& folder, HANDLE output, PROCESS_INFORMATION& started) {
    constexpr DWORD flags = CREATE_NEW_PROCESS_GROUP | CREATE_SUSPENDED;
    STARTUPINFOW startup{};
    startup.cb = sizeof startup;
    startup.dwFlags = STARTF_USESTDHANDLES;
    startup.hStdOutput = output;
    startup.hStdError = output;
    const std::wstring program = program_of(::GetCurrentProcess());
    const std::wstring there = path_of(folder).native();
    const bool done = ::CreateProcessW(program.c_str(), line.data(), nullptr, nullptr, TRUE, flags, nullptr,
                                       there.empty() ? nullptr : there.c_str(), &startup, &started) != 0;
    const DWORD failure = ::GetLastError();
    ::CloseHandle(output);
    ::SetLastError(failure);
    return done;
}

}  // namespace

void take_signals(void (*take)(void* own, int number), void* own) {
    signal_target = {take, own};
    ::SetConsoleCtrlHandler(take_console_event, TRUE);
}

void end_by_signal(int /*number*/) noexcept {
    ::TerminateProcess(::GetCurrentProcess(), STATUS_CONTROL_C_EXIT);
}

ChildProcess::ChildProcess(std::vector<std::string> words, const std::string& folder, int /*exit_status_of_no_program*/) {
    words.insert(words.begin(), "lamella");
    words.insert(words.begin() + 2, "--worker=" + std::to_string(process_number()));
    std::wstring line;
    for (const std::string& word : words) {
        append_quoted(line, word);
    }
    // Handles that can be inherited are by each process that starts meanwhile, and would keep this one's output open.
    static std::mutex one_at_a_time;
    const std::lock_guard lock(one_at_a_time);
    HANDLE reading = nullptr;
    HANDLE writing = nullptr;
    PROCESS_INFORMATION started{};
    if (::CreatePipe(&reading, &writing, nullptr, 0) == 0) {
        fail();
    }
    ::SetHandleInformation(writing, HANDLE_FLAG_INHERIT, HANDLE_FLAG_INHERIT);
    if (!start(line, folder, writing, started)) {
        ::CloseHandle(reading);
        fail();
    }
    output_ = reinterpret_cast<std::intptr_t>(reading);
    process_ = reinterpret_cast<std::intptr_t>(started.hProcess);
    stop_ = reinterpret_cast<std::intptr_t>(stop_event(started.dwProcessId));
    ::AssignProcessToJobObject(job_of_children(), started.hProcess);
    ::ResumeThread(started.hThread);
    ::CloseHandle(started.hThread);
}

ChildProcess::~ChildProcess() {
    for (const std::intptr_t handle : {output_, process_, stop_}) {
        ::CloseHandle(as_handle(handle));
    }
}

bool ChildProcess::read_output(std::string& text, std::chrono::milliseconds longest) {
    DWORD count = 0;
    // A pipe cannot be waited for so long, but the process can.
    if (::PeekNamedPipe(as_handle(output_), nullptr, 0, nullptr, &count, nullptr) != 0 && count == 0) {
        ::WaitForSingleObject(as_handle(process_), static_cast<DWORD>(longest.count()));
    }
    if (::PeekNamedPipe(as_handle(output_), nullptr, 0, nullptr, &count, nullptr) == 0) {
        return false;
    }
    std::array<char, 4096> piece{};
    if (count > 0 && ::ReadFile(as_handle(output_), piece.data(), static_cast<DWORD>(piece.size()), &count, nullptr) != 0) {
        text.append(piece.data(), count);
    }
    return true;
}

void ChildProcess::ask_to_end() noexcept {
    ::SetEvent(as_handle(stop_));
}

void ChildProcess::kill() noexcept {
    ::TerminateProcess(as_handle(process_), STATUS_CONTROL_C_EXIT);
}

ProcessOutcome ChildProcess::wait() {
    ::WaitForSingleObject(as_handle(process_), INFINITE);
    DWORD status = 0;
    ::GetExitCodeProcess(as_handle(process_), &status);
    PROCESS_MEMORY_COUNTERS memory{};
    ::GetProcessMemoryInfo(as_handle(process_), &memory, sizeof memory);
    ProcessOutcome outcome{.exit_status = static_cast<int>(status), .peak_bytes = memory.PeakWorkingSetSize};
    constexpr DWORD first_exception = 0xC0000000;
    if (status >= first_exception) {
        outcome.crash = "ended by exception " + std::to_string(status);
    }
    return outcome;
}

bool end_with(std::uint64_t /*starter*/) {  // The job of the starter sees to that.
    std::thread([event = stop_event(::GetCurrentProcessId())] {
        ::WaitForSingleObject(event, INFINITE);
        take_console_event(CTRL_BREAK_EVENT);
    }).detach();
    return true;
}

std::filesystem::path program_path() {
    return program_of(::GetCurrentProcess());
}

bool runs_this_program(std::uint64_t process) {
    const HANDLE other = ::OpenProcess(PROCESS_QUERY_LIMITED_INFORMATION | SYNCHRONIZE, FALSE, static_cast<DWORD>(process));
    const bool runs = other != nullptr && process != process_number() && ::WaitForSingleObject(other, 0) != WAIT_OBJECT_0 &&
                      program_of(other) == program_of(::GetCurrentProcess());
    ::CloseHandle(other);
    return runs;
}

std::uint64_t peak_rss_bytes() {
    PROCESS_MEMORY_COUNTERS memory{};
    ::GetProcessMemoryInfo(::GetCurrentProcess(), &memory, sizeof memory);
    return memory.PeakWorkingSetSize;
}

int granted_processors() {
    DWORD_PTR own = 0;
    DWORD_PTR all = 0;
    return ::GetProcessAffinityMask(::GetCurrentProcess(), &own, &all) != 0 ? std::popcount(std::uint64_t{own}) : 1;
}

std::uint64_t free_memory_bytes() {
    MEMORYSTATUSEX memory{};
    memory.dwLength = sizeof memory;
    return ::GlobalMemoryStatusEx(&memory) != 0 ? memory.ullAvailPhys : 0;
}

}  // namespace lamella::cli
