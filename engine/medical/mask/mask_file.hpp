// The file of a mask: a header, then slices of voxels, compressed in pieces or not.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <new>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <zlib.h>

#include "lamella/medical/mask.hpp"

namespace lamella {

enum class MaskForm : std::uint8_t { nifti, nrrd, segmentation };

struct MaskLayout {
    MaskForm form = MaskForm::nifti;
    bool compressed = false;
    bool shares = false;  ///< bytes of which 255 stand for 1, not labels
    std::size_t voxel_bytes = 1;
    std::vector<std::string> names;  ///< of labels 1, 2, ...
};

/// By the end of the name. Throws Refused.
MaskLayout layout_of(const std::filesystem::path& path, std::span<const MaskPart> parts, bool shares);

/// Throws Refused where the format, or any, does not hold a mask of that size.
void require_mask_fits(const std::filesystem::path& path, const MaskLayout& layout, const ImageGeometry& image);

/// Everything before the voxels.
std::string mask_header(const MaskLayout& layout, const ImageGeometry& image);

/// A piece of a gzip member.
struct GzipPiece {
    std::vector<unsigned char> bytes;
    unsigned long crc = 0;
    std::uint64_t length = 0;  ///< of what it holds
};

/// Compresses what is appended to one piece, on any thread.
class GzipPieceMaker {
public:
    /// Throws std::bad_alloc, as all of it does.
    GzipPieceMaker() {
        constexpr int raw_window = -15;
        // Runs are what a mask consists of: matches at a distance cost ten times as much for a few per cent.
        if (::deflateInit2(&stream_, 6, Z_DEFLATED, raw_window, 8, Z_RLE) != Z_OK) {
            throw std::bad_alloc();
        }
    }

    ~GzipPieceMaker() { (void)::deflateEnd(&stream_); }

    GzipPieceMaker(const GzipPieceMaker&) = delete;
    GzipPieceMaker& operator=(const GzipPieceMaker&) = delete;

    void append(std::span<const unsigned char> data) {
        piece_.crc = ::crc32_z(piece_.crc, data.data(), data.size());
        piece_.length += data.size();
        // zlib takes at most 4 GB at a time.
        constexpr std::size_t most_bytes = std::size_t{1} << 30;
        for (; !data.empty(); data = data.subspan(std::min(most_bytes, data.size()))) {
            stream_.next_in =
                const_cast<unsigned char*>(data.data());  // NOLINT(cppcoreguidelines-pro-type-const-cast): zlib's type
            stream_.avail_in = static_cast<uInt>(std::min(most_bytes, data.size()));
            deflate(Z_NO_FLUSH);
        }
    }

    /// Once, at the end. `last`: the piece ends the member.
    GzipPiece finish(bool last) {
        deflate(last ? Z_FINISH : Z_SYNC_FLUSH);
        return std::move(piece_);
    }

private:
    /// Until zlib leaves room: it has then taken all input, and given all that the flush asks for.
    void deflate(int flush) {
        do {
            std::array<unsigned char, 1 << 14> room{};
            stream_.next_out = room.data();
            stream_.avail_out = static_cast<uInt>(room.size());
            (void)::deflate(&stream_, flush);
            piece_.bytes.insert(piece_.bytes.end(), room.data(), stream_.next_out);
        } while (stream_.avail_out == 0);
    }

    z_stream stream_{};
    GzipPiece piece_;
};

/// Begin and end of a gzip member, without a time, around pieces that hold so much in all.
inline constexpr std::string_view gzip_begin("\x1f\x8b\x08\0\0\0\0\0\0\xff", 10);
std::string gzip_end(unsigned long crc, std::uint64_t length);

}  // namespace lamella
