#include "lamella/medical/record.hpp"

#include <cerrno>
#include <cstdio>
#include <set>
#include <system_error>

#include <nlohmann/json.hpp>

#include "base/guard.hpp"
#include "base/system/file.hpp"
#include "base/system/sha256.hpp"
#include "base/words.hpp"
#include "io/read/input_file.hpp"
#include "lamella/io/name_text.hpp"
#include "lamella/io/text_file.hpp"
#include "medical/geometry/common.hpp"

namespace lamella {

using Json = nlohmann::ordered_json;

// Found by nlohmann's lists of seals.
static void to_json(Json& json, const FileSeal& seal) {
    json = {{"path", text_of_name(seal.path)}, {"bytes", seal.bytes}, {"sha256", seal.sha256}};
}

static void from_json(const Json& json, FileSeal& seal) {
    seal = {name_of_text(json.at("path").get<std::string>()), json.at("bytes").get<std::uint64_t>(),
            json.at("sha256").get<std::string>()};
}

namespace {

constexpr std::uint64_t most_record_bytes = std::uint64_t{64} << 20;

/// Calls exchange(name, member) for all that a record's file says, in its order.
template <class Exchange>
void for_each_member(Record& record, Exchange exchange) {
    exchange("lamella", record.version);
    exchange("command", record.command);
    exchange("inputs", record.inputs);
    exchange("output", record.output);
    exchange("options", record.options);
    exchange("patient_frame", record.patient_frame);
    exchange("grid_mm", record.grid_mm);
    exchange("stitch_mm", record.stitch_mm);
    exchange("fill_rule", record.fill_rule);
    exchange("result_hashes", record.result_hashes);
    exchange("source_date_epoch", record.source_date_epoch);
}

std::string digest_text(const Sha256::Digest& digest) {
    std::string text;
    for (const unsigned char byte : digest) {
        text += hex_text(byte, 2);
    }
    return text;
}

[[noreturn]] void refuse_record(const std::filesystem::path& path, const std::string& why) {
    refuse_image(printable(path_text(path)), "no record of lamella: " + why);
}

/// Returns its bytes. Pipes are read, too, as `<(...)` of a shell are. Throws Refused (unreadable_file).
std::uint64_t add_file(const std::filesystem::path& path, Sha256& hash, const Context& context) {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(open_stream(path), &std::fclose);
    if (!file) {
        refuse_unreadable(printable(path_text(path)), errno);
    }
    const PacedStop stop(context.stop);
    std::uint64_t bytes = 0;
    std::vector<unsigned char> piece(std::size_t{1} << 16);
    while (const std::size_t count = std::fread(piece.data(), 1, piece.size(), file.get())) {
        stop.stop_if_asked();
        hash.add(piece.data(), count);
        bytes += count;
    }
    if (std::ferror(file.get()) != 0) {
        refuse_unreadable(printable(path_text(path)), errno);
    }
    return bytes;
}

}  // namespace

Result<FileSeal> seal_file(const std::filesystem::path& path, const Context& context, const ImageOptions& image) noexcept {
    return guarded(context, [&]() -> Result<FileSeal> {
        FileSeal seal{path_text(path), 0, {}};
        Sha256 hash;
        std::error_code unknown;
        if (!std::filesystem::is_directory(path, unknown)) {
            seal.bytes = add_file(path, hash, context);
            seal.sha256 = digest_text(hash.digest());
            return seal;
        }
        const ImageGeometry slices = read_dicom_folder(path, image.series_uid, context.stop);
        std::set<std::string> files;  // of which each may hold several slices
        for (const DicomSeries::Instance& slice : slices.series->slices) {
            if (!files.insert(slice.file).second) {
                continue;
            }
            Sha256 own;
            seal.bytes += add_file(path_of(slice.file), own, context);
            const Sha256::Digest digest = own.digest();
            hash.add(digest.data(), digest.size());
        }
        seal.sha256 = digest_text(hash.digest());
        return seal;
    });
}

Status write_record(const Record& record, const std::filesystem::path& path) noexcept {
    return guarded([&]() -> Status {
        Record as_text = record;
        for (std::string& option : as_text.options) {
            option = text_of_name(option);
        }
        Json json;
        for_each_member(as_text, [&](const char* name, const auto& value) { json[name] = value; });
        if (record.source_date_epoch.empty()) {
            json.erase("source_date_epoch");
        }
        return write_text_file(path, json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
    });
}

Result<Record> read_record(const std::filesystem::path& path) noexcept {
    return guarded([&]() -> Result<Record> {
        const InputFile file = require(InputFile::open(path));
        if (file.size() > most_record_bytes) {
            refuse_record(path, "larger than 64 MiB");
        }
        std::string text(static_cast<std::size_t>(file.size()), '\0');
        require(file.read_at(0, std::as_writable_bytes(std::span(text))));
        try {
            Json json = Json::parse(text);
            json.emplace("stitch_mm", Json::array());  // which records of earlier versions lack
            json.emplace("source_date_epoch", "");
            Record record;
            for_each_member(record, [&](const char* name, auto& value) { json.at(name).get_to(value); });
            for (std::string& option : record.options) {
                option = name_of_text(option);
            }
            return record;
        } catch (const nlohmann::json::parse_error& error) {
            refuse_record(path, "not JSON at byte " + std::to_string(error.byte));
        } catch (const nlohmann::json::exception&) {
            refuse_record(path, "a member is missing or of another type");
        }
    });
}

}  // namespace lamella
