#include "medical/hdf5/file_driver.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <new>

#include <hdf5.h>
#if H5_VERSION_GE(1, 13, 0)
#include <H5FDdevelop.h>
#endif

#include "medical/hdf5/handles.hpp"

namespace lamella {

namespace {

/// What open_file() is told.
struct FileInfo {
    Backing* backing;
    haddr_t columns_begin;
};

/// HDF5 casts it to its base and back.
struct OpenFile {
    H5FD_t base;  // first, as HDF5 sees nothing else
    FileInfo info;
    haddr_t tree_end;
    haddr_t columns_end;

    haddr_t end() const noexcept { return std::max(tree_end, columns_end); }
};

OpenFile& own(H5FD_t* file) noexcept {
    return *reinterpret_cast<OpenFile*>(file);
}
const OpenFile& own(const H5FD_t* file) noexcept {
    return *reinterpret_cast<const OpenFile*>(file);
}

H5FD_t* open_file(const char*, unsigned, hid_t access, haddr_t) {
    const void* const info = H5Pget_driver_info(access);
    if (info == nullptr) {
        return nullptr;
    }
    auto* const file = new (std::nothrow) OpenFile{};
    if (file == nullptr) {
        return nullptr;
    }
    std::memcpy(&file->info, info, sizeof file->info);
    return &file->base;
}

herr_t close_file(H5FD_t* file) {
    delete &own(file);
    return 0;
}

herr_t query_file(const H5FD_t*, unsigned long* flags) {
    *flags = 0;
    return 0;
}

/// In addresses of the file, as all that follows.
haddr_t place_in(H5FD_t* file, H5FD_mem_t what, hid_t, hsize_t bytes) {
    OpenFile& open = own(file);
    if (what == H5FD_MEM_DRAW) {
        open.columns_end = std::max(open.columns_end, open.info.columns_begin) + bytes;
        return open.columns_end - bytes;
    }
    if (bytes > open.info.columns_begin || open.tree_end > open.info.columns_begin - bytes) {
        return HADDR_UNDEF;
    }
    open.tree_end += bytes;
    return open.tree_end - bytes;
}

haddr_t end_of_addresses(const H5FD_t* file, H5FD_mem_t) {
    return own(file).end();
}

herr_t set_end_of_addresses(H5FD_t* file, H5FD_mem_t, haddr_t end) {
    if (own(file).columns_end == 0) {
        own(file).tree_end = end;
    }
    return 0;
}

haddr_t end_of_file(const H5FD_t* file, H5FD_mem_t) {
    return own(file).info.backing->size();
}

herr_t read_file(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t offset, std::size_t count, void* into) {
    return own(file).info.backing->read(offset, {static_cast<std::byte*>(into), count}) ? 0 : -1;
}

herr_t write_file(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t offset, std::size_t count, const void* from) {
    return own(file).info.backing->write(offset, {static_cast<const std::byte*>(from), count}) ? 0 : -1;
}

herr_t truncate_file(H5FD_t* file, hid_t, hbool_t) {
    own(file).info.backing->set_size(own(file).end());
    return 0;
}

H5FD_class_t driver_class() {
    H5FD_class_t driver{};
#if H5_VERSION_GE(1, 13, 0)
    driver.version = H5FD_CLASS_VERSION;
    driver.value = static_cast<H5FD_class_value_t>(513);  // of those left to others
#endif
    driver.name = "lamella";
    driver.maxaddr = static_cast<haddr_t>(std::numeric_limits<std::int64_t>::max());
    driver.fc_degree = H5F_CLOSE_STRONG;
    driver.fapl_size = sizeof(FileInfo);
    driver.open = open_file;
    driver.close = close_file;
    driver.query = query_file;
    driver.alloc = place_in;
    driver.get_eoa = end_of_addresses;
    driver.set_eoa = set_end_of_addresses;
    driver.get_eof = end_of_file;
    driver.read = read_file;
    driver.write = write_file;
    driver.truncate = truncate_file;
    return driver;
}

}  // namespace

bool SparseFile::read(std::uint64_t offset, std::span<std::byte> into) noexcept {
    while (!into.empty()) {
        const std::size_t within = offset % page_bytes;
        const std::size_t count = std::min(into.size(), page_bytes - within);
        const auto page = pages_.find(offset / page_bytes);
        if (page == pages_.end()) {
            std::memset(into.data(), 0, count);
        } else {
            std::memcpy(into.data(), page->second->data() + within, count);
        }
        into = into.subspan(count);
        offset += count;
    }
    return true;
}

bool SparseFile::write(std::uint64_t offset, std::span<const std::byte> bytes) noexcept {
    try {
        while (!bytes.empty()) {
            const std::size_t within = offset % page_bytes;
            const std::size_t count = std::min(bytes.size(), page_bytes - within);
            std::unique_ptr<Page>& page = pages_[offset / page_bytes];
            if (!page) {
                page = std::make_unique<Page>();
            }
            std::memcpy(page->data() + within, bytes.data(), count);
            bytes = bytes.subspan(count);
            offset += count;
            size_ = std::max(size_, offset);
        }
    } catch (const std::bad_alloc&) {
        failed_ = true;
    }
    return true;
}

std::uint64_t SparseFile::written_before(std::uint64_t end) const noexcept {
    const auto next = pages_.lower_bound((end + page_bytes - 1) / page_bytes);
    return next == pages_.begin() ? 0 : (std::prev(next)->first + 1) * page_bytes;
}

bool ReadOnlyFile::read(std::uint64_t offset, std::span<std::byte> into) noexcept {
    const std::size_t there = offset < begin_.size() ? begin_.size() - static_cast<std::size_t>(offset) : 0;
    const std::size_t count = std::min(there, into.size());
    std::copy_n(begin_.end() - static_cast<std::ptrdiff_t>(there), count, into.begin());
    std::memset(into.data() + count, 0, into.size() - count);
    return true;
}

BackedAccess::BackedAccess(Backing& backing, std::uint64_t columns_begin) {
    const H5FD_class_t driver = driver_class();
    const FileInfo info{&backing, columns_begin};
    driver_ = Handle(H5FDregister(&driver), H5FDunregister);
    properties_ = Handle(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    checked(H5Pset_driver(properties_.id(), driver_.id(), &info));
}

}  // namespace lamella
