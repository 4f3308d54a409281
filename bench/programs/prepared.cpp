#include "prepared.hpp"

#include <cmath>

namespace lamella::bench {

namespace {

bool within(std::uint64_t found, std::uint64_t stated, double tolerance) {
    return std::abs(static_cast<double>(found) - static_cast<double>(stated)) <= tolerance * static_cast<double>(stated);
}

std::string differs(const char* what, std::uint64_t found, std::uint64_t stated) {
    return std::string(what) + ": " + std::to_string(found) + ", stated " + std::to_string(stated);
}

}  // namespace

Prepared::Prepared(const Case& wanted, std::shared_ptr<const Mesh> mesh)
    : mesh_(std::move(mesh)), plan_(wanted.plan(*mesh_)), failure_(check_case(wanted)) {}

SliceOptions Prepared::options(int threads) const {
    SliceOptions options;
    options.plan = plan_;
    options.control.threads = threads;
    return options;
}

std::uint64_t Prepared::result_bytes() const noexcept {
    return layer_count_ * sizeof(Layer) + contour_count_ * sizeof(Contour) + point_count_ * sizeof(Point);
}

std::string Prepared::check_case(const Case& wanted) {
    if (wanted.triangles != 0 && !within(mesh_->triangles(), wanted.triangles, 0.01)) {
        return differs("triangles", mesh_->triangles(), wanted.triangles);
    }
    if (wanted.known) {
        if (std::string failure = check_known(*wanted.known); !failure.empty()) {
            return failure;
        }
    }
    if (Status status = slice(mesh_->view(), options(1), workspace, result); !status) {
        return status.error().message;
    }
    if (Status status = validate(result); !status) {
        return status.error().message;
    }
    summary_ = result.summary;
    layer_count_ = result.layers.size();
    contour_count_ = result.contours.size();
    point_count_ = result.points.size();
    hash_ = hash_result(result);
    if (wanted.segments != 0 && !within(summary_.segments, wanted.segments, 0.05)) {
        return differs("segments", summary_.segments, wanted.segments);
    }
    return {};
}

std::string Prepared::check_known(const KnownAnswer& known) {
    SliceOptions exact = options(1);
    exact.plan = LayerPlan{UniformLayers{.layer_height_mm = 0.032, .first_height_mm = 0.008}};
    exact.unit_mm = 0.004;
    if (Status status = slice(mesh_->view(), exact, workspace, result); !status) {
        return status.error().message;
    }
    const std::pair<const char*, std::pair<std::uint64_t, std::uint64_t>> counts[] = {
        {"planes", {result.layers.size(), known.planes}},
        {"segments", {result.summary.segments, known.segments}},
        {"contours", {result.contours.size(), known.contours}},
        {"open contours", {result.summary.open_contours, known.open}},
    };
    for (const auto& [what, count] : counts) {
        if (count.first != count.second) {
            return differs(what, count.first, count.second);
        }
    }
    return {};
}

std::string Prepared::check(int threads) {
    if (!failure_.empty() || checked_.contains(threads)) {
        return failure_;
    }
    if (Status status = slice(mesh_->view(), options(threads), workspace, result); !status) {
        return status.error().message;
    }
    if (hash_result(result) != hash_) {
        return "the answer differs from that of one thread";
    }
    checked_.insert(threads);
    return {};
}

Prepared* Preparer::get(const Case& wanted) {
    if (prepared_ != nullptr && case_name_ == wanted.name) {
        return prepared_.get();
    }
    prepared_.reset();
    if (mesh_name_ != wanted.mesh_name) {
        mesh_.reset();
        Result<Mesh> made = wanted.mesh();
        if (!made) {
            failure_ = made.error().message;
            return nullptr;
        }
        mesh_ = std::make_shared<const Mesh>(std::move(made).value());
        mesh_name_ = wanted.mesh_name;
    }
    case_name_ = wanted.name;
    prepared_ = std::make_unique<Prepared>(wanted, mesh_);
    return prepared_.get();
}

}  // namespace lamella::bench
