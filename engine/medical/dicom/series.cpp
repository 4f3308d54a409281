// A folder with one series of DICOM images, of which headers are read as far as the place of the image: up to PixelSpacing.
//
// Not by DCMTK, which overflows the stack on sequences nested deeply enough, logs by a logger of the whole process, and
// needs a dictionary that an environment variable finds. A header takes a file's first 64 KiB as a rule, and no recursion.
#include <cerrno>
#include <map>
#include <memory>
#include <system_error>

#include <zlib.h>

#include "base/guard.hpp"
#include "base/system/file.hpp"
#include "base/words.hpp"
#include "io/read/input_file.hpp"
#include "io/text/text.hpp"
#include "lamella/grid.hpp"
#include "medical/dicom/data_set.hpp"
#include "medical/geometry/common.hpp"

namespace lamella {

namespace {

constexpr std::size_t preamble_bytes = 132;
constexpr std::size_t first_window_bytes = std::size_t{1} << 16;
constexpr std::size_t largest_window_bytes = std::size_t{1} << 26;

/// Text of a file as part of a message: one line of limited length.
std::string one_line(const std::string& text) {
    return printable(std::string_view(text).substr(0, 64));
}

struct DicomHeader {
    std::string file;
    std::map<dicom::Tag, std::string> values{};  ///< as in the file, but numbers as text

    /// Throws Refused: malformed_mesh, "FILE: WHAT".
    [[noreturn]] void refuse(const std::string& what) const { refuse_image(file, what); }

    /// Without the spaces around; empty where the attribute is absent or empty.
    std::string text(dicom::Tag tag) const {
        const auto found = values.find(tag);
        return found == values.end() ? std::string() : std::string(trimmed(found->second, std::string_view("\0 ", 2)));
    }

    /// The same, or throws Refused, which names the attribute by `keyword`.
    std::string required_text(dicom::Tag tag, const char* keyword) const {
        std::string found = text(tag);
        if (found.empty()) {
            refuse(std::string("its header states no ") + keyword + " (" + hex_text(tag >> 16, 4) + "," + hex_text(tag, 4) +
                   ")");
        }
        return found;
    }

    /// Throws Refused unless the attribute has as many finite numbers.
    template <std::size_t count>
    std::array<double, count> numbers(dicom::Tag tag, const char* keyword) const {
        const std::string all = required_text(tag, keyword);
        const std::optional<std::vector<double>> found = parse_numbers(all, '\\');
        if (!found || found->size() != count) {
            refuse(std::string(keyword) + " is '" + one_line(all) + "', not " + counted(count, "number"));
        }
        std::array<double, count> numbers{};
        std::copy(found->begin(), found->end(), numbers.begin());
        return numbers;
    }

