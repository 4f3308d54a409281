// 3MF packages whose zip archive states sizes and offsets in ZIP64 fields, in every combination that writers use.
#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <fstream>

#include <catch2/catch.hpp>

#include "cpu_time.hpp"
#include "files.hpp"
#include "lamella/io/mesh_file.hpp"
#include "read.hpp"
#include "zip.hpp"

namespace lamella {
namespace {

using namespace input_test;

constexpr std::uint32_t in_extra_field = 0xFFFFFFFF;

std::string little_endian64(std::uint64_t value) {
    return little_endian(static_cast<std::uint32_t>(value)) + little_endian(static_cast<std::uint32_t>(value >> 32));
}

std::string extra_field(const std::string& numbers) {
    return numbers.empty()
               ? numbers
               : "\1" + std::string(1, '\0') + little_endian16(static_cast<std::uint16_t>(numbers.size())) + numbers;
}

enum class Descriptor { none, short_sizes, long_sizes };

/// Which fields are ZIP64's.
struct Zip64 {
    bool local = false;
    bool directory_sizes = false;
    bool directory_offset = false;
    bool end_record = true;
    bool all_in_directory = false;  ///< the directory's extra field that holds the sizes holds offset and disk too
    Descriptor descriptor = Descriptor::none;
};

std::string words_of(const Zip64& zip64, bool deflated) {
    return std::string("ZIP64 in") + (zip64.local ? " the local header" : "") + (zip64.directory_sizes ? " sizes" : "") +
           (zip64.directory_offset ? " offset" : "") + (zip64.end_record ? " end record" : "") +
           (zip64.all_in_directory ? " all" : "") + (deflated ? ", deflated" : ", stored") + ", descriptor " +
           std::to_string(static_cast<int>(zip64.descriptor));
}

class Zip64Writer {
public:
    explicit Zip64Writer(const Zip64& zip64) : zip64_(zip64) {}

    void add(const ZipPart& part) {
        const std::string packed = part.deflated ? deflated(part.contents) : part.contents;
        const auto crc = static_cast<std::uint32_t>(
            crc32(0, reinterpret_cast<const Bytef*>(part.contents.data()), static_cast<uInt>(part.contents.size())));
        const bool described = zip64_.descriptor != Descriptor::none;
        const std::uint64_t offset = bytes_.size() + hole_bytes_;
        list(part, crc, packed.size(), part.contents.size(), offset);
        const std::string known = local_sizes(described ? 0 : packed.size(), described ? 0 : part.contents.size());
        bytes_ += "PK\3\4" + fields(part) + little_endian(described ? 0 : crc) + known.substr(0, 8) +
                  name_lengths(part, known.substr(8)) + part.name + known.substr(8) + packed;
        if (described) {
            bytes_ += "PK\7\10" + little_endian(crc);
            bytes_ += zip64_.descriptor == Descriptor::long_sizes
                          ? little_endian64(packed.size()) + little_endian64(part.contents.size())
                          : little_endian(static_cast<std::uint32_t>(packed.size())) +
                                little_endian(static_cast<std::uint32_t>(part.contents.size()));
        }
    }

    /// A stored part of `size` zeros, of which no byte is written: what comes before it, and after that what follows it.
    std::string add_hole(const std::string& name, std::uint64_t size) {
        const ZipPart part = {name, "", false};
        const std::string known = local_sizes(size, size);
        list(part, 0, size, size, bytes_.size() + hole_bytes_);
        std::string before = std::exchange(bytes_, std::string()) + "PK\3\4" + fields(part) + little_endian(0) +
                             known.substr(0, 8) + name_lengths(part, known.substr(8)) + name + known.substr(8);
        hole_bytes_ += before.size() + size;
        return before;
    }

