// Projecting faces onto layers, as the list of its stages:
//
//     choose_frame             grid, planes   as slicing does
//     count_pieces                            faces that look up or down, and the slabs that they reach into
//     share_pieces                            pieces, by 8 bytes each, to the layers that they project to
//     build_layers                            for each layer: the border of its pieces, and the region within it
//     Placement::finish        result         layers to their place
#include "lamella/slabs.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/distribute.hpp"
#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "base/words.hpp"
#include "slicing/frame.hpp"
#include "slicing/grid/quantise.hpp"
#include "slicing/layer/layer_builder.hpp"
#include "slicing/planes/plane_set.hpp"
#include "slicing/result/layer_target.hpp"
#include "slicing/slabs/edge_sum.hpp"
#include "slicing/slabs/face_pieces.hpp"
#include "slicing/workspace.hpp"

namespace lamella {

namespace {

constexpr std::size_t most_tasks = std::size_t{1} << 12;     // of layers that look one way
constexpr std::size_t faces_a_range = std::size_t{1} << 14;  // counted between two stop requests
constexpr double edges_a_piece = 2;                          // that differ: most are shared by two pieces

/// By FaceSense.
template <class T>
using OfSenses = std::array<T, 2>;

struct PieceCounts {
    OfSenses<std::uint64_t> faces{};
    OfSenses<std::uint64_t> pieces{};
    std::uint64_t degenerate = 0;

    void add(const PieceCounts& other) noexcept {
        for (std::size_t sense = 0; sense < 2; ++sense) {
            faces[sense] += other.faces[sense];
            pieces[sense] += other.pieces[sense];
        }
        degenerate += other.degenerate;
    }
};

/// The scratch with which a thread builds layers.
struct SlabWorker {
    SlabWorker(const Memory* memory, const StopCheck& stop) : worker(memory, stop), sum(memory), given(memory) {}
    Worker worker;
    EdgeSum sum;
    LayerBuilder builder{worker};
    Vector<Path> given;
};

/// One call of slice_slabs().
class SlabSlicing {
public:
    SlabSlicing(const MeshView& mesh, const SlabOptions& options)
        : mesh_(mesh),
          options_(options),
          wanted_{options.top, options.bottom},
          mirrored_(mirrors(options.transform)),
          memory_limit_(options.memory_limit_bytes != 0 ? options.memory_limit_bytes : detail::usual_memory_limit()),
          parallel_(options.control),
          planes_(options.control.memory),
          slabs_{SliceResult(options.control.memory), SliceResult(options.control.memory)},
          placements_{Placement(options.control.memory), Placement(options.control.memory)} {}

    Slabs run() {
        parallel_.begin_stage(0.4, 5);
        const auto start = Clock::now();
        frame_ = choose_frame(mesh_, options_, options_.region, parallel_);
        build_planes(options_.plan, {}, frame_, memory_limit_, planes_);
        admit();
        Distributed<FacePiece> pieces = share_pieces();
        const double shared_ms = milliseconds_since(start);
        parallel_.begin_stage(0.95);
        build_layers(pieces);
        parallel_.begin_stage(0.99, 2);
        for (const FaceSense sense : {FaceSense::up, FaceSense::down}) {
            if (wants(sense)) {
                finish(sense, shared_ms, milliseconds_since(start) - shared_ms);
            }
        }
        parallel_.finish();
        return std::move(slabs_);
    }

private:
    static std::size_t index_of(FaceSense sense) noexcept { return static_cast<std::size_t>(sense); }
    SliceResult& result_of(FaceSense sense) noexcept { return sense == FaceSense::up ? slabs_.top : slabs_.bottom; }
    bool wants(FaceSense sense) const noexcept { return sense != FaceSense::none && wanted_[index_of(sense)]; }

    void admit();
    template <class Reader, class Use>
    std::uint64_t for_each_face(const Reader& read, std::size_t begin, std::size_t end, Use use) const;
    PieceCounts count_pieces() const;
    std::size_t tasks() const noexcept { return std::clamp<std::size_t>(planes_.size(), 1, most_tasks); }
    std::size_t task_of(PlaneIndex layer) const noexcept { return part_of_number(layer, planes_.size(), tasks()); }
    Distributed<FacePiece> share_pieces() const;
    void build_layers(Distributed<FacePiece>& pieces);
    void build_task(FaceSense sense, const Band& layers, std::span<FacePiece> pieces, SlabWorker& worker,
                    BandOutput& output);
    void build_layer(FaceSense sense, std::span<const FacePiece> pieces, SlabWorker& worker, BandOutput& output);
    PieceRing ring_of(const GridTriangle& face, FaceSense sense, PlaneIndex layer) const noexcept;
    void finish(FaceSense sense, double shared_ms, double built_ms);