    std::uint64_t side(dicom::Tag tag, const char* keyword) const {
        const double count = numbers<1>(tag, keyword)[0];
        if (!(count >= 1 && count <= 65535)) {
            refuse(std::string(keyword) + " is " + exact_text(count));
        }
        return static_cast<std::uint64_t>(count);
    }
};

/// Inflates `data`, which may be cut off. Throws Refused.
std::string inflated(const DicomHeader& header, std::string_view data) {
    z_stream stream{};
    constexpr int raw_window = -15;
    if (::inflateInit2(&stream, raw_window) != Z_OK) {
        throw std::bad_alloc();
    }
    const std::unique_ptr<z_stream, int (*)(z_streamp)> ended(&stream, &::inflateEnd);
    // zlib's type is not const, but it does not write there.
    stream.next_in =
        reinterpret_cast<Bytef*>(const_cast<char*>(data.data()));  // NOLINT(cppcoreguidelines-pro-type-const-cast)
    stream.avail_in = static_cast<uInt>(data.size());
    std::string text;
    int answer = Z_OK;
    while (answer == Z_OK && text.size() < largest_window_bytes) {
        const std::size_t before = text.size();
        text.resize(before + first_window_bytes);
        stream.next_out = reinterpret_cast<Bytef*>(text.data() + before);
        stream.avail_out = static_cast<uInt>(first_window_bytes);
        answer = ::inflate(&stream, Z_SYNC_FLUSH);
        text.resize(text.size() - stream.avail_out);
    }
    if (answer != Z_OK && answer != Z_STREAM_END && answer != Z_BUF_ERROR) {
        header.refuse("damaged deflated data within its header");
    }
    return text;
}

struct Encoding {
    bool is_explicit = false;  ///< each element names the type of its value
    bool is_big_endian = false;
};

std::uint32_t number_at(std::string_view bytes, std::size_t at, std::size_t count, bool big_endian) noexcept {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < count; ++i) {
        value = value << 8 | static_cast<unsigned char>(bytes[big_endian ? at + i : at + count - 1 - i]);
    }
    return value;
}

dicom::Tag tag_at(std::string_view bytes, std::size_t at, bool big_endian) noexcept {
    return number_at(bytes, at, 2, big_endian) << 16 | number_at(bytes, at + 2, 2, big_endian);
}

/// An element of a data set up to its value: its tag, in explicit syntaxes two letters for its type, the length of its value
/// (PS3.5, chapter 7).
struct Element {
    dicom::Tag tag = 0;
    std::uint32_t length = 0;
    std::size_t value = 0;    ///< where it begins
    bool is_unknown = false;  ///< of type UN: within, all is implicit and little-endian
};

/// Nothing where the bytes end before its value. Throws Refused where there is no element. `file_offset`: of the first byte.
std::optional<Element> element_at(std::string_view bytes, std::size_t at, Encoding encoding, std::size_t file_offset,
                                  const DicomHeader& header) {
    // Types whose length takes four bytes, after two that mean nothing.
    static constexpr std::string_view long_types = "OB OD OF OL OV OW SQ SV UC UN UR UT UV";
    const bool big = encoding.is_big_endian;
    if (bytes.size() - at < 8) {
        return std::nullopt;
    }
    const dicom::Tag tag = tag_at(bytes, at, big);
    if (!encoding.is_explicit || tag >> 16 == 0xfffe) {
        return Element{tag, number_at(bytes, at + 4, 4, big), at + 8};
    }
    const std::string_view type = bytes.substr(at + 4, 2);
    if (!std::all_of(type.begin(), type.end(), [](char c) { return c >= 'A' && c <= 'Z'; })) {
        header.refuse("no DICOM element at byte " + std::to_string(file_offset + at));
    }
    if (long_types.find(type) == std::string_view::npos) {
        return Element{tag, number_at(bytes, at + 6, 2, big), at + 8};
    }
    return bytes.size() - at < 12 ? std::nullopt
                                  : std::optional(Element{tag, number_at(bytes, at + 8, 4, big), at + 12, type == "UN"});
}

/// Puts the elements of a data set that are wanted, up to `last`, into `header`. Returns where one follows that lies beyond;
/// nothing where the bytes end before. Throws Refused. A sequence of undefined length ends with an element of its own, and
/// so do its items. Without recursion: sequences may be nested as deeply as a file is long.
std::optional<std::size_t> collect(std::string_view bytes, Encoding encoding, std::size_t file_offset, dicom::Tag last,
                                   DicomHeader& header) {
    constexpr std::uint32_t undefined_length = 0xffffffff;
    constexpr std::uint32_t longest_value = 4096;  // longer ones are no texts or numbers that are used
    std::size_t open = 0;                          // sequences and items without an end so far
    std::size_t implicit_from = 0;                 // how many were open where what is unknown began
    for (std::size_t at = 0; bytes.size() - at >= 4;) {
        if (open == 0 && tag_at(bytes, at, encoding.is_big_endian) > last) {
            return at;
        }
        const std::optional<Element> element =
            element_at(bytes, at, implicit_from != 0 ? Encoding{} : encoding, file_offset, header);
        if (!element) {
            break;
        }
        const auto [tag, length, value, is_unknown] = *element;
        at = value;
        if (open > 0 && (tag == dicom::item_end || tag == dicom::sequence_end)) {
            --open;
            implicit_from = open < implicit_from ? 0 : implicit_from;
        } else if (length == undefined_length) {
            ++open;
            implicit_from = implicit_from == 0 && is_unknown ? open : implicit_from;
        } else if (length > bytes.size() - at) {
            break;
        } else {
            const bool is_number = tag == dicom::rows || tag == dicom::columns;
            if (open == 0 && is_number && (length == 2 || length == 4)) {
                header.values[tag] = std::to_string(number_at(bytes, value, length, encoding.is_big_endian));
            } else if (open == 0 && !is_number && length <= longest_value) {
                header.values[tag] = bytes.substr(value, length);
            }
            at += length;
        }
    }
    return std::nullopt;
}

/// Returns whether `bytes` reach beyond the header. Throws Refused.
bool parse(std::string_view bytes, DicomHeader& header) {
    const std::optional<std::size_t> meta_bytes =
        collect(bytes.substr(preamble_bytes), {.is_explicit = true}, preamble_bytes, dicom::last_of_file_meta, header);
    if (!meta_bytes) {
        return false;
    }
    const std::string syntax = header.text(dicom::transfer_syntax_uid);
    const std::size_t begin = preamble_bytes + *meta_bytes;
    const bool is_deflated = syntax == "1.2.840.10008.1.2.1.99";
    const std::string text = is_deflated ? inflated(header, bytes.substr(begin)) : std::string();
    const Encoding encoding{.is_explicit = !syntax.empty() && syntax != dicom::implicit_little_endian,
                            .is_big_endian = syntax == "1.2.840.10008.1.2.2"};
    return collect(is_deflated ? text : bytes.substr(begin), encoding, begin, dicom::pixel_spacing, header) ||
           header.text(dicom::sop_class_uid) == dicom::media_storage_directory;
}

/// Nothing where the file is no DICOM file: without "DICM" at byte 128. The transfer syntaxes of PS3.5: implicit and
/// explicit, of either byte order, deflated, and all that compress pixels only. Throws Refused (unreadable_file,
/// malformed_mesh) and std::bad_alloc.
std::optional<DicomHeader> read_dicom_header(const std::filesystem::path& path) {
    const InputFile file = require(InputFile::open(path));
    for (const std::size_t size : {first_window_bytes, largest_window_bytes}) {
        std::string bytes(std::min<std::uint64_t>(size, file.size()), '\0');
        require(file.read_at(0, std::as_writable_bytes(std::span(bytes))));
        if (bytes.size() < preamble_bytes || bytes.compare(preamble_bytes - 4, 4, "DICM") != 0) {
            return std::nullopt;
        }
        DicomHeader header{path_text(path)};
        if (parse(bytes, header)) {
            return header;
        }
        if (bytes.size() < size) {
            header.refuse("cut off within its DICOM header");
        }
    }
    refuse_image(path_text(path), "its DICOM header is longer than 64 MiB");
}

std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> files;
    std::error_code problem;
    if (!can_list(folder)) {
        refuse_unreadable(path_text(folder), ENAMETOOLONG);
    }
    std::filesystem::directory_iterator entry(folder, problem);
    for (; !problem && entry != std::filesystem::directory_iterator(); entry.increment(problem)) {
        std::error_code unknown;
        if (entry->is_regular_file(unknown)) {
            files.push_back(entry->path());
        }
    }
    if (problem) {
        refuse_unreadable(path_text(folder), problem.value());
    }
    std::sort(files.begin(), files.end());
    return files;
}