    std::string finish() {
        const std::uint64_t begin = bytes_.size() + hole_bytes_;
        const std::uint64_t record = begin + directory_.size();
        bytes_ += directory_;
        const std::string count = little_endian16(parts_);
        if (zip64_.end_record) {
            bytes_ += "PK\6\6" + little_endian64(44) + little_endian16(45) + little_endian16(45) + std::string(8, '\0') +
                      little_endian64(parts_) + little_endian64(parts_) + little_endian64(directory_.size()) +
                      little_endian64(begin);
            bytes_ += "PK\6\7" + little_endian(0) + little_endian64(record) + little_endian(1);
            const std::string every = little_endian16(0xFFFF);
            return bytes_ + "PK\5\6" + std::string(4, '\0') + every + every + little_endian(in_extra_field) +
                   little_endian(in_extra_field) + little_endian16(0);
        }
        return bytes_ + "PK\5\6" + std::string(4, '\0') + count + count +
               little_endian(static_cast<std::uint32_t>(directory_.size())) +
               little_endian(static_cast<std::uint32_t>(begin)) + little_endian16(0);
    }

private:
    std::string fields(const ZipPart& part) const {
        const std::uint16_t flags = zip64_.descriptor == Descriptor::none ? 0 : 8;
        return little_endian16(45) + little_endian16(flags) + little_endian16(part.deflated ? 8 : 0) +
               little_endian(0x21 << 16);
    }

    static std::string name_lengths(const ZipPart& part, const std::string& extra) {
        return little_endian16(static_cast<std::uint16_t>(part.name.size())) +
               little_endian16(static_cast<std::uint16_t>(extra.size()));
    }

    /// The two sizes of a local header, and its extra field.
    std::string local_sizes(std::uint64_t packed, std::uint64_t size) const {
        return zip64_.local
                   ? little_endian(in_extra_field) + little_endian(in_extra_field) +
                         extra_field(little_endian64(size) + little_endian64(packed))
                   : little_endian(static_cast<std::uint32_t>(packed)) + little_endian(static_cast<std::uint32_t>(size));
    }

    void list(const ZipPart& part, std::uint32_t crc, std::uint64_t packed, std::uint64_t size, std::uint64_t offset) {
        const bool all = zip64_.all_in_directory && zip64_.directory_sizes;
        const std::string sizes = zip64_.directory_sizes ? little_endian64(size) + little_endian64(packed) : "";
        const std::string place = zip64_.directory_offset || all ? little_endian64(offset) : "";
        const std::string extra = extra_field(sizes + place + (all ? little_endian(0) : ""));
        directory_ += "PK\1\2" + little_endian16(45) + fields(part) + little_endian(crc) +
                      little_endian(zip64_.directory_sizes ? in_extra_field : static_cast<std::uint32_t>(packed)) +
                      little_endian(zip64_.directory_sizes ? in_extra_field : static_cast<std::uint32_t>(size)) +
                      name_lengths(part, extra) + std::string(10, '\0') +
                      little_endian(zip64_.directory_offset ? in_extra_field : static_cast<std::uint32_t>(offset)) +
                      part.name + extra;
        ++parts_;
    }

