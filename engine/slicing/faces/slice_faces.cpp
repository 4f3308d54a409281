// Projecting faces onto layers, as the list of its stages:
//
//     choose_frame             grid, planes   as slicing does
//     count_pieces                            faces that look up or down, and the slabs that they reach into
//     share_pieces                            pieces, by 8 bytes each, to the layers that they project to
//     build_layers                            for each layer: the border of its pieces, and the region within it
//     LayerTarget::finish      result         layers to their place

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "base/distribute.hpp"
#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "base/sort.hpp"
#include "base/words.hpp"
#include "slicing/faces/face_pieces.hpp"
#include "slicing/grid/quantise.hpp"
#include "slicing/layer/layer_builder.hpp"
#include "slicing/result/layer_target.hpp"
#include "slicing/slice_layers.hpp"

namespace lamella {

namespace {

constexpr std::size_t most_tasks = std::size_t{1} << 12;     // of layers
constexpr std::size_t faces_a_range = std::size_t{1} << 14;  // counted between two stop requests
constexpr double edges_a_piece = 2;                          // that differ: most are shared by two pieces

struct PieceCounts {
    std::uint64_t faces = 0;
    std::uint64_t pieces = 0;
    std::uint64_t degenerate = 0;

    void add(const PieceCounts& other) noexcept {
        faces += other.faces;
        pieces += other.pieces;
        degenerate += other.degenerate;
    }
};

/// The scratch with which a thread builds layers.
struct FaceWorker {
    FaceWorker(const Parallel& parallel, InstructionSet instructions)
        : worker(parallel.memory(), parallel.stop(), instructions) {}
    Worker worker;
    EdgeSum sum{worker};
    LayerBuilder builder{worker};
    Vector<Path> given{worker.memory()};
};

class FaceSlicing {
public:
    FaceSlicing(const MeshView& mesh, const SliceCall& call)
        : mesh_(mesh),
          call_(call),
          placing_(placing_of(mesh, call.options.frame)),
          sense_(call.options.content == LayerContent::upward_faces ? FaceSense::up : FaceSense::down),
          mirrored_(mirrors(placing_.transform)),
          parallel_(call.context),
          planes_(call.context.memory),
          rules_(working_rules(call.options)) {}

    void slice(LayerTarget* target, SliceInfo& info) {
        parallel_.begin_stage(0.4, 5);
        const auto start = Clock::now();
        outline(info);
        if (target == nullptr) {
            return;
        }
        target->admit_layers(layers_.size(), info);
        Distributed<FacePiece> pieces = share_pieces();
        info.ms.bucket = milliseconds_since(start);
        const auto shared = Clock::now();
        parallel_.begin_stage(0.95);
        build_layers(pieces, *target, info);
        info.ms.fill = milliseconds_since(shared);
        parallel_.finish();
    }

private:
    /// Up to the count of pieces. Refuses too many before they are stored.
    void outline(SliceInfo& info) {
        const SliceOptions& options = call_.options;
        frame_ = choose_frame(mesh_, options.frame, options.allow_empty, rules_, parallel_);
        begin_info(options, frame_.bounds, frame_.unit, info);
        info.options.region = rules_;
        plan_layers();
        PieceCounts counts = count_pieces();
        if (counts.degenerate == mesh_.triangle_count) {
            if (!options.allow_empty) {
                throw Refused{all_collapsed(mesh_.triangle_count, frame_.unit.mm)};
            }
            frame_.bounds = {};  // the box of nothing chooses no planes
            plan_layers();
        }
        describe_plan(planes_, call_.tuning.random_heights.has_value(), info);
        info.layers = layers_.size();
        info.first_layer = layers_.first;
        info.triangles = mesh_.triangle_count;
        info.degenerate = counts.degenerate;
        info.crossed = counts.faces;
        info.segments = counts.pieces;
        info.threads = parallel_.threads();
        check_size(counts.pieces);
    }

    /// All planes of the plan, since a piece lies between two of them, and the layers that are asked for.
    void plan_layers() {
        const PlaneOptions& asked = call_.options.planes;
        planes_.build(call_.options, call_.tuning.random_heights, frame_, call_.memory_limit());
        layers_ = planes_.range_of(asked.first_layer, asked.end_layer);
    }
    std::size_t tasks() const noexcept { return std::clamp<std::size_t>(layers_.size(), 1, most_tasks); }
    std::size_t task_of(PlaneIndex layer) const noexcept {
        return part_of_number(layer - layers_.first, layers_.size(), tasks());
    }

