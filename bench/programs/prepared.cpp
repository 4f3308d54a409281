#include "prepared.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <utility>

#include "base/parallel.hpp"
#include "lamella/array.hpp"

namespace lamella::bench {

namespace {

std::size_t copy_bytes = std::size_t{256} << 20;

double measure_copy(int threads) {
    Array<char> from;
    Array<char> to;
    from.resize_discarding(copy_bytes);
    to.resize_discarding(copy_bytes);
    std::memset(from.data(), 1, from.size());
    std::memset(to.data(), 2, to.size());
    const Parallel parallel({.threads = threads});
    std::vector<double> ms(9);
    for (double& took : ms) {
        took = ms_of([&] {
            parallel.run_ranges(from.size(), 1 << 20, [&](std::size_t begin, std::size_t end, int) {
                std::memcpy(to.data() + begin, from.data() + begin, end - begin);
            });
        });
    }
    return 2 * static_cast<double>(copy_bytes) / (median_of(ms) / 1000);
}

void require_near(const char* what, std::uint64_t found, std::uint64_t stated, double tolerance) {
    if (std::abs(static_cast<double>(found) - static_cast<double>(stated)) > tolerance * static_cast<double>(stated)) {
        fail(std::string(what) + ": " + std::to_string(found) + ", stated " + std::to_string(stated));
    }
}

}  // namespace

void set_copy_size(std::size_t bytes) {
    copy_bytes = bytes;
}

double copy_bandwidth(int threads) {
    static std::map<int, double> measured;
    const auto [at, fresh] = measured.try_emplace(threads, 0.0);
    if (fresh) {
        at->second = measure_copy(threads);
    }
    return at->second;
}

Prepared::Prepared(const Case& wanted, std::shared_ptr<const Mesh> mesh)
    : mesh_(std::move(mesh)), plan_(wanted.plan(*mesh_)) {
    if (wanted.triangles != 0) {
        require_near("triangles", mesh_->triangles(), wanted.triangles, 0.01);
    }
    if (wanted.known) {
        check_known(*wanted.known);
    }
    info_ = slice(1);
    const AuditOptions structure{.open = false, .volume = false, .ledger = false, .crossings = false, .structure = true};
    const Audit audited = checked(audit(result, MeshView{}, structure));
    if (!*audited.structure) {
        fail(audited.structure->error().message);
    }
    hash_ = result.hash();
    if (wanted.segments != 0) {
        require_near("segments", info_.segments, wanted.segments, 0.05);
    }
}

void Prepared::check_known(const KnownAnswer& known) {
    const SliceOptions exact{.layer_height_mm = 0.032, .planes = {.first_height_mm = 0.008}, .frame = {.grid_mm = 0.004}};
    const SliceInfo sliced = checked(slicer.slice_to(result, mesh_->view(), exact, {.threads = 1}));
    require_near("planes", sliced.layers, known.planes, 0);
    require_near("segments", sliced.segments, known.segments, 0);
    require_near("contours", sliced.contours, known.contours, 0);
    require_near("open contours", sliced.open_contours, known.open, 0);
}

void Prepared::check(int threads) {
    if (checked_.contains(threads)) {
        return;
    }
    slice(threads);
    if (result.hash() != hash_) {
        fail("the answer differs from that of one thread");
    }
    checked_.insert(threads);
}

Prepared& Preparer::get(const Case& wanted) {
    if (prepared_ == nullptr || case_name_ != wanted.name) {
        prepared_.reset();
        if (mesh_name_ != wanted.mesh_name) {
            mesh_.reset();
            mesh_name_.clear();
            mesh_ = std::make_shared<const Mesh>(wanted.mesh());
            mesh_name_ = wanted.mesh_name;
        }
        prepared_ = std::make_unique<Prepared>(wanted, mesh_);
        case_name_ = wanted.name;
    }
    return *prepared_;
}

}  // namespace lamella::bench