    Zip64 zip64_;
    std::string bytes_;
    std::uint64_t hole_bytes_ = 0;  // of the file before `bytes_`
    std::string directory_;
    std::uint16_t parts_ = 0;
};

std::vector<ZipPart> cube_parts(bool deflated) {
    std::vector<ZipPart> parts = {
        content_types(), relationships(), {"3D/3dmodel.model", model_text(object(1, cube_mesh()), item(1))}};
    for (ZipPart& part : parts) {
        part.deflated = deflated;
    }
    return parts;
}

std::string zip64_package(const Zip64& zip64, bool deflated) {
    Zip64Writer writer(zip64);
    for (const ZipPart& part : cube_parts(deflated)) {
        writer.add(part);
    }
    return writer.finish();
}

TEST_CASE("3MF packages are read with every combination of ZIP64 fields", "[input][3mf]") {
    const TempFolder dir;
    for (unsigned bits = 0; bits < 64; ++bits) {
        for (const Descriptor descriptor : {Descriptor::none, Descriptor::short_sizes, Descriptor::long_sizes}) {
            const Zip64 zip64 = {(bits & 1) != 0, (bits & 2) != 0,  (bits & 4) != 0,
                                 (bits & 8) != 0, (bits & 16) != 0, descriptor};
            const bool deflated = (bits & 32) != 0;
            const auto path = dir.write("a.3mf", zip64_package(zip64, deflated));
            const Result<MeshFile> mesh = read_mesh(path);
            INFO(words_of(zip64, deflated) << (mesh ? std::string() : mesh.error().message));
            REQUIRE(mesh.ok());
            CHECK(mesh->triangle_count == 12);
            CHECK(mesh->warnings.empty());
        }
    }
}

TEST_CASE("other bytes around a 3MF package with ZIP64 fields give a warning", "[input][3mf]") {
    const TempFolder dir;
    const std::string bytes = zip64_package({true, true, true}, true);
    const Result<MeshFile> mesh = read_mesh(dir.write("a.3mf", "before" + bytes + "after"));
    REQUIRE(mesh.ok());
    const std::string name = (dir / "a.3mf").string();
    CHECK(mesh->warnings == std::vector<std::string>{name + ": ignored 6 bytes before the zip archive",
                                                     name + ": ignored 5 bytes after the zip archive"});
}

TEST_CASE("a 3MF package with ZIP64 fields and any byte changed is read alike or refused", "[input][3mf]") {
    const TempFolder dir;
    const std::string bytes = zip64_package({true, true, true}, true);
    std::size_t refused = 0;
    for (std::size_t at = 0; at < bytes.size(); ++at) {
        std::string damaged = bytes;
        damaged[at] = static_cast<char>(damaged[at] ^ (1 << at % 8));
        const Result<MeshFile> mesh = read_mesh(dir.write("a.3mf", damaged));
        refused += mesh.ok() ? 0 : 1;
        CHECK((!mesh.ok() || mesh->triangle_count == 12));
    }
    CHECK(refused > bytes.size() / 2);
}

TEST_CASE("a zip directory that counts more than the file holds is refused", "[input][3mf]") {
    const TempFolder dir;
    const std::string bytes = zip64_package({true, true, true}, true);
    const std::size_t record = bytes.rfind("PK\6\6");
    const auto refusal_with = [&](std::size_t at, std::uint64_t number) {
        std::string damaged = bytes;
        damaged.replace(record + at, 8, little_endian64(number));
        const Error error = read_error(dir.write("a.3mf", damaged));
        CHECK(error.code == ErrorCode::malformed_mesh);
        return error.message.substr((dir / "a.3mf").string().size());
    };
    const std::uint64_t all = ~std::uint64_t{0};
    CHECK(refusal_with(24, all).find(": is ") == 0);
    CHECK(refusal_with(40, all) ==
          ": has a zip directory of 18446744073709551615 bytes, more than the 1048576 that are read");
    CHECK(refusal_with(40, (1 << 20) + 1) == ": has a zip directory of 1048577 bytes, more than the 1048576 that are read");
    CHECK(refusal_with(48, all).find(": is damaged: its zip directory, which the end record at byte ") == 0);

    std::string damaged = bytes;
    const std::string count(8, '\xEE');
    damaged.replace(record + 24, 16, count + count);
    CHECK(read_error(dir.write("a.3mf", damaged)).message.find(": is damaged: its zip directory") != std::string::npos);
}

/// The directory's entry of the first part of an archive, and an end record for it alone, as if both began at `offset`.
std::string lone_directory(const std::string& archive, const std::string& name, std::size_t offset) {
    const std::string entry = archive.substr(archive.find("PK\1\2"), 46 + name.size());
    return entry + "PK\5\6" + std::string(4, '\0') + little_endian16(1) + little_endian16(1) +
           little_endian(static_cast<std::uint32_t>(entry.size())) + little_endian(static_cast<std::uint32_t>(offset)) +
           little_endian16(0);
}

TEST_CASE("only the last end record of a zip archive is followed", "[input][3mf]") {
    const TempFolder dir;
    std::vector<ZipPart> parts = cube_parts(false);
    parts.push_back({"other", lone_directory(zip(parts), parts[0].name, 0), false});
    std::string bytes = zip(parts);
    const std::string other = lone_directory(bytes, parts[0].name, bytes.find(parts.back().contents));
    bytes.replace(bytes.find(parts.back().contents), other.size(), other);
    const std::size_t crc = bytes.rfind("PK\1\2") + 16;
    const auto sum =
        static_cast<std::uint32_t>(crc32(0, reinterpret_cast<const Bytef*>(other.data()), static_cast<uInt>(other.size())));
    bytes.replace(crc, 4, little_endian(sum));
    // Another time than in the local header, so that the other directory seems to fit its part better.
    bytes[bytes.rfind("PK\1\2") + 12] ^= 1;
    const Result<MeshFile> mesh = read_mesh(dir.write("a.3mf", bytes));
    INFO((mesh ? std::string() : mesh.error().message));
    REQUIRE(mesh.ok());
    CHECK(mesh->triangle_count == 12);
}

TEST_CASE("thousands of end records in a zip archive do not take long", "[input][3mf]") {
    const TempFolder dir;
    std::vector<ZipPart> parts = cube_parts(false);
    std::string records;
    for (int i = 0; i < 2900; ++i) {
        records +=
            "PK\5\6" + std::string(4, '\0') + little_endian16(0xFFFF) + little_endian16(0xFFFF) + std::string(10, '\0');
    }
    parts.push_back({"records", records, false});
    const auto path = dir.write("a.3mf", zip(parts));
    const double start = cpu_ms();
    CHECK(read_mesh(path).ok());
    CHECK(cpu_ms() - start < 2000);
}

TEST_CASE("a zip directory whose names collide does not take long", "[input][3mf]") {
    const TempFolder dir;
    // libzip's hash of a text is 33 times that of what precedes the last letter, and the letter: of "Ez" and "FY" the same.
    std::vector<ZipPart> parts = cube_parts(false);
    for (unsigned i = 0; i < 12'000; ++i) {
        std::string name;
        for (unsigned bit = 0; bit < 14; ++bit) {
            name += (i >> bit & 1U) != 0 ? "Ez" : "FY";
        }
        parts.push_back({name, "", false});
    }
    const auto path = dir.write("a.3mf", zip(parts));
    const double start = cpu_ms();
    CHECK(read_mesh(path).ok());
    CHECK(cpu_ms() - start < 5000);
    parts.resize(parts.size() + 3000, {std::string(28, 'x'), "", false});
    CHECK(read_error(dir.write("b.3mf", zip(parts))).message.find(": has a zip directory of ") != std::string::npos);
}

/// Writes `before`, leaves out `hole` bytes and writes `after`. Why it could not, or an empty string.
std::string write_sparse(const std::filesystem::path& path, const std::string& before, std::uint64_t hole,
                         const std::string& after) {
    constexpr std::int64_t most_bytes_on_disk = 64 << 20;
    std::ofstream file(path, std::ios::binary);
    file.write(before.data(), static_cast<std::streamsize>(before.size()));
    file.seekp(static_cast<std::streamoff>(before.size() + hole));
    file.write(after.data(), static_cast<std::streamsize>(after.size()));
    file.close();
    struct stat status {};
    if (!file || ::stat(path.c_str(), &status) != 0) {
        return std::string("the file system takes no file of over 4 GiB: ") + std::strerror(errno);
    }
    return status.st_blocks * 512 > most_bytes_on_disk ? "the file system has no sparse files" : "";
}

TEST_CASE("a 3MF package of over 4 GiB is read", "[input][3mf]") {
    constexpr std::uint64_t hole = (std::uint64_t{1} << 32) + 1000;
    const TempFolder dir;
    Zip64Writer writer({true, true, true});
    const std::vector<ZipPart> parts = cube_parts(true);
    writer.add(parts[0]);
    const std::string before = writer.add_hole("Metadata/hole.bin", hole);
    writer.add(parts[1]);
    writer.add(parts[2]);
    const auto path = dir / "large.3mf";
    if (const std::string reason = write_sparse(path, before, hole, writer.finish()); !reason.empty()) {
        WARN("skipped: " << reason);
        return;
    }
    ReadOptions options;
    options.map_file = true;
    const Result<MeshFile> mesh = read_mesh(path, options);
    INFO((mesh ? std::string() : mesh.error().message));
    REQUIRE(mesh.ok());
    CHECK(mesh->triangle_count == 12);
    CHECK(mesh->file_bytes > hole);
    CHECK(mesh->warnings.empty());
}

}  // namespace
}  // namespace lamella