    void check_size(std::uint64_t pieces) const {
        const std::uint64_t limit = call_.memory_limit();
        const std::uint64_t bytes = layers_.size() * sizeof(Layer) +
                                    planes_.plane_of_listed().size() * sizeof(std::uint64_t) + pieces * sizeof(FacePiece);
        if (bytes > limit) {
            throw Refused{{ErrorCode::result_too_large,
                           counted(layers_.size(), "layer") + " with " + counted(pieces, "piece") + " of faces need " +
                               std::to_string(bytes) + " bytes, more than the memory limit of " + std::to_string(limit)}};
        }
    }

    /// Calls use(t, layers) for each of the faces [begin, end) that look the way asked for and project to some. Returns how
    /// many are degenerate.
    template <class Reader, class Use>
    std::uint64_t for_each_face(const Reader& read, std::size_t begin, std::size_t end, Use use) const {
        std::uint64_t degenerate = 0;
        for (std::size_t t = begin; t < end; ++t) {
            if ((t - begin) % faces_a_range == 0) {
                parallel_.stop_if_asked();
            }
            const GridTriangle face = read(t);
            degenerate += is_degenerate(face) ? 1 : 0;
            if (sense_of(face, mirrored_) == sense_) {
                const SlabRange all = slabs_of(face, sense_, planes_);
                const SlabRange asked{std::max(all.first, layers_.first), std::min(all.last, layers_.end)};
                if (asked.first < asked.last) {
                    use(t, asked);
                }
            }
        }
        return degenerate;
    }

    PieceCounts count_pieces() const {
        PerWorker<PieceCounts> counts(parallel_.workers_for(mesh_.triangle_count / faces_a_range));
        with_reader(mesh_, placing_, frame_.unit.mm, [&](const auto& read) {
            parallel_.run_ranges(mesh_.triangle_count, faces_a_range, [&](std::size_t begin, std::size_t end, int worker) {
                PieceCounts own;
                own.degenerate = for_each_face(read, begin, end, [&](std::size_t, SlabRange slabs) {
                    ++own.faces;
                    own.pieces += slabs.last - slabs.first;
                });
                counts[static_cast<std::size_t>(worker)].add(own);
            });
        });
        PieceCounts all;
        counts.for_each([&](const PieceCounts& own) { all.add(own); });
        return all;
    }

    Distributed<FacePiece> share_pieces() const {
        return with_reader(mesh_, placing_, frame_.unit.mm, [&](const auto& read) {
            const auto each = [&](std::size_t begin, std::size_t end, const auto& emit) {
                for_each_face(read, begin, end, [&](std::size_t t, SlabRange slabs) {
                    for (PlaneIndex layer = slabs.first; layer < slabs.last; ++layer) {
                        emit(task_of(layer), FacePiece{static_cast<std::uint32_t>(t), layer});
                    }
                });
            };
            return distribute<FacePiece>(mesh_.triangle_count, tasks(), parallel_, each, parallel_.memory());
        });
    }

    void build_layers(Distributed<FacePiece>& pieces, LayerTarget& target, SliceInfo& info) {
        std::vector<std::unique_ptr<FaceWorker>> workers(static_cast<std::size_t>(parallel_.threads()));
        for (std::size_t task = 0; task < tasks(); ++task) {
            const auto first_of = [&](std::size_t t) { return (t * layers_.size() + tasks() - 1) / tasks(); };
            tasks_.push_back({static_cast<PlaneIndex>(first_of(task)), static_cast<PlaneIndex>(first_of(task + 1)), 0});
        }
        piece_counts_.resize_discarding(layers_.size());
        const auto layer_at = [this](PlaneIndex layer) {
            return describe_layer(planes_, layers_.first + layer, piece_counts_[layer]);
        };
        const LayerRules layer_rules{.region = &rules_, .grid_mm = frame_.unit.mm};
        const OutputPlan plan{.layers = layers_.size(),
                              .layer_at = layer_at,
                              .segments = 0,  // how many points pieces leave is not known
                              .cutting = 0,
                              .bands = tasks_,
                              .parallel = parallel_,
                              .scratch = call_.kept.output,
                              .origins = false,
                              .info = info};
        target.begin(plan);
        fill_bands(target, parallel_, 0, tasks(), [&](std::size_t task, int number, BandOutput& output) {
            auto& worker = workers[static_cast<std::size_t>(number)];
            if (worker == nullptr) {
                worker = std::make_unique<FaceWorker>(parallel_, call_.kept.instructions);
                worker->builder.rules = &layer_rules;
            }
            build_task(tasks_[task], pieces.of(task), *worker, output);
        });
        parallel_.begin_stage(0.99, 2);
        target.finish();
    }

