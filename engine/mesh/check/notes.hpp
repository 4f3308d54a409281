// Where the finders of faults record what they find.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <initializer_list>
#include <vector>

#include "base/parallel.hpp"
#include "lamella/mesh/check.hpp"
#include "mesh/check/grid_mesh.hpp"

namespace lamella {

using Findings = std::array<FaultFinding, fault_count>;

class Notes {
public:
    Notes(const GridMesh& mesh, std::size_t most, Findings& findings) noexcept
        : mesh_(mesh), most_(most), findings_(findings) {}

    std::size_t most() const noexcept { return most_; }

    /// Counts a fault; make() returns its FaultPlace, and is called for the first few only. Faults of a kind come in order.
    template <class Make>
    void add(Fault fault, Make make) {
        FaultFinding& finding = of(fault);
        ++finding.count;
        if (finding.places.size() < most_) {
            finding.places.push_back(make());
        }
    }

    /// One call of run(): search(begin, end, notes) for ranges of [0, count), each with notes of its own, which are added to
    /// these in the order of the ranges. So faults of a kind come in the order of the items.
    template <class Search>
    void in_ranges(std::size_t count, const Parallel& parallel, Search search) {
        constexpr std::size_t items_a_range = std::size_t{1} << 15;
        const std::size_t ranges = count / items_a_range + 1;
        std::vector<Findings> found(ranges);
        parallel.run(ranges, [&](std::size_t range, int) {
            Notes own(mesh_, most_, found[range]);
            search(count * range / ranges, count * (range + 1) / ranges, own);
        });
        for (const Findings& own : found) {
            add(own);
        }
    }

    /// The same for groups of items that follow one another and are alike(i, i - 1): judge(begin, end, notes) for each.
    template <class Alike, class Judge>
    void in_groups(std::size_t count, const Parallel& parallel, Alike alike, Judge judge) {
        in_ranges(count, parallel, [&](std::size_t first, std::size_t last, Notes& own) {
            while (first < last && first > 0 && alike(first, first - 1)) {
                ++first;  // belongs to the range before
            }
            for (std::size_t begin = first; begin < last;) {
                std::size_t end = begin + 1;
                while (end < count && alike(end, end - 1)) {
                    ++end;
                }
                judge(begin, end, own);
                begin = end;
            }
        });
    }

    FaultFinding& of(Fault fault) noexcept { return findings_[static_cast<std::size_t>(fault)]; }

    std::array<double, 3> mm(const GridVertex& vertex) const noexcept {
        return {vertex.x * mesh_.unit_mm, vertex.y * mesh_.unit_mm, vertex.z * mesh_.unit_mm};
    }

    /// At up to three vertices.
    FaultPlace at(std::initializer_list<std::uint32_t> vertices) const noexcept {
        FaultPlace place;
        place.point_count = 0;
        for (const std::uint32_t vertex : vertices) {
            place.points_mm[static_cast<std::size_t>(place.point_count++)] = mm(mesh_.vertices[vertex]);
        }
        return place;
    }

    FaultPlace at(const Face& face) const noexcept {
        FaultPlace place = at({face.corners[0], face.corners[1], face.corners[2]});
        place.triangles[0] = face.source;
        return place;
    }

private:
    void add(const Findings& other) {
        for (std::size_t fault = 0; fault < fault_count; ++fault) {
            std::vector<FaultPlace>& places = findings_[fault].places;
            const std::vector<FaultPlace>& more = other[fault].places;
            const std::size_t taken = std::min(more.size(), most_ - std::min(most_, places.size()));
            places.insert(places.end(), more.begin(), more.begin() + static_cast<std::ptrdiff_t>(taken));
            findings_[fault].count += other[fault].count;
        }
    }

    const GridMesh& mesh_;
    std::size_t most_;
    Findings& findings_;
};

}  // namespace lamella
