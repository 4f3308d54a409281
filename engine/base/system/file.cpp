#include "base/system/file.hpp"

#include <cerrno>
#include <chrono>

namespace lamella {

int error_number_of(const std::error_code& error) noexcept {
    const std::error_condition portable = error.default_error_condition();
    return portable.category() == std::generic_category() ? portable.value() : EIO;
}

std::filesystem::path path_of(std::string_view text) {
    return std::u8string(text.begin(), text.end());
}

int make_unique(const std::filesystem::path& prefix, std::string_view suffix, std::filesystem::path& made,
                FunctionRef<int(const std::filesystem::path&)> make) {
    constexpr int most_attempts = 100;
    const auto now = std::chrono::steady_clock::now().time_since_epoch().count();
    int failure = EEXIST;
    for (int attempt = 0; attempt < most_attempts && failure == EEXIST; ++attempt) {
        made = prefix;
        made += std::to_string(now + attempt).append(suffix);
        failure = make(made);
    }
    return failure;
}

int File::create_unique(const std::filesystem::path& prefix, std::string_view suffix, unsigned mode,
                        std::filesystem::path& made) {
    return make_unique(prefix, suffix, made, [&](const std::filesystem::path& path) { return create(path, mode); });
}

}  // namespace lamella