    void build_task(const Band& layers, std::span<FacePiece> pieces, FaceWorker& worker, BandOutput& output) {
        if (layers.last - layers.first > 1) {
            sort_briefly(pieces.begin(), pieces.end(),
                         [](const FacePiece& a, const FacePiece& b) { return a.layer < b.layer; });
        }
        for (PlaneIndex number = layers.first; number < layers.last; ++number) {
            const PlaneIndex layer = layers_.first + number;
            const auto past =
                std::find_if(pieces.begin(), pieces.end(), [&](const FacePiece& p) { return p.layer != layer; });
            const auto count = static_cast<std::size_t>(past - pieces.begin());
            piece_counts_[number] = count;
            build_layer(pieces.first(count), worker, output);
            output.finish_layer();
            pieces = pieces.subspan(count);
        }
    }

    void build_layer(std::span<const FacePiece> pieces, FaceWorker& worker, BandOutput& output) const {
        worker.given.clear();
        if (!pieces.empty()) {
            worker.sum.begin(static_cast<std::size_t>(edges_a_piece * static_cast<double>(pieces.size())));
            with_reader(mesh_, placing_, frame_.unit.mm, [&](const auto& read) {
                for (const FacePiece& piece : pieces) {
                    worker.sum.add(ring_of(read(piece.triangle), piece.layer).points());
                }
            });
            worker.sum.link();
            std::size_t begin = 0;
            for (const std::size_t end : worker.sum.ring_ends()) {
                worker.given.push_back(given_path(worker.sum.points().subspan(begin, end - begin)));
                begin = end;
            }
        }
        if (worker.given.empty()) {
            output.add_empty_layer();
        } else {
            worker.builder.read_given(worker.given);
            worker.builder.build(output);
        }
    }

    PieceRing ring_of(const GridTriangle& face, PlaneIndex layer) const noexcept {
        const std::int32_t* const plane = planes_.heights() + layer;
        return sense_ == FaceSense::up ? PieceRing(face, sense_, mirrored_, plane[0], plane[1])
                                       : PieceRing(face, sense_, mirrored_, plane[-1], plane[0]);
    }

    const MeshView& mesh_;
    const SliceCall& call_;
    Placing placing_;
    FaceSense sense_;
    bool mirrored_;
    Parallel parallel_;
    PlaneSet planes_;
    PlaneRange layers_{};
    RegionRules rules_;
    SharedFrame frame_{};
    std::vector<Band> tasks_;
    Array<std::uint64_t> piece_counts_{parallel_.memory()};  // of each layer that was built
};

}  // namespace

void check_faces(const Source& from, const SliceOptions& options) {
    const auto refuse = [](const char* why) { throw Refused{{ErrorCode::invalid_argument, why}}; };
    if (from.prepared() != nullptr || from.is_parts()) {
        refuse("faces are projected from one mesh in memory, not from a prepared one or from parts");
    }
    if (options.origins) {
        refuse("the pieces of a face are united: their contours have no origins");
    }
    const RegionRules& rules = options.region;
    const bool positive = rules.fill_rule == FillRule::positive && rules.fill_from.empty();  // as a result of faces says
    if (!rules.keeps_contours() && !positive) {
        refuse("the pieces of a slab are united by a fill rule of their own; none can be asked for");
    }
}

void slice_faces(const MeshView& mesh, const SliceCall& call, LayerTarget* target, SliceInfo& info) {
    FaceSlicing(mesh, call).slice(target, info);
}

}  // namespace lamella