/// The images of the one series in a folder.
std::vector<DicomHeader> images_in(const std::filesystem::path& folder) {
    std::map<std::string, std::vector<DicomHeader>> series;
    bool any = false;
    for (const std::filesystem::path& file : files_in(folder)) {
        std::optional<DicomHeader> header = read_dicom_header(file);
        any = any || header;
        if (header && !header->text(dicom::rows).empty()) {
            const std::string uid = header->required_text(dicom::series_instance_uid, "SeriesInstanceUID");
            series[uid].push_back(*std::move(header));
        }
    }
    if (series.size() == 1) {
        return std::move(series.begin()->second);
    }
    if (series.empty()) {
        refuse_image(path_text(folder),
                     any ? "a folder with DICOM files, none of which is an image" : "a folder without DICOM files");
    }
    constexpr std::size_t most_listed = 20;
    std::string list;
    std::size_t listed = 0;
    for (const auto& [uid, images] : series) {
        if (listed++ == most_listed) {
            list += "; ...";
            break;
        }
        const std::string description = one_line(images.front().text(dicom::series_description));
        list += (listed == 1 ? " " : "; ") + one_line(uid) + (description.empty() ? "" : " '" + description + "'") + " (" +
                counted(images.size(), "slice") + ")";
    }
    refuse_image(path_text(folder), std::to_string(series.size()) + " DICOM series in the folder, and one is taken:" + list);
}

/// The plane of a slice.
struct Slice {
    const DicomHeader* header = nullptr;
    std::array<std::uint64_t, 2> size{};  ///< voxels along i, j
    std::array<double, 2> spacing_mm{};
    Direction along_i{};  ///< unit vectors
    Direction along_j{};
    Direction position{};
    double height = 0;  ///< along the normal
};

Slice slice_of(const DicomHeader& header) {
    const std::string frames = header.text(dicom::number_of_frames);
    if (!frames.empty() && frames != "1") {
        header.refuse("a DICOM file of several frames (" + one_line(frames) +
                      "), which is not read; convert it to a file a slice, or to NIfTI");
    }
    Slice slice;
    slice.header = &header;
    slice.size = {header.side(dicom::columns, "Columns"), header.side(dicom::rows, "Rows")};
    slice.position = header.numbers<3>(dicom::image_position_patient, "ImagePositionPatient");
    if (!(length(slice.position) <= largest_coordinate_mm)) {
        header.refuse("ImagePositionPatient lies farther than " + exact_text(largest_coordinate_mm) + " mm away");
    }
    const std::array<double, 6> along = header.numbers<6>(dicom::image_orientation_patient, "ImageOrientationPatient");
    slice.along_i = {along[0], along[1], along[2]};
    slice.along_j = {along[3], along[4], along[5]};
    for (Direction* const axis : {&slice.along_i, &slice.along_j}) {
        if (std::abs(length(*axis) - 1) > 1e-3) {
            header.refuse("ImageOrientationPatient holds no unit vectors");
        }
        *axis = scaled(*axis, 1 / length(*axis));
    }
    const auto [of_rows, of_columns] = header.numbers<2>(dicom::pixel_spacing, "PixelSpacing");
    slice.spacing_mm = {of_columns, of_rows};
    if (!(of_rows > 0 && of_columns > 0)) {
        header.refuse("PixelSpacing is not above 0");
    }
    return slice;
}

