#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include <fcntl.h>
#include <io.h>

#include "base/system/file.hpp"
#include "base/system/windows.hpp"
#include "system/terminal.hpp"

#include <shellapi.h>

namespace lamella::cli {

namespace {

constexpr DWORD escape_sequences = 4;  // ENABLE_VIRTUAL_TERMINAL_PROCESSING, which older headers lack

/// Of a name, in which case does not count.
bool matches(std::wstring_view name, std::wstring_view pattern) {
    if (pattern.empty() || name.empty()) {
        return name.empty() && pattern.find_first_not_of(L'*') == std::wstring_view::npos;
    }
    if (pattern.front() == L'*') {
        return matches(name, pattern.substr(1)) || matches(name.substr(1), pattern);
    }
    return (pattern.front() == L'?' || ::towlower(pattern.front()) == ::towlower(name.front())) &&
           matches(name.substr(1), pattern.substr(1));
}

UINT earlier_code_page = CP_UTF8;

}  // namespace

std::vector<std::string> begin_program(int /*count*/, char** /*words*/) {
    for (const int stream : {0, 1, 2}) {
        (void)::_setmode(stream, _O_BINARY);
    }
    earlier_code_page = ::GetConsoleOutputCP();
    ::SetConsoleOutputCP(CP_UTF8);
    (void)std::atexit([] { ::SetConsoleOutputCP(earlier_code_page); });  // The console is the caller's, too.
    int count = 0;
    wchar_t** const typed = ::CommandLineToArgvW(::GetCommandLineW(), &count);
    std::vector<std::string> words;
    for (int i = 1; i < count; ++i) {
        words.push_back(path_text(typed[i]));
    }
    ::LocalFree(typed);
    return words;
}

bool is_terminal() {
    const HANDLE console = ::GetStdHandle(STD_ERROR_HANDLE);
    DWORD mode = 0;
    return ::GetConsoleMode(console, &mode) != 0 && ::SetConsoleMode(console, mode | escape_sequences) != 0;
}

int check_standard_output() noexcept {
    return File().duplicate(1);
}

void write_error(std::string_view text) noexcept {
    DWORD written = 0;
    ::WriteFile(::GetStdHandle(STD_ERROR_HANDLE), text.data(), static_cast<DWORD>(text.size()), &written, nullptr);
}

void set_environment(const char* name, const std::string& value) {
    (void)::_putenv_s(name, value.c_str());
}

void explain_bus_errors(std::string /*line*/, int /*exit_status*/) {}

std::optional<std::vector<std::string>> expand_glob(const std::string& pattern) {
    const std::filesystem::path path = path_of(pattern);
    const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
    std::vector<std::string> found;
    std::error_code problem;
    for (std::filesystem::directory_iterator at(system_path(folder), problem), end; !problem && at != end;
         at.increment(problem)) {
        const std::filesystem::path name = at->path().filename();
        if (matches(name.native(), path.filename().native())) {
            found.push_back(path_text(path.has_parent_path() ? folder / name : name));
        }
    }
    std::sort(found.begin(), found.end());
    return problem || !can_list(folder) ? std::nullopt : std::optional(found);
}

}  // namespace lamella::cli
