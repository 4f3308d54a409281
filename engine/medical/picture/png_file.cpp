#include "medical/picture/png_file.hpp"

#include <new>
#include <string>

#include "base/guard.hpp"
#include "io/write/output_file.hpp"
#include "lamella/medical/picture.hpp"

#ifdef LAMELLA_HAS_PNG
#include <png.h>
#include <zlib.h>
#include <csetjmp>
#endif

namespace lamella {

#ifdef LAMELLA_HAS_PNG

namespace {

/// libpng leaves a call that fails by longjmp; nothing between here and there has a destructor.
[[noreturn]] void leave(png_structp png, png_const_charp) {
    png_longjmp(png, 1);
}

void ignore(png_structp, png_const_charp) {}

void append(png_structp png, png_bytep bytes, std::size_t count) {
    // OutputFile allocates when it is created only, and keeps its first error for commit().
    static_cast<OutputFile*>(png_get_io_ptr(png))->append({reinterpret_cast<const char*>(bytes), count});
}

void flush(png_structp) {}

/// Whether all went well. The only reason of a failure is want of memory.
bool encode(png_structp png, png_infop info, const Canvas& canvas) {
    if (setjmp(png_jmpbuf(png)) != 0) {  // NOLINT(cert-err52-cpp): how libpng reports errors
        return false;
    }
    png_set_IHDR(png, info, static_cast<png_uint_32>(canvas.width()), static_cast<png_uint_32>(canvas.height()), 8,
                 PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_UP);
    png_set_compression_level(png, 6);
    png_set_compression_strategy(png, Z_DEFAULT_STRATEGY);
    png_set_compression_mem_level(png, 8);
    png_set_compression_window_bits(png, 15);
    png_set_compression_buffer_size(png, std::size_t{1} << 16);
    png_write_info(png, info);
    for (int y = 0; y < canvas.height(); ++y) {
        png_write_row(png, canvas.row(y));
    }
    png_write_end(png, nullptr);
    return true;
}

}  // namespace

bool can_write_pictures() noexcept {
    return true;
}

void require_png(const std::filesystem::path&) {}

Status write_png(const Canvas& canvas, const std::filesystem::path& path) {
    Result<OutputFile> file = OutputFile::create(path);
    if (!file) {
        return file.error();
    }
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, leave, ignore);
    png_infop info = png == nullptr ? nullptr : png_create_info_struct(png);
    bool done = false;
    if (info != nullptr) {
        png_set_write_fn(png, &*file, append, flush);
        done = encode(png, info, canvas);
    }
    png_destroy_write_struct(&png, &info);
    if (!done) {
        throw std::bad_alloc();
    }
    return file->commit();
}

#else

bool can_write_pictures() noexcept {
    return false;
}

void require_png(const std::filesystem::path& path) {
    throw Refused{{ErrorCode::invalid_argument,
                   "cannot write '" + path.string() + "': this build of lamella is without PNG (libpng-dev)"}};
}

Status write_png(const Canvas&, const std::filesystem::path& path) {
    require_png(path);
    return {};
}

#endif

}  // namespace lamella