void require_alike(const Slice& slice, const Slice& first) {
    const auto frame = [](const Slice& of) { return of.header->text(dicom::frame_of_reference_uid); };
    const auto same = [](const Direction& a, const Direction& b) {
        constexpr double most = 1e-4;  // difference of unit vectors
        return std::equal(a.begin(), a.end(), b.begin(), [](double x, double y) { return std::abs(x - y) <= most; });
    };
    const char* const other = slice.size != first.size               ? "Rows and Columns"
                              : slice.spacing_mm != first.spacing_mm ? "PixelSpacing"
                              : !same(slice.along_i, first.along_i) || !same(slice.along_j, first.along_j)
                                  ? "ImageOrientationPatient"
                              : frame(slice) != frame(first) ? "FrameOfReferenceUID"
                                                             : nullptr;
    if (other != nullptr) {
        slice.header->refuse(std::string("other ") + other + " than " + first.header->file +
                             ", which is of the same series");
    }
}

/// All slices, sorted along the normal.
std::vector<Slice> sorted_slices(const std::vector<DicomHeader>& images) {
    std::vector<Slice> slices;
    slices.reserve(images.size());
    for (const DicomHeader& image : images) {
        Slice& slice = slices.emplace_back(slice_of(image));
        require_alike(slice, slices.front());
        slice.height = dot(cross(slices.front().along_i, slices.front().along_j), slice.position);
    }
    std::stable_sort(slices.begin(), slices.end(), [](const Slice& a, const Slice& b) { return a.height < b.height; });
    return slices;
}

void require_stacked(const std::vector<Slice>& slices) {
    constexpr double same_place_mm = 1e-4;
    // Headers state places with few decimals.
    constexpr double shift_mm = 0.02;      // a slice may lie so far aside of the others, and
    constexpr double shift_per_mm = 1e-4;  // so much farther for each mm above the first
    const Slice& first = slices.front();
    for (std::size_t i = 1; i < slices.size(); ++i) {
        const Slice& slice = slices[i];
        if (slice.height - slices[i - 1].height < same_place_mm) {
            slice.header->refuse("lies at the same place as " + slices[i - 1].header->file);
        }
        Direction step{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            step[axis] = slice.position[axis] - first.position[axis];
        }
        const double aside = std::max(std::abs(dot(step, first.along_i)), std::abs(dot(step, first.along_j)));
        if (aside > shift_mm + shift_per_mm * (slice.height - first.height)) {
            slice.header->refuse("sheared, as by a tilted gantry: the slice lies " +
                                 exact_text(std::round(1000 * aside) / 1000) + " mm aside of " + first.header->file);
        }
    }
}

}  // namespace

ImageGeometry read_dicom_folder(const std::filesystem::path& folder) {
    constexpr double even_share = 0.01;  // of the mean distance: so far slices may lie from even places
    const std::vector<DicomHeader> images = images_in(folder);
    const std::vector<Slice> slices = sorted_slices(images);
    require_stacked(slices);
    const Slice& first = slices.front();
    const double distance = slices.size() > 1
                                ? (slices.back().height - first.height) / static_cast<double>(slices.size() - 1)
                                : first.header->numbers<1>(dicom::slice_thickness, "SliceThickness")[0];
    const Direction normal = cross(first.along_i, first.along_j);
    ImageGeometry image = upright(first.header->file, {first.size[0], first.size[1], slices.size()},
                                  {scaled(first.along_i, first.spacing_mm[0]), scaled(first.along_j, first.spacing_mm[1]),
                                   scaled(normal, distance / length(normal))},
                                  first.position);
    DicomSeries& series = image.series.emplace();
    bool even = true;
    for (const Slice& slice : slices) {
        const double place = static_cast<double>(series.slices.size()) * distance;
        image.uneven_slices_mm.push_back(slice.height - first.height);
        even = even && std::abs(image.uneven_slices_mm.back() - place) <= even_share * distance;
        series.slices.push_back(
            {slice.header->file, slice.header->text(dicom::sop_class_uid), slice.header->text(dicom::sop_instance_uid)});
    }
    if (even) {
        image.uneven_slices_mm.clear();
    }
    for (const dicom::SeriesText& text : dicom::series_texts) {
        series.*text.text = first.header->text(text.tag);
    }
    return image;
}

}  // namespace lamella