    const MeshView& mesh_;
    const SlabOptions& options_;
    OfSenses<bool> wanted_;
    bool mirrored_;
    std::uint64_t memory_limit_;
    Parallel parallel_;
    PlaneSet planes_;
    Slabs slabs_;
    PieceCounts counts_;
    RegionRules rules_;
    SharedFrame frame_{};
    std::vector<Band> tasks_;
    OfSenses<Placement> placements_;
};

/// Counts the pieces, and refuses too many before they are stored.
void SlabSlicing::admit() {
    counts_ = count_pieces();
    const Bounds box = frame_.bounds;
    if (counts_.degenerate == mesh_.triangle_count) {
        if (!options_.allow_empty) {
            throw Refused{all_collapsed(mesh_.triangle_count, frame_.unit.mm)};
        }
        frame_.bounds = {};  // the box of nothing chooses no planes
        build_planes(options_.plan, {}, frame_, memory_limit_, planes_);
    }
    for (const FaceSense sense : {FaceSense::up, FaceSense::down}) {
        SliceSummary& summary = result_of(sense).summary;
        summary.unit_doublings = frame_.unit.doublings;
        std::copy_n(box.min_mm, 3, summary.min_mm);
        std::copy_n(box.max_mm, 3, summary.max_mm);
    }
    const std::uint64_t senses = (options_.top ? 1U : 0U) + (options_.bottom ? 1U : 0U);
    const std::uint64_t pieces = counts_.pieces[0] + counts_.pieces[1];
    const std::uint64_t bytes =
        senses * (planes_.size() * sizeof(Layer) + planes_.plane_of_listed().size() * sizeof(std::uint64_t)) +
        pieces * sizeof(FacePiece);
    if (bytes > memory_limit_) {
        throw Refused{{ErrorCode::result_too_large, counted(planes_.size(), "layer") + " with " + counted(pieces, "piece") +
                                                        " of faces need " + std::to_string(bytes) +
                                                        " bytes, more than the memory limit of " +
                                                        std::to_string(memory_limit_)}};
    }
}

/// Calls use(t, sense, slabs) for each of the faces [begin, end) that a wanted side sees. Returns how many are degenerate.
template <class Reader, class Use>
std::uint64_t SlabSlicing::for_each_face(const Reader& read, std::size_t begin, std::size_t end, Use use) const {
    std::uint64_t degenerate = 0;
    for (std::size_t t = begin; t < end; ++t) {
        if ((t - begin) % faces_a_range == 0) {
            parallel_.stop_if_asked();
        }
        const GridTriangle face = read(t);
        degenerate += is_degenerate(face) ? 1 : 0;
        if (const FaceSense sense = sense_of(face, mirrored_); wants(sense)) {
            use(t, sense, slabs_of(face, sense, planes_));
        }
    }
    return degenerate;
}

PieceCounts SlabSlicing::count_pieces() const {
    PerWorker<PieceCounts> counts(parallel_.workers_for(mesh_.triangle_count / faces_a_range));
    with_reader(mesh_, options_.transform, frame_.unit.mm, [&](const auto& read) {
        parallel_.run_ranges(mesh_.triangle_count, faces_a_range, [&](std::size_t begin, std::size_t end, int worker) {
            PieceCounts own;
            own.degenerate = for_each_face(read, begin, end, [&](std::size_t, FaceSense sense, SlabRange slabs) {
                own.faces[index_of(sense)] += slabs.first < slabs.last ? 1 : 0;
                own.pieces[index_of(sense)] += slabs.last - slabs.first;
            });
            counts[static_cast<std::size_t>(worker)].add(own);
        });
    });
    PieceCounts all;
    counts.for_each([&](const PieceCounts& own) { all.add(own); });
    return all;
}

/// Parts of the result: the tasks of upward faces, then those of downward ones.
Distributed<FacePiece> SlabSlicing::share_pieces() const {
    return with_reader(mesh_, options_.transform, frame_.unit.mm, [&](const auto& read) {
        const auto each = [&](std::size_t begin, std::size_t end, const auto& emit) {
            for_each_face(read, begin, end, [&](std::size_t t, FaceSense sense, SlabRange slabs) {
                for (PlaneIndex layer = slabs.first; layer < slabs.last; ++layer) {
                    emit(index_of(sense) * tasks() + task_of(layer), FacePiece{static_cast<std::uint32_t>(t), layer});
                }
            });
        };
        return distribute<FacePiece>(mesh_.triangle_count, 2 * tasks(), parallel_, each, options_.control.memory);
    });
}

void SlabSlicing::build_layers(Distributed<FacePiece>& pieces) {
    std::vector<std::unique_ptr<SlabWorker>> workers(static_cast<std::size_t>(parallel_.threads()));
    rules_ = options_.region;
    rules_.fill_rule = FillRule::positive;
    for (std::size_t task = 0; task < tasks(); ++task) {
        const auto first_of = [&](std::size_t t) { return (t * planes_.size() + tasks() - 1) / tasks(); };
        tasks_.push_back({static_cast<PlaneIndex>(first_of(task)), static_cast<PlaneIndex>(first_of(task + 1)), 0});
    }
    for (const FaceSense sense : {FaceSense::up, FaceSense::down}) {
        if (wants(sense)) {
            result_of(sense).layers.resize_discarding(planes_.size());
            placements_[index_of(sense)].begin(tasks_, tasks(), false, result_of(sense), parallel_.stop());
        }
    }
    parallel_.run(2 * tasks(), [&](std::size_t part, int number) {
        const FaceSense sense = part < tasks() ? FaceSense::up : FaceSense::down;
        if (!wants(sense)) {
            return;
        }
        auto& worker = workers[static_cast<std::size_t>(number)];
        if (worker == nullptr) {
            worker = std::make_unique<SlabWorker>(options_.control.memory, parallel_.stop());
            worker->sum.follow(parallel_.stop());
            worker->builder.rules = {&rules_, frame_.unit.mm, 0};
        }
        const std::size_t task = part % tasks();
        fill_band(placements_[index_of(sense)], task,
                  [&](BandOutput& output) { build_task(sense, tasks_[task], pieces.of(part), *worker, output); });
    });
}

void SlabSlicing::build_task(FaceSense sense, const Band& layers, std::span<FacePiece> pieces, SlabWorker& worker,
                             BandOutput& output) {
    if (layers.last - layers.first > 1) {
        std::sort(pieces.begin(), pieces.end(), [](const FacePiece& a, const FacePiece& b) { return a.layer < b.layer; });
    }
    for (PlaneIndex layer = layers.first; layer < layers.last; ++layer) {
        const auto past = std::find_if(pieces.begin(), pieces.end(), [&](const FacePiece& p) { return p.layer != layer; });
        const auto count = static_cast<std::size_t>(past - pieces.begin());
        build_layer(sense, pieces.first(count), worker, output);
        result_of(sense).layers[layer] = describe_layer(planes_, layer, count);
        pieces = pieces.subspan(count);
    }
}

void SlabSlicing::build_layer(FaceSense sense, std::span<const FacePiece> pieces, SlabWorker& worker, BandOutput& output) {
    worker.given.clear();
    if (!pieces.empty()) {
        worker.sum.begin(static_cast<std::size_t>(edges_a_piece * static_cast<double>(pieces.size())));
        with_reader(mesh_, options_.transform, frame_.unit.mm, [&](const auto& read) {
            for (const FacePiece& piece : pieces) {
                worker.sum.add(ring_of(read(piece.triangle), sense, piece.layer).points());
            }
        });
        worker.sum.link();
        std::size_t begin = 0;
        for (const std::size_t end : worker.sum.ring_ends()) {
            const std::span<const Point> ring = worker.sum.points().subspan(begin, end - begin);
            worker.given.push_back(given_path(ring));
            begin = end;
        }
    }
    if (worker.given.empty()) {
        output.add_empty_layer();
    } else {
        worker.builder.build_given(worker.given, output);
    }
}

PieceRing SlabSlicing::ring_of(const GridTriangle& face, FaceSense sense, PlaneIndex layer) const noexcept {
    const std::int32_t* const plane = planes_.heights() + layer;
    return sense == FaceSense::up ? PieceRing(face, sense, mirrored_, plane[0], plane[1])
                                  : PieceRing(face, sense, mirrored_, plane[-1], plane[0]);
}

void SlabSlicing::finish(FaceSense sense, double shared_ms, double built_ms) {
    SliceResult& result = result_of(sense);
    result.unit_mm = frame_.unit.mm;
    result.frame = options_.transform;
    result.plan = options_.plan;
    result.region = rules_;
    describe_plan(planes_, result);
    placements_[index_of(sense)].finish(parallel_, result);
    SliceSummary& summary = result.summary;
    summary.triangles = mesh_.triangle_count;
    summary.degenerate = counts_.degenerate;
    summary.crossed = counts_.faces[index_of(sense)];
    summary.segments = counts_.pieces[index_of(sense)];
    summary.threads = parallel_.threads();
    summary.ms.bucket = shared_ms;
    summary.ms.fill = built_ms;
    set_counts(placements_[index_of(sense)].contour_counts(), result);
}

void check_slab_options(const SlabOptions& options) {
    if (!options.top && !options.bottom) {
        throw Refused{{ErrorCode::invalid_argument, "neither top nor bottom is asked for"}};
    }
    if (!options.region.keeps_contours()) {
        throw Refused{{ErrorCode::invalid_argument,
                       "the pieces of a slab are united by a fill rule of their own; none can be asked for"}};
    }
    RegionRules rules = options.region;
    rules.fill_rule = FillRule::positive;
    rules.fill_from.clear();
    require(check_rules(rules));
}

}  // namespace

Result<Slabs> slice_slabs(const MeshView& mesh, const SlabOptions& options) noexcept {
    return guarded(options.control, [&]() -> Result<Slabs> {
        check_slab_options(options);
        return SlabSlicing(mesh, options).run();
    });
}

}  // namespace lamella
