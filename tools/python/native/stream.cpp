// Files larger than memory: layers handed to Python in chunks, or written to a table, while the file is read.
#include <algorithm>
#include <filesystem>
#include <optional>
#include <vector>

#include "lamella/io/mesh_stream.hpp"
#include "lamella/medical/table.hpp"
#include "native.hpp"

namespace lamella::python {

namespace {

/// Layers that are together a result: some of a plan.
class Chunk {
public:
    void begin(const SliceInfo& info) {
        info_ = info;
        next_layer_ = info.first_layer;
    }
    bool empty() const noexcept { return layers_.empty(); }
    std::size_t bytes() const noexcept {
        return layers_.size() * sizeof(Layer) + contours_.size() * sizeof(Contour) + points_.size() * sizeof(Point);
    }
    std::size_t size() const noexcept { return layers_.size(); }

    void add(const LayerView& layer) {
        Layer own = layer;
        own.first_contour = contours_.size();
        for (Contour contour : layer.contours) {
            contour.first_point += points_.size() - layer.first_point;
            contour.parent += contour.parent < 0 ? 0 : static_cast<std::int64_t>(own.first_contour - layer.first_contour);
            contours_.push_back(contour);
        }
        points_.insert(points_.end(), layer.points.begin(), layer.points.end());
        for (Stitch stitch : layer.stitches) {
            stitch.layer = layers_.size();
            stitches_.push_back(stitch);
        }
        layers_.push_back(own);
    }

    /// The result, after which the chunk is empty and stands above it.
    SliceResult take() {
        SliceResult made;
        made.info = info_;
        made.info.first_layer = next_layer_;
        made.info.layers = layers_.size();
        made.info.contours = contours_.size();
        made.info.points = points_.size();
        made.info.stitches = stitches_.size();
        made.info.segments = 0;
        for (const Layer& layer : layers_) {
            made.info.segments += layer.segments;
        }
        const auto role = [&](Role role) {
            return static_cast<std::uint64_t>(
                std::count_if(contours_.begin(), contours_.end(), [role](const Contour& c) { return c.role == role; }));
        };
        made.info.holes = role(Role::hole);
        made.info.open_contours = role(Role::open);
        made.info.flat_contours = role(Role::flat);
        next_layer_ += layers_.size();
        made.info.options.planes.first_layer = made.info.first_layer;
        made.info.options.planes.end_layer = next_layer_;
        move_to(made.layers, layers_);
        move_to(made.contours, contours_);
        move_to(made.points, points_);
        move_to(made.stitches, stitches_);
        return made;
    }

private:
    template <class T>
    static void move_to(Array<T>& to, std::vector<T>& from) {
        to.resize_discarding(from.size());
        std::copy(from.begin(), from.end(), to.begin());
        from.clear();
    }

    SliceInfo info_;
    std::uint64_t next_layer_ = 0;
    std::vector<Layer> layers_;
    std::vector<Contour> contours_;
    std::vector<Point> points_;
    std::vector<Stitch> stitches_;
};

/// Whether a file can be read in pieces, and if so opened for that.
std::optional<MeshStream> opened(const std::string& path, std::uint64_t memory_bytes, double mm_per_unit) {
    Result<MeshStream> file =
        open_mesh(std::filesystem::path(path), {.memory_bytes = memory_bytes, .read = {.mm_per_unit = mm_per_unit}});
    if (!file && file.error().code == ErrorCode::invalid_argument) {
        return std::nullopt;
    }
    if (!file) {
        raise(file.error());
    }
    return std::move(file).value();
}

/// Slices to a sink whose calls may fail; the first failure ends the slice.
template <class Begin, class Take>
Result<SliceInfo> slice_to_sink(const MeshStream& file, const SliceOptions& options, Context context, const Begin& begin,
                                const Take& take) {
    bool goes_on = true;
    const auto guard = [&](const auto& call) noexcept {
        try {
            goes_on = goes_on && call();
        } catch (const std::exception&) {  // out of memory
            goes_on = false;
        }
    };
    const auto begins = [&](const SliceInfo& info) noexcept { guard([&] { return begin(info); }); };
    const auto takes = [&](const LayerView& layer) noexcept { guard([&] { return take(layer); }); };
    const auto stop = [&, asked = context.stop]() noexcept { return !goes_on || (asked && asked()); };
    context.stop = stop;
    Slicer slicer;
    return slicer.slice_to(LayerSink{.take = takes, .begin = begins}, file.view(), options, context);
}

/// The patient frame that a file states, in lower case, or None where it cannot be read in pieces.
py::object stated_frame(const std::string& path) {
    const std::optional<MeshStream> file = opened(path, 0, 0);
    return file ? py::object(text_of(std::string(name_of(file->about().patient_frame)))) : py::none();
}

/// Calls put(result) with one chunk after the other, each of at most so many layers and about so many bytes, in multiples of
/// `step` layers, until it returns False. Returns False where the file cannot be read in pieces.
bool stream_file(const std::string& path, double mm_per_unit, std::uint64_t memory_bytes, std::size_t most_layers,
                 std::size_t step, std::size_t most_bytes, const Asked& asked, const py::function& put) {
    const std::optional<MeshStream> file = opened(path, memory_bytes, mm_per_unit);
    if (!file) {
        return false;
    }
    Chunk chunk;
    bool is_wanted = true;
    bool raised = false;
    const auto hand_over = [&] {
        const py::gil_scoped_acquire acquired;
        try {
            is_wanted = put(HeldResult(chunk.take())).template cast<bool>();
        } catch (py::error_already_set& error) {
            error.restore();
            raised = true;
            is_wanted = false;
        }
        return is_wanted;
    };
    run(asked, [&](const Context& context) -> Result<SliceInfo> {
        const auto begin = [&](const SliceInfo& info) {
            chunk.begin(info);
            return true;
        };
        const auto take = [&](const LayerView& layer) {
            chunk.add(layer);
            const bool is_full = chunk.size() >= most_layers || chunk.bytes() >= most_bytes;
            return !is_full || chunk.size() % step != 0 || hand_over();
        };
        Result<SliceInfo> info = slice_to_sink(*file, asked.options, context, begin, take);
        if (info && !chunk.empty()) {
            hand_over();
        }
        if (raised || is_wanted) {
            return raised ? Result<SliceInfo>(Error{ErrorCode::cancelled, "cancelled"}) : std::move(info);
        }
        return SliceInfo();  // nobody wants more
    });
    return true;
}

bool stream_table(const std::string& path, double mm_per_unit, std::uint64_t memory_bytes, const std::string& to,
                  const std::string& name, bool islands, const Asked& asked) {
    const std::optional<MeshStream> file = opened(path, memory_bytes, mm_per_unit);
    if (!file) {
        return false;
    }
    run(asked, [&](const Context& context) -> Status {
        Result<LayerTableStream> table = LayerTableStream::begin(name, std::filesystem::path(to), nullptr, islands);
        if (!table) {
            return table.error();
        }
        const auto begin = [](const SliceInfo& /*info*/) { return true; };
        const auto take = [&](const LayerView& layer) {
            table->add(layer);
            return !table->failed();
        };
        const Result<SliceInfo> info = slice_to_sink(*file, asked.options, context, begin, take);
        return info || table->failed() ? table->finish() : Status(info.error());
    });
    return true;
}

}  // namespace

void define_stream(py::module_& module) {
    module.def("stream_file", &stream_file);
    module.def("stream_table", &stream_table);
    module.def("stated_frame", &stated_frame);
}

}  // namespace lamella::python
